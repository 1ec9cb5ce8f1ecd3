"""Strands as a light's map sees them: projected, and in parts near each other (see `kernels.map_parts`)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..common.scratch import Scratch
from ..geometry.curves import Polylines
from ..geometry.extent import Thickness
from ..view.camera import View
from ..zbuffer.raster import to_screen
from .kernels import map_parts
from .kernels.map_parts import BITS, PARTS, MapView, PartsInMap, StrandsInMap
from .kernels.map_segments import SEGMENTS


def parts_in_map(
    lines: Polylines, view: View, side: int, thickness: Thickness, workers: int, scratch: Scratch
) -> PartsInMap:
    """Return the parts of polylines that are drawn into an opacity map of ``side`` texels a side, an even number, in a
    band for each worker. They are valid until the next are requested."""
    first, screen = project(lines, view, scratch)
    width, taper = np.float32(thickness.width), np.float32(thickness.taper)
    strands = StrandsInMap(first, screen, width, taper, lines.scale, lines.along)
    return parts_of(strands, view_numbers(view), side, workers, scratch)


def parts_of(strands: StrandsInMap, view: MapView, side: int, workers: int, scratch: Scratch) -> PartsInMap:
    """Return the parts of projected strands; arguments as in `parts_in_map`."""
    count = len(strands.first) - 1
    room = len(strands.screen) + count * (PARTS - 1) + SEGMENTS + 1  # vectors look beyond the last part
    kept = scratch.borrow("map_vertices", (room, 4), np.float32)
    found, order = (scratch.borrow(name, (count * PARTS, 4), np.int32) for name in ("map_parts", "map_order"))
    places = scratch.borrow("map_places", count * PARTS, np.uint16)
    costs = scratch.borrow("map_costs", count * PARTS, np.float32)
    begin, loads, borders = np.empty(4**BITS + 1, np.int64), np.empty(side), np.empty(workers + 1, np.int64)
    map_parts.thin(strands, view, side, kept, found, places, costs)
    there = map_parts.sort(found, places, costs, begin, loads, order, borders)
    return PartsInMap(kept, order[:there], borders)


def view_numbers(view: View) -> MapView:
    """Return the constants of a light's view."""
    far = np.float32(0.0 if view.perspective else view.far - view.near)
    return MapView(far, np.float32(view.near), np.float32(view.focal))


def project(lines: Polylines, view: View, scratch: Scratch) -> tuple[NDArray[np.int64], NDArray[np.float32]]:
    """Return the first vertex (S + 1,) of each strand, and the vertices (V, 3) that a map needs, from `to_screen`."""
    stride = coarseness(lines, view)
    ends = np.arange(len(lines.first), dtype=np.int64)
    return (lines.first - ends) // stride + ends, to_screen(lines, view, scratch, "light_screen", stride)


def coarseness(lines: Polylines, view: View) -> int:
    """Return how many pieces of a curve a map may draw as one line, such that a segment that turns by a radian departs
    from the curve by at most half a texel. A cubic's chords depart by length · turn / 8 / (number of chords)²."""
    nearest = view.near if view.perspective else 1.0
    texels = lines.segment * view.focal / nearest
    needed = 1
    while needed < lines.pieces and texels / (8 * needed * needed) > 0.5:
        needed *= 2
    return lines.pieces // needed
