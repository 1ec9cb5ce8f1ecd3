"""What `quality: draft | default | best` stands for: one table, for presets, `--set` and `strandcli bench`.

The settings are points of the fronts that `strandcli study PRESET --axis end-to-end` finds over resolver, shadow model,
samples, tolerance and level of detail: one frame of the first 2,000 of the strands that are drawn, children included,
and some 30,000 pixels, the whole drawing on one thread of a 2.45 GHz server, against 16×16 samples a pixel, curves
within 1/20 of a sample and opacity maps of 29 layers; time, and root mean square error as a share of the picture's
mean.

| quality | `hair` | `portrait` | `fur` | `grass` |
|---|---|---|---|---|
| draft | 62 ms, 21 % | 59 ms, 31 % | 27 ms, 3.2 % | 13 ms, 1.3 % |
| default | 149 ms, 5.9 % | 208 ms, 5.3 % | 46 ms, 1.6 % | 13 ms, 1.1 % |
| best | 268 ms, 3.8 % | 323 ms, 4.2 % | 148 ms, 0.4 % | 59 ms, 0.7 % |

All sort and have opacity maps. A z-buffer draws strands as thin as these far too wide: 111 % in `hair`, and 33 % with
6×6 samples, in more time than best. Min/max maps save nothing that shows, and leave 24 % in `hair` and 55 % in
`portrait` however fine all else is. A draft thins out what is less than a quarter of a sample wide; at half a sample
errors are 36 % and 49 % for a third less time. Children are bent so finely that a tolerance of 4 in place of 1/4
hardly adds to their error: most in `grass`, 1.3 % in place of 1.1 %. 2×2 samples stand between the last two: 4.4 % and
4.7 %. Lines of no width become thinner with more samples and are never thinned out; give strands a `material.width`,
as the study does.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from .fields import ChoiceSpec, ItemsSpec, ModelSpec, Spec, UnionSpec, settings_of
from .model import Scene

SHADOWED = "lights.*.shadow"
"""Stands for the shadow map of every light that has one."""
FINE: Mapping[str, Any] = {"image.resolver": "sorted", f"{SHADOWED}.model": "opacity"}
QUALITIES: Mapping[str, Mapping[str, Any]] = {
    "draft": {
        **FINE, "curves.level": 2, "curves.tolerance": 1.0, "image.supersample": 1, "detail.pixels": 0.25
    },
    "default": {**FINE, "curves.level": 2, "curves.tolerance": 0.25, "image.supersample": 1},
    "best": {**FINE, "curves.level": 4, "curves.tolerance": 0.25, "image.supersample": 3},
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
