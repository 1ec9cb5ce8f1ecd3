"""What `quality: draft | default | best` stands for: one table, for presets, `--set` and `strandcli bench`.

The settings are points of the fronts that `strandcli study PRESET --axis end-to-end` finds: one frame of 2,000 strands
and some 30,000 pixels, the whole drawing on one thread of a 2.45 GHz server, against 16×16 samples a pixel and curves
within 1/20 of a sample; root mean square error and signed bias as shares of the picture's mean.

| quality | `hair`: time, error, bias | `fur`: time, error, bias |
|---|---|---|
| draft | 26 ms, 27 %, +.7 % | 13 ms, 25 %, +6.4 % |
| default | 52 ms, 9.9 %, +.6 % | 39 ms, 7.3 %, +1.6 % |
| best | 134 ms, 4.7 %, +.1 % | 121 ms, 4.0 %, +1.1 % |

Beyond: 3×3 samples stand between the last two (86 ms, 6.6 %); 6×6 double the time of best for no less error in `hair`
with two levels of curves (249 ms, 4.7 %). A coarser tolerance than 1/4 saves no time worth its error at 2×2 samples,
because there it is pixels that cost. The error of a shadow map's model is no part of this: see `--axis shadow`.
Lines of no width become thinner with more samples; give strands a `material.width`, as the study does.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from .fields import ChoiceSpec, ItemsSpec, ModelSpec, Spec, UnionSpec, settings_of
from .model import Scene

SHADOWED = "lights.*.shadow"
"""Stands for the shadow map of every light that has one."""
QUALITIES: Mapping[str, Mapping[str, Any]] = {
    "draft": {"curves.level": 1, "curves.tolerance": 4.0, "image.supersample": 1},
    "default": {"curves.level": 2, "curves.tolerance": 0.25, "image.supersample": 2},
    "best": {"curves.level": 4, "curves.tolerance": 0.25, "image.supersample": 4},
}


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
