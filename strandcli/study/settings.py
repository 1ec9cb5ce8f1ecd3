"""Scenes with a few settings changed, by their dotted paths."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

from ..scene.fields import settings_of
from ..scene.model import AmbientOcclusion, Children, Detail, Scene
from ..scene.specs import ChoiceSpec
from .points import Knobs

ABSENT: Mapping[str, Any] = {"detail": Detail, "ambient_occlusion": AmbientOcclusion, "children": Children}
"""Parts of a scene that may be absent, and that knobs may bring in."""


def silhouette(scene: Scene) -> Scene:
    """A scene whose picture is what strands cover of each pixel: white strands in even light before black, alone."""
    plain = {"colour": (1.0, 1.0, 1.0), "tip_colour": None, "colour_variation": 0.0, "specular": 0.0, "pigment": "rgb",
             "eumelanin": None, "pheomelanin": None, "grey": 0.0}  # fmt: skip
    settings: dict[str, Any] = {f"material.{key}": value for key, value in plain.items()}
    settings |= {"image.background": (0.0, 0.0, 0.0), "image.horizon": None, "ambient": (1.0, 1.0, 1.0)}
    settings |= {"lights": (), "solids": (), "environment": None}
    return changed(scene, {path: value for path, value in settings.items() if knows(scene, path)})


def changed(scene: Scene, settings: Knobs) -> Scene:
    """A scene with settings at dotted paths replaced, items of lists by their number. Values are not validated."""
    for path, value in settings.items():
        scene = _replaced(scene, path.split("."), value)
    return scene


def _replaced(node: Any, parts: list[str], value: Any) -> Any:
    if not parts:
        return value
    head, rest = parts[0], parts[1:]
    if isinstance(node, tuple):
        index = int(head)
        return (*node[:index], _replaced(node[index], rest, value), *node[index + 1 :])
    inner = getattr(node, head)
    if inner is None and rest and head in ABSENT:
        inner = ABSENT[head]()
    return dataclasses.replace(node, **{head: _replaced(inner, rest, value)})


def knows(scene: Scene, path: str, value: Any = None) -> bool:
    """Whether a scene has a setting at a dotted path, and where that is one of a few words, ``value`` (not None)."""
    node: Any = scene
    spec, before = None, ""
    for part in path.split("."):
        if isinstance(node, tuple):
            if not part.isdecimal() or int(part) >= len(node):
                return False
            node = node[int(part)]
            continue
        if node is None and before in ABSENT:
            node = ABSENT[before]()
        before = part
        cls: Any = type(node)
        known = dataclasses.is_dataclass(node)
        settings = settings_of(cls) if known else {}
        if part not in settings:
            return False
        spec = settings[part].spec
        node = getattr(node, settings[part].attribute)
    return value is None or not isinstance(spec, ChoiceSpec) or value in spec.options


def value_at(scene: Scene, path: str) -> Any:
    """The setting at a dotted path; None where there is none."""
    node: Any = scene
    for part in path.split("."):
        node = node[int(part)] if isinstance(node, tuple) else getattr(node, part, None)
    return node
