"""Strands as a light's map sees them: projected, and in parts near each other (see `kernels.map_parts`)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numba import get_num_threads
from numpy.typing import NDArray

from ..common.scratch import Scratch
from ..geometry.curves import Polylines
from ..geometry.extent import Thickness
from ..view.camera import View
from ..zbuffer.raster import to_screen
from .kernels import deep_strands, map_parts, opacity_maps, part_vertices
from .kernels.deep_strands import CELL, LEVELS, NO_SKETCH, WEIGHTS, Sketch
from .kernels.map_parts import BITS, PART, PARTS, MapView, PartsInMap, StrandsInMap
from .kernels.splats import SEGMENTS

NO_EXTENTS = np.zeros((0, 2), np.float32)
FEWEST = 4000
"""Strands from which on those deep in shadow are left out in part."""
SKETCHED = 3000
"""Strands of a sketch, about, and at most a quarter of all."""
WORTH = 0.15
"""Part of what strands cover that must lie deep in shadow to leave any out."""
MIXERS = ((16, 0x7FEB352D), (15, 0x846CA68B))
"""Of an integer hash (Wellons 2018, `lowbias32`). Multiples of the golden ratio do not do: roots of strands beside each
other differ by such numbers that their multiples are alike."""


def parts_in_map(
    lines: Polylines, thickness: Thickness, view: View, side: int, workers: int, scratch: Scratch, over: float = 1.0,
    chances: NDArray[np.float32] | None = None, extents: NDArray[np.float32] = NO_EXTENTS,
) -> PartsInMap:  # fmt: skip
    """Return the parts of polylines that are drawn into an opacity map of ``side`` texels a side, an even number, in a
    band for each worker. They are valid until the next are requested.

    ``over``: 1 / h of `kernels.opacity`, 1/m; chances (strands,): from `chances_of`, to leave out most strands deep in
    shadow, None: none are; ``extents``: of the map's cells, to be widened."""
    lines = coarse(lines, view, scratch)
    screen, seen = to_screen(lines, view, scratch, "light_screen"), view_numbers(view)
    taper, along = lines.tapered(thickness.taper)
    strands = StrandsInMap(lines.first, screen, np.float32(thickness.width), taper, lines.scale, along)
    sketch = NO_SKETCH
    if chances is not None and len(chances) >= FEWEST:
        drafted = strands if lines.lost is None else evened(strands, lines.lost, lines.first)
        sketch = sketch_of(drafted, seen, side, chances, over, scratch)
    count = len(strands.first) - 1
    shared = min(count * (PARTS - 1), len(strands.screen) // PART)  # as `kernels.map_parts.shared_before` for all
    parts = count + shared
    room = len(strands.screen) + shared + SEGMENTS + 1  # vectors look beyond the last part
    vertices = scratch.borrow("map_vertices", (room, 4), np.float32)
    found, order = (scratch.borrow(name, (parts, 4), np.int32) for name in ("map_parts", "map_order"))
    places = scratch.borrow("map_places", parts, np.uint16)
    costs = scratch.borrow("map_costs", parts if workers > 1 else 0, np.float32)
    begin, loads, borders = np.empty(4**BITS + 1, np.int64), np.empty(side), np.empty(workers + 1, np.int64)
    at_once = extents if get_num_threads() == 1 else NO_EXTENTS  # several threads would write to the same cells
    part_vertices.thin(strands, sketch, seen, side, vertices, found, places, costs, at_once)
    there = map_parts.sort(found, places, costs, begin, loads, order, borders)
    found_parts = PartsInMap(vertices, order[:there], borders)
    if len(extents) > len(at_once):
        opacity_maps.measure(found_parts, side, extents)
    return found_parts


def evened(strands: StrandsInMap, lost: NDArray[np.float32], first: NDArray[np.int64]) -> StrandsInMap:
    """Return strands that are as wide everywhere as these are on average; lost, first: of `Polylines`."""
    sums = np.concatenate([np.zeros(1), np.cumsum(lost, dtype=np.float64)])
    mean = (sums[first[1:]] - sums[first[:-1]]) / np.maximum(np.diff(first), 1)
    scale = np.float32(1.0) if strands.scale is None else strands.scale
    return strands._replace(scale=(scale * (1 - mean)).astype(np.float32), taper=np.float32(0.0))


def chances_of(ids: NDArray[np.int32] | None, strands: int) -> NDArray[np.float32]:
    """Return (strands,) chances of `kernels.deep_strands`, even and independent of where strands are; ids: their
    numbers in the order of emission, None: 0, 1, …"""
    mixed = np.arange(strands, dtype=np.uint32) if ids is None else ids.astype(np.uint32)
    for shift, factor in MIXERS:
        mixed = (mixed ^ (mixed >> np.uint32(shift))) * np.uint32(factor)
    return ((mixed ^ (mixed >> np.uint32(16))) >> np.uint32(8)).astype(np.float32) * np.float32(2.0**-24)


def sketched_share(strands: int) -> np.float32:
    """Return the share of so many strands that is in a sketch."""
    return np.float32(min(0.25, SKETCHED / strands))


def sketch_of(
    strands: StrandsInMap, view: MapView, side: int, chances: NDArray[np.float32], over: float, scratch: Scratch
) -> Sketch:  # fmt: skip
    """Return by what most of projected strands are left out that lie deep in shadow; arguments as in
    `parts_in_map`."""
    cells = -(-side // CELL)
    nearest = scratch.borrow("sketch_nearest", cells * cells, np.float32)
    before = scratch.borrow("sketch", cells * cells * (LEVELS + 1), np.float32)
    deep = scratch.borrow("sketch_deep", (cells * cells, 2), np.float32)
    sketch = Sketch(chances, nearest, before, deep, WEIGHTS, cells, np.float32(over))
    part = deep_strands.draw(strands, view, sketched_share(len(chances)), sketch)
    return sketch if part > WORTH else NO_SKETCH


def view_numbers(view: View) -> MapView:
    """Return the constants of a light's view."""
    far = np.float32(0.0 if view.perspective else view.far - view.near)
    return MapView(far, np.float32(view.near), np.float32(view.focal))


def coarse(lines: Polylines, view: View, scratch: Scratch) -> Polylines:
    """Return polylines without the vertices that a map does not need (see `coarseness`), valid until the next."""
    stride = coarseness(lines, view)
    if stride == 1:
        return lines
    some = lines.world.reshape(-1, lines.per, 3)[:, ::stride]
    world, lost = scratch.borrow("map_coarse_world", some.shape, np.float32), None
    world[...] = some
    if lines.lost is not None:
        lost = np.ascontiguousarray(lines.lost.reshape(-1, lines.per)[:, ::stride]).reshape(-1)
    first = np.arange(len(lines.first), dtype=np.int64) * world.shape[1]
    return replace(lines, first=first, world=world.reshape(-1, 3), lost=lost, per=0)


def coarseness(lines: Polylines, view: View) -> int:
    """Return how many pieces of a curve a map may draw as one line, such that a segment that turns by a radian departs
    from the curve by at most half a texel. A cubic's chords depart by length · turn / 8 / (number of chords)²."""
    nearest = view.near if view.perspective else 1.0
    texels = lines.segment * view.focal / nearest
    needed = 1
    while needed < lines.pieces and texels / (8 * needed * needed) > 0.5:
        needed *= 2
    return lines.pieces // needed
