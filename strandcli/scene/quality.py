"""What `quality: draft | default | best` stands for: one table, for presets, `--set` and `strandcli bench`.

The settings are points of the fronts that `strandcli study PRESET --axis end-to-end` finds over resolver, shadow model,
samples and tolerance: one frame of 2,000 strands and some 30,000 pixels, the whole drawing on one thread of a 2.45 GHz
server, against 16×16 samples a pixel, curves within 1/20 of a sample and opacity maps of 29 layers; time, and root mean
square error as a share of the picture's mean.

| quality | `hair` | `portrait` | `fur` | `grass` |
|---|---|---|---|---|
| draft | 17 ms, 24 % | 22 ms, 103 % | 9 ms, 17 % | 7 ms, 21 % |
| default | 34 ms, 8.1 % | 49 ms, 6.7 % | 18 ms, 5.9 % | 9 ms, 2.3 % |
| best | 149 ms, 3.1 % | 95 ms, 2.5 % | 65 ms, 2.7 % | 46 ms, 2.0 % |

All have opacity maps: min/max maps save a tenth of the time and leave `hair` at 29 % however fine all else is, 8 % too
bright. A draft shows who is in front by the z-buffer, for half of the time of sorting or less; strands as thin as those
of `portrait`, 1/17 of a pixel here, it draws far too wide. Beyond: with 2×2 sorted samples errors are 4.3 % and 3.5 %
in `hair` and `portrait`, for two thirds of the time of best; 6×6 samples of a z-buffer leave 2.9 % in `hair`, for 1.3
times the time, and 35 % in `portrait`. A tolerance of 4 instead of 1/4 saves nothing and leaves 14 % of `hair` at any
number of samples. Lines of no width become thinner with more samples; give strands a `material.width`, as the study
does.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from .fields import ChoiceSpec, ItemsSpec, ModelSpec, Spec, UnionSpec, settings_of
from .model import Scene

SHADOWED = "lights.*.shadow"
"""Stands for the shadow map of every light that has one."""
DEEP: Mapping[str, Any] = {f"{SHADOWED}.model": "opacity"}
QUALITIES: Mapping[str, Mapping[str, Any]] = {
    "draft": {**DEEP, "image.resolver": "zbuffer", "curves.level": 2, "curves.tolerance": 1.0, "image.supersample": 1},
    "default": {
        **DEEP, "image.resolver": "sorted", "curves.level": 2, "curves.tolerance": 0.25, "image.supersample": 1
    },
    "best": {**DEEP, "image.resolver": "sorted", "curves.level": 4, "curves.tolerance": 0.25, "image.supersample": 3},
}  # fmt: skip


def settings_for(name: str, scene: Scene) -> dict[str, Any]:
    """The settings of a quality by the paths that a scene has, those of lights by their numbers."""
    return dict(expanded(name, shadowed(scene)))


def shadowed(scene: Scene) -> list[int]:
    """Numbers of the lights that have a shadow map."""
    return [i for i, light in enumerate(scene.lights) if light.shadow.model != "off"]


def expanded(name: str, lights: list[int]) -> Iterator[tuple[str, Any]]:
    """The settings of a quality that this program has; ``lights``: numbers of the lights that have a shadow map.
    Nothing for a name that is no quality."""
    for path, value in QUALITIES.get(name, {}).items():
        if not path.startswith(SHADOWED):
            if _known(ModelSpec(Scene), path.split("."), value):
                yield path, value
            continue
        for i in lights:
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
