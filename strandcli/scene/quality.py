"""What `quality: draft | default | best` and `look: source` stand for, for presets, options and `bench`.

All three are near the front that `strandcli study PRESET --axis quality` finds over samples, tolerance and level of
detail: windows of the first frame with all of its strands, 800×600, processor seconds of the whole drawing on one
thread of a 2.45 GHz server, against 16×16 samples a pixel, curves within 1/20 of a sample and opacity maps of 29
layers; time, and root mean square error as a share of the mean light where strands are.

| quality | `hair` | `ponytail` | `fur` | `grass` |
|---|---|---|---|---|
| draft | 0.8 s, 37 % | 1.0 s, 26 % | 0.8 s, 18 % | 2.2 s, 16 % |
| default | 1.6 s, 11.2 % | 3.0 s, 9.0 % | 1.4 s, 6.7 % | 3.0 s, 8.7 % |
| best | 4.5 s, 6.8 % | 4.2 s, 5.4 % | 3.1 s, 3.9 % | 4.5 s, 4.0 % |

2×2 samples stand between the last two: 8.8 %, 6.9 %, 5.1 % and 5.3 %. Fewer than 16 pieces a segment keep no tolerance
where blades are near: with 4, `grass` is 12.7 % off in the same time.

All sort and have opacity maps. The first 2,000 strands of `hair` alone, in a small picture (`--axis end-to-end`): a
z-buffer draws strands as thin as these far too wide, 111 %, and 33 % with 6×6 samples, in more time than best. Min/max
maps save nothing that shows, and leave 24 % in `hair` and 55 % in `portrait` however fine all else is.

`draft` is for looking at motion, light and colour. It never costs more than the preset does by itself under these
resolver and shadow models: half of the children, half again as wide; strands thinner than .75 of a sample thinned out
and widened; smaller opacity maps of fewer layers; coarser occlusion; fewer pictures a frame for lens and shutter.

Lines of no width become thinner with more samples and are never thinned out; give strands a `material.width`, as the
study does.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Container, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from .faults import Mark, shown
from .fields import value_at, with_value
from .model import Scene


class AtMost(NamedTuple):
    """The preset's own number, or this where it is greater or absent."""

    limit: float

    def of(self, own: float | None) -> float | None:
        return self.limit if own is None else min(own, self.limit)

    def __str__(self) -> str:
        return f"at most {self.limit:,g}"


class AtLeast(NamedTuple):
    """The preset's own number, or this where it is less or absent."""

    limit: float

    def of(self, own: float | None) -> float | None:
        return self.limit if own is None else max(own, self.limit)

    def __str__(self) -> str:
        return f"at least {self.limit:,g}"


class Scaled(NamedTuple):
    """The preset's own number times this, rounded up where it has to be whole; None where it has none."""

    factor: float
    whole: bool = False

    def of(self, own: float | None) -> float | None:
        if own is None:
            return None
        return math.ceil(own * self.factor) if self.whole else own * self.factor

    def __str__(self) -> str:
        return f"{self.factor:g} times its own"


Own = Callable[[str], Any]
"""From a path to the number that a preset has there without a quality; None where it has none."""

SHADOWED = "lights.*.shadow"
"""Stands for the shadow map of every light that has one."""
STRANDS = ("children.count", "material.width")
"""Paths that change which strands there are, and not how they are drawn."""
OPTIONAL = ("children", "ambient_occlusion")
"""Mappings that a quality changes where a preset has them, and does not add."""
FINE: Mapping[str, Any] = {"image.resolver": "sorted", f"{SHADOWED}.model": "opacity"}
QUALITIES: Mapping[str, Mapping[str, Any]] = {
    "draft": {
        **FINE,
        f"{SHADOWED}.size": AtMost(512),
        f"{SHADOWED}.layers": AtMost(15),
        "image.supersample": 1,
        "camera.samples": AtMost(4),
        "curves.level": AtMost(2),
        "curves.tolerance": AtLeast(1.0),
        "children.count": Scaled(0.5, whole=True),
        "material.width": Scaled(1.5),
        "ambient_occlusion.cells": AtMost(10_000),
        "ambient_occlusion.directions": AtMost(16),
        "detail.near": Scaled(0.5),
        "detail.pixels": AtLeast(0.75),
    },
    "default": {**FINE, "curves.level": 4, "curves.tolerance": 0.25, "image.supersample": 1},
    "best": {**FINE, "curves.level": 4, "curves.tolerance": 0.25, "image.supersample": 3},
}


