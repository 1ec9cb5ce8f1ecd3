"""What `quality: draft | default | best` and `look: source` stand for, for presets, options and `bench`.

All three are near the front of error over time that `strandcli study PRESET --axis quality` finds over samples,
tolerance and level of detail (docs/accuracy.md). Fewer than 16 pieces a segment keep no tolerance where blades are
near; a z-buffer draws thin strands far too wide, and min/max maps save nothing that shows.

`draft` is for looking at motion, light and colour. It never costs more than the preset does by itself under these
resolver and shadow models. Lines of no width become thinner with more samples and are never thinned out.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Container, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from .faults import Mark, shown
from .fields import value_at, with_value
from .model import Scene


class Relative(NamedTuple):
    """A number that follows from the preset's own, and in words; of none where the preset has none."""

    words: str
    of: Callable[[Any], Any]

    def __str__(self) -> str:
        return self.words


def at_most(limit: float) -> Relative:
    """The preset's own number, or this where it is greater or absent."""
    return Relative(f"at most {limit:,g}", lambda own: limit if own is None else min(own, limit))


def at_least(limit: float) -> Relative:
    """The preset's own number, or this where it is less or absent."""
    return Relative(f"at least {limit:,g}", lambda own: limit if own is None else max(own, limit))


def times(factor: float) -> Relative:
    """The preset's own number times this, rounded up where it is whole; None where it has none."""

    def of(own: Any) -> Any:
        return None if own is None else math.ceil(own * factor) if isinstance(own, int) else own * factor

    return Relative(f"{factor:g} times its own", of)


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
        f"{SHADOWED}.size": at_most(512),
        f"{SHADOWED}.layers": at_most(15),
        "image.supersample": 1,
        "camera.samples": at_most(4),
        "curves.level": at_most(2),
        "curves.tolerance": at_least(1.0),
        "children.count": times(0.5),
        "material.width": times(1.5),
        "ambient_occlusion.cells": at_most(10_000),
        "ambient_occlusion.directions": at_most(16),
        "detail.near": times(0.5),
        "detail.pixels": at_least(0.75),
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
            wanted = value.of(own(path)) if isinstance(value, Relative) else value
            absent = path.partition(".")[0] in OPTIONAL and own(path) is None
            widened = path != "material.width" or (own("children.count") or 1) > 1
            if wanted is not None and not absent and widened:
                yield path, wanted


def with_quality(scene: Scene, marks: Mapping[str, Mark], rank: Callable[[Mark], int]) -> Scene:
    """``scene`` with the settings that its `quality` stands for. What was written beside or over it stays, by the
    ``rank`` of its place among ``marks``, which are by path, and what the look fixes."""
    if "quality" not in marks:
        return scene
    asked, fixed, before = rank(marks["quality"]), LOOKS.get(scene.look, {}), scene

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


LOOKS: Mapping[str, Mapping[str, tuple[str | bool, ...]]] = {
    "source": {
        "image.resolver": ("zbuffer",), "material.model": ("marschner",), "material.rounded": (False,),
        "lights.*.shadow.model": ("minmax", "off"),
    }
}  # fmt: skip
"""What each look fixes: by dotted path, `*` standing for every light, the values that it allows, the first its own."""


def settle(scene: Scene, written: Container[str]) -> tuple[Scene, list[tuple[str, str]]]:
    """``scene`` with what its look fixes, and the clashes: path and message. ``written``: paths that were given."""
    clashes: list[tuple[str, str]] = []
    for path, values in LOOKS.get(scene.look, {}).items():
        for name in [path.replace("*", str(i)) for i in range(len(scene.lights))] if "*" in path else [path]:
            found = value_at(scene, name)
            if found in values:
                continue
            if name in written:
                wanted = " or ".join(map(_written, values))
                draws = f"clashes with look: {scene.look}, which draws with {wanted}; take one of the two out"
                clashes.append((name, f"{shown(_written(found))} {draws}"))
            else:
                scene = with_value(scene, name, values[0])
    return scene, clashes


def _written(value: str | bool) -> str:
    return str(value).lower() if isinstance(value, bool) else value
