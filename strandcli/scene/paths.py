"""Settings of a scene by their dotted paths, items of lists by their numbers."""

from __future__ import annotations

import dataclasses
from typing import Any

from .fields import settings_of
from .specs import ModelSpec


def value_at(node: Any, path: str) -> Any:
    """The value at a path; None where there is none, or a part of the way to it is absent."""
    for part in path.split("."):
        if node is None:
            return None
        node = node[int(part)] if isinstance(node, tuple) else getattr(node, part, None)
    return node


def with_value(node: Any, path: str, value: Any) -> Any:
    """The same with another value at a path, which is not validated; a mapping on the way that is absent is made."""
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
