"""What `quality: draft | default | best` stands for: one table, for presets, `--set` and `strandcli bench`."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from .fields import ChoiceSpec, ItemsSpec, ModelSpec, Spec, UnionSpec, settings_of
from .model import Scene

SHADOWED = "lights.*.shadow"
"""Stands for the shadow map of every light that has one."""
QUALITIES: Mapping[str, Mapping[str, Any]] = {
    "draft": {"curves.level": 1, "curves.tolerance": 4.0, "image.supersample": 1},
    "default": {"curves.level": 2, "curves.tolerance": 1.0, "image.supersample": 2},
    "best": {"curves.level": 4, "curves.tolerance": 0.25, "image.supersample": 4},
}


def settings_for(name: str, scene: Scene) -> dict[str, Any]:
    """The settings of a quality by the paths that a scene has, those of lights by their numbers."""
    shadowed = [i for i, light in enumerate(scene.lights) if light.shadow.model != "off"]
    return dict(expanded(name, shadowed))


def expanded(name: str, shadowed: list[int]) -> Iterator[tuple[str, Any]]:
    """The settings of a quality that this program has; ``shadowed``: numbers of the lights that have a shadow map.
    Nothing for a name that is no quality."""
    for path, value in QUALITIES.get(name, {}).items():
        if not path.startswith(SHADOWED):
            if _known(ModelSpec(Scene), path.split("."), value):
                yield path, value
            continue
        for i in shadowed:
            own = path.replace("*", str(i), 1)
            if _known(ModelSpec(Scene), own.split("."), value):
                yield own, value


def _known(spec: Spec, parts: list[str], value: Any) -> bool:
    if not parts:
        return not isinstance(spec, ChoiceSpec) or value in spec.options
    if isinstance(spec, ItemsSpec):
        return all(_known(ModelSpec(kind), parts[1:], value) for kind in spec.kinds.values())
    if isinstance(spec, UnionSpec) or not isinstance(spec, ModelSpec):
        return False
    settings = settings_of(spec.model)
    return parts[0] in settings and _known(settings[parts[0]].spec, parts[1:], value)
