"""Helpers that declare settings of a preset beside the fields of a dataclass.

``strands: int = integer(10_000, low=1, doc="number of strands")`` declares a dataclass field with a default, and tells
the validator, the JSON Schema and the documentation the rest. Rules declare their parameters with the same helpers.

Ranges: ``low`` and ``high`` may be reached, ``above`` and ``below`` may not. A trailing underscore in a field's name is
not part of its key (``with_`` is written ``with``).
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from functools import cache
from types import MappingProxyType
from typing import Any, NamedTuple

from ..common.registry import Registry
from .specs import (
    MOST_ITEMS,
    BooleanSpec,
    ChoiceSpec,
    ColourSpec,
    FileSpec,
    IntegerSpec,
    ItemsSpec,
    MapSpec,
    ModelSpec,
    NamesSpec,
    NumberSpec,
    PanelsSpec,
    ParametersSpec,
    Range,
    RulesSpec,
    SizeSpec,
    Spec,
    TextSpec,
    UnionSpec,
    VectorSpec,
    WindowSpec,
)

Vector = tuple[float, float, float]
Colour = tuple[float, float, float]


def _field(spec: Spec) -> Any:
    return dataclasses.field(default=spec.default, metadata={"spec": spec})


def number(
    default: float | None,
    *,
    low: float | None = None,
    above: float | None = None,
    below: float | None = None,
    high: float | None = None,
    unit: str = "",
    doc: str = "",
) -> Any:
    """A field that is a finite float."""
    limits = Range(low=low, above=above, below=below, high=high)
    return _field(NumberSpec(default, limits=limits, unit=unit, doc=doc))


def integer(
    default: int | None, *, low: int | None = None, high: int | None = None, unit: str = "", doc: str = ""
) -> Any:
    """A field that is an int."""
    return _field(IntegerSpec(default, limits=Range(low=low, high=high), unit=unit, doc=doc))


def vector(
    default: Vector | None,
    *,
    low: float | None = None,
    above: float | None = None,
    below: float | None = None,
    high: float | None = None,
    nonzero: bool = False,
    unit: str = "",
    doc: str = "",
) -> Any:
    """A field that is three finite floats; the range holds for each of them."""
    limits = Range(low=low, above=above, below=below, high=high)
    return _field(VectorSpec(default, limits=limits, nonzero=nonzero, unit=unit, doc=doc))


def colour(default: Colour | None, *, or_none: bool = False, doc: str = "") -> Any:
    """A field that is a linear Rec. 709 colour, or with ``or_none`` perhaps `NO_COLOUR`."""
    return _field(ColourSpec(default, or_none=or_none, doc=doc))


def size(default: tuple[int, int], *, high: int, unit: str = "px", doc: str = "") -> Any:
    """A field that is a width and a height."""
    return _field(SizeSpec(default, limits=Range(low=1, high=high), unit=unit, doc=doc))


def window(*, high: int, unit: str = "px", doc: str = "") -> Any:
    """A field that is part of a picture, or None, which is its default."""
    return _field(WindowSpec(None, limits=Range(low=0, high=high), unit=unit, doc=doc))


def choice(
    default: str, options: tuple[str, ...] | Registry, *, doc: str = "", removed: Mapping[str, str] | None = None
) -> Any:
    """A field that is one of a few words, or one of the names in a registry; ``removed``: of `ChoiceSpec`."""
    return _field(ChoiceSpec(default, options, doc=doc, removed=removed))


def boolean(default: bool, *, doc: str = "") -> Any:
    """A field that is true or false."""
    return _field(BooleanSpec(default, doc=doc))


def text(default: str, *, doc: str = "") -> Any:
    """A field that is text."""
    return _field(TextSpec(default, doc=doc))


def file(kind: str, default: str | None = "", *, doc: str = "", numbered: bool = False) -> Any:
    """A field that is the path of a file of a kind, or may be that of ``numbered`` ones; it has to be given, or with a
    default of None may be absent."""
    return _field(FileSpec(default, kind=kind, doc=doc, numbered=numbered))


def surface_map(*, doc: str = "") -> Any:
    """A field that is an attribute of a mesh or the path of a picture; by default neither."""
    return _field(MapSpec("", doc=doc))


def names(default: tuple[str, ...] = (), *, doc: str = "") -> Any:
    """A field that is a tuple of names."""
    return _field(NamesSpec(default, doc=doc))


def model(cls: type, *, doc: str = "") -> Any:
    """A field that is an instance of ``cls``, by default with all its defaults."""
    return _field(ModelSpec(cls, cls(), doc=doc))


def optional(cls: type, *, doc: str = "") -> Any:
    """A field that is an instance of ``cls`` or None, which is its default."""
    return _field(ModelSpec(cls, doc=doc))


def union(default: Any, kinds: Mapping[str, type], *, doc: str = "") -> Any:
    """A field that is an instance of one of several classes, each with its own ``kind``."""
    return _field(UnionSpec(default, MappingProxyType(dict(kinds)), doc=doc))


def items(
    of: type | Mapping[str, type], *, default: tuple[Any, ...] = (), most: int = MOST_ITEMS, doc: str = ""
) -> Any:
    """A field that is a tuple of instances of a class, or of classes told apart by ``kind``, ``most`` at the most."""
    # not a copy: kinds that are added later count as well
    kinds = {"": of} if isinstance(of, type) else of
    return _field(ItemsSpec(default, MappingProxyType(kinds), most=most, doc=doc))


def parameters(registry: Registry, chooser: str, *, doc: str = "") -> Any:
    """A field that holds the settings of the driver that the field ``chooser`` of the same class names."""
    return _field(ParametersSpec(registry, chooser, doc=doc))


def rules(*, doc: str = "") -> Any:
    """The field that holds a scene's rules."""
    return _field(RulesSpec((), doc=doc))


def panels(*, doc: str = "") -> Any:
    """The field that holds a scene's variants."""
    return _field(PanelsSpec((), doc=doc))


class Setting(NamedTuple):
    """One setting of a class: the key in YAML, the attribute in Python, and what it may be."""

    key: str
    attribute: str
    spec: Spec


@cache
def settings_of(cls: type) -> Mapping[str, Setting]:
    """The settings of a dataclass by key, in order. Fields made without these helpers are not settings."""
    found = (
        Setting(field.name.removesuffix("_"), field.name, field.metadata["spec"])
        for field in dataclasses.fields(cls)
        if "spec" in field.metadata
    )
    return MappingProxyType({setting.key: setting for setting in found})
