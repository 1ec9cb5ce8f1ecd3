"""Parts of strands as a light sees them: what they are, and an order of them.

Both passes over an opacity map draw the same segments, which `part_vertices` finds once.

Parts near each other on the map follow each other, along a Z-curve. They add to the same cells, which then are in the
processor's cache. Sums are rounded otherwise in another order, so it is that of places on the map alone. Each thread
draws a band of rows, with about as much work as the rest have.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ....jit import device, function, inlined
from ...common.kernels.numbers import ONE, ZERO

TINY = np.float32(1e-6)
"""Texels."""
PARTS, PART = 4, 48
"""Most parts of a strand that are drawn apart, and segments of all but the last. A part costs as much to draw as some
six segments."""
REST = 8
"""Segments at the end of a strand, up to so many, that belong to the part before them."""
SHORT = np.float32(0.5)
"""Texels that vertices may be behind the last one and are left out."""
GROUP = 4
"""Segments that are left out deep in shadow, or not, together."""
BITS = 8
"""Of a place, of each coordinate: 256 × 256 tiles, of two to eight texels."""
AT, COUNT, TOP, BOTTOM = range(4)
"""Columns of a part: its first row in `PartsInMap.vertices`, the number of its vertices, and the first and the last row
of texels that it comes to."""
X, Y, DEPTH, WIDE = range(4)
"""Columns of `PartsInMap.vertices`."""


class StrandsInMap(NamedTuple):
    """Strands projected into a light's view."""

    first: NDArray[np.int64]
    """(S + 1,) first vertex of each strand, and the number of vertices."""
    screen: NDArray[np.float32]
    """(V, 3) x and y in texels, and the depth number of `project.points`."""
    width: Any
    """float32: metres at the root; the width at the tip is smaller by the share `taper`."""
    taper: Any
    """float32, 0 to 1."""
    scale: NDArray[np.float32] | None
    """(S,) factor of each strand's width; None stands for 1."""
    along: NDArray[np.float32] | None = None
    """(V,) of which each vertex's width is smaller by the share `taper`; None: evenly from 0 at the root to 1."""


class MapView(NamedTuple):
    """Constants of a light's view that convert depth numbers to metres and metres to texels."""

    far: Any
    """float32: depth range of an orthographic view, metres, or 0 for a perspective one."""
    near: Any
    """float32: nearest depth of an orthographic view, metres."""
    focal: Any
    """float32: texels a metre; for a perspective view at a depth of one metre."""


class PartsInMap(NamedTuple):
    """What is drawn into one map."""

    vertices: NDArray[np.float32]
    """(K, 4) vertices, part by part: x and y, texels; depth, metres; and the mean width, texels, of the segment that
    ends there, less than 0 if none does."""
    order: NDArray[np.int32]
    """(P, 4) the parts, columns above."""
    borders: NDArray[np.int64]
    """(threads + 1,) even rows of texels between the bands."""


def spread_bits() -> NDArray[np.int64]:
    """Return (2^`BITS`,) for each number its bits, each behind one that is 0."""
    numbers = np.arange(1 << BITS)
    return np.asarray(sum((numbers >> bit & 1) << 2 * bit for bit in range(BITS)))


SPREAD = spread_bits()


@device
def shared_before(first, s):
    """Return how many vertices two parts share at most of the strands before strand s: `PARTS` - 1 of a strand, one of
    each `PART` vertices. first: of `StrandsInMap`."""
    return min(s * (PARTS - 1), first[s] // PART)


@device
def part_range(first, s, number):
    """Return the first vertex of a part of strand s, and the last, which is the first of the next part; the same one
    twice for a part that is not there. first: of `StrandsInMap`."""
    last = first[s + 1] - 1
    begin = first[s] + number * PART
    if number >= PARTS or (number > 0 and begin + REST >= last):
        return last, last
    return begin, last if number == PARTS - 1 or begin + PART + REST >= last else begin + PART


@device
def place_of(strands, s, number, size):
    """Return the place on the Z-curve of the middle vertex of a part of strand s."""
    begin, _ = part_range(strands.first, s, number)
    middle = min(begin + PART // 2, (begin + strands.first[s + 1] - 1) // 2)
    tiles = np.float32(1 << BITS) / np.float32(size)
    x = np.int64(min(max(strands.screen[middle, 0] * tiles, ZERO), np.float32((1 << BITS) - 1)))
    y = np.int64(min(max(strands.screen[middle, 1] * tiles, ZERO), np.float32((1 << BITS) - 1)))
    return SPREAD[x] | SPREAD[y] << 1


@device
def depth_of(q, near, far):
    """Return the depth, metres, of a depth number; near, far: of `MapView`."""
    return near + (ONE - q) * far if far > ZERO else ONE / q


@inlined
def width_of(width, scale, s):
    """Return the width of strand s at its root, metres."""
    return width if scale is None else width * scale[s]


@function
def sort(found, places, costs, begin, loads, order, borders):
    """Write the parts that are there in their order, and borders of bands with about the same cost; return how many
    parts there are.

    found, places, costs: from `part_vertices.thin`, the last without rows where there is one band; begin (tiles + 1,)
    int64 and loads (rows,) float64: changed; order (R, 4), borders (threads + 1,) out: of `PartsInMap`.
    """
    begin[:] = 0
    loads[:] = 0.0
    whole = 0.0
    for part in range(found.shape[0]):
        if found[part, COUNT] > 0:
            begin[np.int64(places[part]) + 1] += 1
            if costs.shape[0] > 0:
                loads[(found[part, TOP] + found[part, BOTTOM]) >> 1] += costs[part]
                whole += costs[part]
    for tile in range(1, begin.shape[0]):
        begin[tile] += begin[tile - 1]
    for part in range(found.shape[0]):
        if found[part, COUNT] > 0:
            k = begin[np.int64(places[part])]
            begin[np.int64(places[part])] = k + 1
            for column in range(order.shape[1]):
                order[k, column] = found[part, column]
    share(loads, whole, borders)
    return begin[begin.shape[0] - 2]


@device
def share(loads, whole, borders):
    """Write even rows, between which about as much is to do; loads (rows,): what is to do, whole: in all."""
    bands = borders.shape[0] - 1
    borders[:] = loads.shape[0]
    borders[0] = 0
    done, band = 0.0, 1
    for row in range(0, loads.shape[0], 2):
        while band < bands and done * bands >= whole * band:
            borders[band] = row
            band += 1
        done += loads[row] + loads[row + 1]
