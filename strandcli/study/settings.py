"""Scenes with a few settings changed, by their dotted paths."""

from __future__ import annotations

import dataclasses
from typing import Any

from ..scene.fields import settings_of
from ..scene.model import Scene
from ..scene.paths import made, with_value
from ..scene.specs import ChoiceSpec
from .points import Parameters


def changed(scene: Scene, settings: Parameters) -> Scene:
    """A scene with settings at dotted paths replaced, items of lists by their number. Values are not validated."""
    for path, value in settings.items():
        scene = with_value(scene, path, value)
    return scene


def knows(scene: Scene, path: str, value: Any = None) -> bool:
    """Whether a scene has a setting at a dotted path, and where that is one of a few words, ``value`` (not None)."""
    node: Any = scene
    spec = None
    for part in path.split("."):
        if isinstance(node, tuple):
            if not part.isdecimal() or int(part) >= len(node):
                return False
            node = node[int(part)]
            continue
        cls: Any = type(node)
        settings = settings_of(cls) if dataclasses.is_dataclass(node) else {}
        if part not in settings:
            return False
        spec = settings[part].spec
        inner = getattr(node, settings[part].attribute)
        node = made(node, part) if inner is None else inner
    return value is None or not isinstance(spec, ChoiceSpec) or value in spec.options
