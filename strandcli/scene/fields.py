"""Helpers that declare settings of a preset beside the fields of a dataclass.

``strands: int = integer(10_000, low=1, doc="number of strands")`` declares a dataclass field with a default, and tells
the validator, the JSON Schema and the documentation the rest. Rules declare their parameters with the same helpers.

Each helper takes what the spec takes that it is named after. A trailing underscore in a field's name is not part of its
key (``with_`` is written ``with``). `value_at` and `with_value` reach settings of a scene by their dotted paths.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from functools import cache
from types import MappingProxyType
from typing import Any, NamedTuple, ParamSpec

from . import specs
from .specs import ModelSpec

Given = ParamSpec("Given")
Vector = tuple[float, float, float]
Colour = tuple[float, float, float]


def _declares(spec: Callable[Given, specs.Spec]) -> Callable[Given, Any]:
    """A helper that declares a field with what a spec's class takes."""

    def field(*args: Given.args, **given: Given.kwargs) -> Any:
        made = spec(*args, **given)
        return dataclasses.field(default=made.default, metadata={"spec": made})

    field.__doc__ = spec.__doc__
    return field


number = _declares(specs.NumberSpec)
integer = _declares(specs.IntegerSpec)
vector = _declares(specs.VectorSpec)
colour = _declares(specs.ColourSpec)
size = _declares(specs.SizeSpec)
window = _declares(specs.WindowSpec)
choice = _declares(specs.ChoiceSpec)
boolean = _declares(specs.BooleanSpec)
text = _declares(specs.TextSpec)
file = _declares(specs.FileSpec)
surface_map = _declares(specs.MapSpec)
names = _declares(specs.NamesSpec)
optional = _declares(specs.ModelSpec)
union = _declares(specs.UnionSpec)
items = _declares(specs.ItemsSpec)
parameters = _declares(specs.ParametersSpec)
rules = _declares(specs.RulesSpec)
panels = _declares(specs.PanelsSpec)


def model(cls: type, *, doc: str = "") -> Any:
    """A field that is an instance of ``cls``, by default with all its defaults."""
    return optional(cls, cls(), doc=doc)


class Setting(NamedTuple):
    """One setting of a class: the key in YAML, the attribute in Python, and what it may be."""

    key: str
    attribute: str
    spec: specs.Spec


@cache
def settings_of(cls: type) -> Mapping[str, Setting]:
    """The settings of a dataclass by key, in order. Fields made without these helpers are not settings."""
    found = (
        Setting(field.name.removesuffix("_"), field.name, field.metadata["spec"])
        for field in dataclasses.fields(cls)
        if "spec" in field.metadata
    )
    return MappingProxyType({setting.key: setting for setting in found})


def value_at(node: Any, path: str) -> Any:
    """The value at a path; None where there is none, or a part of the path to it is absent."""
    for part in path.split("."):
        if node is None:
            return None
        node = node[int(part)] if isinstance(node, tuple) else getattr(node, part, None)
    return node


def with_value(node: Any, path: str, value: Any) -> Any:
    """The same with another value at a path, which is not validated; a mapping on the path that is absent is made."""
    head, _, rest = path.partition(".")
    if isinstance(node, tuple):
        index = int(head)
        inner = with_value(node[index], rest, value) if rest else value
        return (*node[:index], inner, *node[index + 1 :])
    if rest:
        inner = getattr(node, head)
        value = with_value(made(node, head) if inner is None else inner, rest, value)
    return dataclasses.replace(node, **{head: value})


def made(node: Any, key: str) -> Any:
    """The mapping of a key that may be absent, with all its defaults; None for a key of another kind."""
    cls: Any = type(node)
    setting = settings_of(cls).get(key)
    return setting.spec.model() if setting is not None and isinstance(setting.spec, ModelSpec) else None