def settings_for(name: str, scene: Scene) -> dict[str, Any]:
    """The settings of a quality for a scene without one, by path, those of lights by their numbers. `STRANDS` are left
    out: they need other strands."""
    found = expanded(name, shadowed(scene), lambda path: value_at(scene, path))
    return {path: value for path, value in found if path not in STRANDS}


def shadowed(scene: Scene) -> list[int]:
    """Numbers of the lights that have a shadow map."""
    return [i for i, light in enumerate(scene.lights) if light.shadow.model != "off"]


def expanded(name: str, lights: Sequence[int], own: Own) -> Iterator[tuple[str, Any]]:
    """The settings of a quality; ``lights``: numbers of the lights that have a shadow map. Nothing for a name that is
    no quality."""
    for general, value in QUALITIES.get(name, {}).items():
        places = [general.replace("*", str(i), 1) for i in lights] if general.startswith(SHADOWED) else [general]
        for path in places:
            wanted = value.of(own(path)) if isinstance(value, AtMost | AtLeast | Scaled) else value
            absent = path.partition(".")[0] in OPTIONAL and own(path) is None
            widened = path != "material.width" or (own("children.count") or 1) > 1
            if wanted is not None and not absent and widened:
                yield path, wanted


def with_quality(scene: Scene, marks: Mapping[str, Mark], rank: Callable[[Mark], int]) -> Scene:
    """``scene`` with the settings that its `quality` stands for. What was written beside or over it stays, by the
    ``rank`` of its place among ``marks``, which are by path, and what the look fixes."""
    if "quality" not in marks:
        return scene
    asked, fixed, before = rank(marks["quality"]), {one.path for one in LOOKS.get(scene.look, ())}, scene

    def stays(path: str) -> bool:
        parts = path.split(".")
        if parts[0] == "lights":
            parts[1] = "*"
            if "lights" in marks and rank(marks["lights"]) > asked:
                return True
        over = {".".join(path.split(".")[: i + 1]) for i in range(len(parts))} & marks.keys()
        over = {one for one in over if rank(marks[one]) >= asked}
        return ".".join(parts) in fixed or any(one == path or value_at(before, one) is None for one in over)

    for path, value in expanded(scene.quality, shadowed(scene), lambda path: value_at(before, path)):
        if not stays(path):
            scene = with_value(scene, path, value)
    return scene


class Fixed(NamedTuple):
    """A setting that a look fixes: the values that it allows, of which the first is its own."""

    path: str
    """Dotted; `*` stands for every light."""
    values: tuple[str | bool, ...]


LOOKS: Mapping[str, tuple[Fixed, ...]] = {
    "source": (
        Fixed("image.resolver", ("zbuffer",)),
        Fixed("material.model", ("marschner",)),
        Fixed("material.rounded", (False,)),
        Fixed("lights.*.shadow.model", ("minmax", "off")),
    )
}
"""What each look fixes."""


def settle(scene: Scene, written: Container[str]) -> tuple[Scene, list[tuple[str, str]]]:
    """``scene`` with what its look fixes, and the clashes: path and message. ``written``: paths that were given."""
    clashes: list[tuple[str, str]] = []
    for path, values in LOOKS.get(scene.look, ()):
        for name in [path.replace("*", str(i)) for i in range(len(scene.lights))] if "*" in path else [path]:
            found = value_at(scene, name)
            if found in values:
                continue
            if name in written:
                clashes.append(
                    (
                        name,
                        f"{shown(_written(found))} clashes with look: {scene.look}, which draws with "
                        f"{' or '.join(map(_written, values))}; take one of the two out",
                    )
                )
            else:
                scene = with_value(scene, name, values[0])
    return scene, clashes


def _written(value: str | bool) -> str:
    return str(value).lower() if isinstance(value, bool) else value
