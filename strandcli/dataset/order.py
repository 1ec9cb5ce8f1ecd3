"""What a data set is made of, checked before anything is drawn."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from ..cameras.pinhole import Pinhole
from ..common.counted import counted
from ..common.registry import LAYOUTS
from ..errors import UsageError
from .labels import LAYERS
from .layout import Layout

if TYPE_CHECKING:
    from ..scene.model import Scene

OFF = 1e-3
"""Pixels by which a principal point may be off the middle where it has to be there."""
DEFAULT = 8
"""Views."""


def layout_of(name: str) -> Layout:
    """The layout of a name. Raises `UsageError` where there is none."""
    names = LAYOUTS.names()
    if name not in names:
        raise UsageError(f"--layout {name}: layouts are {', '.join(names)}")
    found: Layout = LAYOUTS[name]
    return found


def size_for(
    layout: Layout, given: tuple[int, int] | None, places: Sequence[Pinhole], path: Path | None
) -> tuple[int, int]:
    """Width and height of the pictures. Raises `UsageError` where a layout cannot hold them."""
    size = given or layout.size
    if places:
        size = _size_of(places, layout, path)
    if layout.square and size[0] != size[1]:
        where = f"{path}: " if places else "--size "
        raise UsageError(f"{where}{size[0]}x{size[1]}: the layout {layout.name} has square pictures alone")
    return size


def _size_of(places: Sequence[Pinhole], layout: Layout, path: Path | None) -> tuple[int, int]:
    """The size of all views of a file."""
    sizes = sorted({(one.width, one.height) for one in places})
    if len(sizes) > 1:
        listed = " and ".join(f"{width}x{height}" for width, height in sizes[:2])
        raise UsageError(f"{path}: views are of several sizes, {listed} for two; a data set has one")
    size = sizes[0]
    for one in places:
        if one.perspective != layout.perspective:
            kind = "perspective" if layout.perspective else "orthographic"
            raise UsageError(f"{path}: view {one.name}: the layout {layout.name} has {kind} views alone")
        off = max(abs(one.centre[0] - size[0] / 2), abs(one.centre[1] - size[1] / 2))
        if layout.centred and off > OFF:
            raise UsageError(
                f"{path}: view {one.name}: its principal point is {off:.3g} pixels off the middle, where programs that "
                f"read {layout.name} take it to be; choose neuralhaircut or nerfstudio"
            )
    return size


def numbers_for(count: int | None, first: int, places: Sequence[Pinhole], path: Path | None) -> range:
    """The numbers of the views. Raises `UsageError` where a file of cameras has fewer."""
    if count is None:
        count = max(len(places) - first, 1) if places else DEFAULT
    if places and first + count > len(places):
        raise UsageError(f"--views: {path} holds {counted(len(places), 'view')}, {first + count} are asked for")
    return range(first, first + count)


def scene_for(scene: Scene, layout: Layout, size: tuple[int, int], frame: int) -> Scene:
    """A scene as views of a data set are drawn: of a size, through a pinhole that keeps still, with the layers that
    labels are made of. Raises `UsageError` for a scene without layers, or without such a frame."""
    if scene.panels:
        raise UsageError("a preset of several panels has no labels; take one without panels")
    if scene.image.has_alpha:
        raise UsageError("image.background: a data set has masks beside its pictures, not alpha in them; name a colour")
    if frame > scene.time.frames:
        raise UsageError(f"--frame {frame}: the preset has {scene.time.frames} frames")
    from ..scene.motion import camera_at

    now = camera_at(scene.camera, (frame - 1) / scene.time.fps)
    camera = replace(
        scene.camera, kind="perspective" if layout.perspective else "orthographic", position=now.position,
        target=now.target, aperture=0.0, shutter=0.0, keys=(), axis_x=0.5, axis_y=0.5,
        file=None, name="", views=(),
    )  # fmt: skip
    return replace(scene, camera=camera, image=replace(scene.image, size=size, crop=None, aovs=LAYERS))


def names_of(grooms: Sequence[str]) -> list[str]:
    """A name for each groom, one part of a path: that of its file without its end; a number goes to those whose name
    another has."""
    found: list[str] = []
    for groom in grooms:
        stem = Path(groom).stem
        name = plain = stem if stem.strip(".") else "groom"
        for number in itertools.count(2):
            if name not in found:
                break
            name = f"{plain}-{number}"
        found.append(name)
    return found
