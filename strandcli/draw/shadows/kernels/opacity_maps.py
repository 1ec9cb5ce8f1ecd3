"""Building of deep opacity maps (see `opacity`): extents of cells, layers between them, and strands in these."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ....jit import device, function, inlined, parallel, prange
from ....simd import pointer, prefetch
from ...view.kernels.project import perspective_widening
from ...zbuffer.kernels.raster import Window
from . import cell_extents, splats
from .minmax import FARTHEST, NEAREST
from .opacity import FIVE, HEAD, SCALE, START

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
PARTS, PART = 4, 16
"""Most parts of a strand that are drawn apart, each after others that are near it, and segments of all but the last."""
SHORT = np.float32(0.5)
"""Texels."""
AHEAD = 3
"""Parts of strands that are fetched before they are drawn."""
LINE = 16
"""Numbers of a line of the processor's cache."""


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
    """(V,) how far along its strand each vertex stands, 0 to 1; None: evenly."""


class MapView(NamedTuple):
    """Constants of a light's view that convert depth numbers to metres and metres to texels."""

    far: Any
    """float32: depth range of an orthographic view, metres, or 0 for a perspective one."""
    near: Any
    """float32: nearest depth of an orthographic view, metres."""
    focal: Any
    """float32: texels a metre; for a perspective view at a depth of one metre."""


@parallel
def draw(strands, bands, size, view, opacity_map):
    """Draw strands into one map: widen its extents if its `stacks` is None, otherwise add to its layers.

    strands: `StrandsInMap`; bands: `zbuffer.kernels.bands.Bands`, whose rows are even; size: texels along a side, even;
    view: `MapView`; opacity_map: `OpacityMap`.
    """
    for task in prange(bands.workers):
        work = np.empty(splats.ROWS * splats.BATCH, np.float32)
        splats.start_batch(work)
        for b in range(task, bands.begin.shape[0] - 1, bands.workers):
            top = b * bands.rows
            window = Window(top, min(top + bands.rows, size), size)
            n = np.int64(0)
            for m in range(bands.begin[b], bands.begin[b + 1]):
                fetch(strands, np.int64(bands.members[min(m + AHEAD, bands.begin[b + 1] - 1)]))
                n = draw_part(
                    work, n, strands, np.int64(bands.members[m]), window, view, opacity_map, opacity_map.stacks,
                    strands.along,
                )  # fmt: skip
            end_batch(work, n, window, opacity_map, opacity_map.stacks)


@device
def end_batch(work, n, window, opacity_map, stacks):
    """Add what a batch holds to the layers, or in the pass that finds the extents to these."""
    if stacks is None:
        cell_extents.widen(work, n, opacity_map.extents)
    else:
        splats.add(work, n, window, opacity_map)


@device
def fetch(strands, part):
    """Have the processor fetch the vertices of a part that is drawn soon: they are anywhere in memory."""
    begin, last = part_range(strands.first, part)
    rows = pointer(strands.screen)
    for at in range(3 * begin, 3 * last + 3, LINE):
        prefetch(rows, at)


@device
def part_range(first, part):
    """Return the first vertex of a part, numbered strand by strand, and the last, which is the first of the next part.
    first: of `StrandsInMap`."""
    s, number = part // PARTS, part % PARTS
    last = first[s + 1] - 1
    begin = min(first[s] + number * PART, last)
    return begin, last if number == PARTS - 1 else min(begin + PART, last)


@device
def depth_of(q, near, far):
    """Return the depth, metres, of a depth number; near, far: of `MapView`."""
    return near + (ONE - q) * far if far > ZERO else ONE / q


@inlined
def too_short(begin, end, scale):
    """Return whether a segment is less than `SHORT` along all axes; arguments as in `splats.collect`."""
    dx, dy, rise = end[0] - begin[0], end[1] - begin[1], end[2] - begin[2]
    return max(max(abs(dx), abs(dy)), abs(rise) * scale) < SHORT


@inlined
def distance(screen, u, v):
    """Return how far vertex v is from vertex u on the map, texels."""
    dx, dy = screen[v, 0] - screen[u, 0], screen[v, 1] - screen[u, 1]
    return np.float32(math.sqrt(dx * dx + dy * dy))


@device
def widening(x, y, dx, dy, view):
    """Return by how much perspective widens a segment away from the axis; x, y: from the middle, texels."""
    return ONE if view.far > ZERO else perspective_widening(x, y, dx, dy, view.focal)


@device
def width_of(width, scale, s):
    """Return the width of strand s at its root, metres."""
    return width if scale is None else width * scale[s]


@device
def draw_part(work, n, strands, part, window, view, opacity_map, stacks, along):
    """Draw what lies within the window of a part of a strand, numbered strand by strand; return how many splats the
    batch holds then, which held n. Vertices less than `SHORT` behind the last are left out, but for the part's end; the
    segment over them covers as much as theirs do, in its own place.

    work: rows of `splats`; stacks: those of the map; along: of the strands.
    """
    s = part // PARTS
    width = width_of(strands.width, strands.scale, s)
    screen, far, near, focal = strands.screen, view.far, view.near, view.focal
    a = strands.first[s]
    thin = width * strands.taper / np.float32(max(strands.first[s + 1] - a - 1, 1))
    middle = HALF * np.float32(window.width)
    begin, last = part_range(strands.first, part)
    u = begin
    x0, y0, q0 = screen[u, 0], screen[u, 1], screen[u, 2]
    way = ZERO  # from the last vertex by way of those that are left out
    for v in range(begin + 1, last + 1):
        x1, y1, q1 = screen[v, 0], screen[v, 1], screen[v, 2]
        there = q0 > ZERO and q1 > ZERO
        d0 = depth_of(q0, near, far) if there else ONE
        d1 = depth_of(q1, near, far) if there else ONE
        scale = focal if far > ZERO else focal * HALF * (q0 + q1)
        if v < last and there and too_short((x0, y0, d0), (x1, y1, d1), scale):
            way += distance(screen, v - 1, v)
            continue
        # splats of flat segments add to the row next to theirs, so segments next to these rows count too
        beside = max(y0, y1) < np.float32(window.top) - ONE or min(y0, y1) > np.float32(window.bottom) + ONE
        if there and not beside:
            if along is None:
                w = width - thin * (HALF * np.float32(u + v - a - a))
            else:
                w = width * (ONE - strands.taper * HALF * (along[u] + along[v]))
            w *= scale * widening(x0 - middle, y0 - middle, x1 - x0, y1 - y0, view)
            if way > ZERO:
                w *= (way + distance(screen, v - 1, v)) / max(distance(screen, u, v), splats.TINY)
            if stacks is None:
                n = cell_extents.collect_cells(work, n, (x0, y0, d0), (x1, y1, d1), window, opacity_map.extents)
            else:
                n = splats.collect(work, n, (x0, y0, d0), (x1, y1, d1), scale, w, window, opacity_map)
        u, x0, y0, q0, way = v, x1, y1, q1, ZERO
    return n


@function
def number_cells(extents, rows):
    """Number the cells that contain strands from 1 on; return how many there are.

    extents (cells, 2): of `OpacityMap`; rows (cells,) out: the numbers, 0 for empty cells. float32 represents every
    integer up to the greatest number of cells.
    """
    count = np.int64(0)
    for cell in range(extents.shape[0]):
        there = extents[cell, NEAREST] <= extents[cell, FARTHEST]
        count += np.int64(there)
        rows[cell] = np.float32(count) if there else ZERO
    return count


@parallel
def divide(extents, layers, least, over, rows, stacks):
    """Initialise the rows of all cells with empty layers, and replace the extents by the heads of these rows.

    extents (cells, 2): metres, at least `least` metres apart; over: 1 / h, 1/m; rows (cells,): from `number_cells`;
    stacks (`opacity.numbers_of`,) out.
    """
    stride = HEAD + FIVE * (layers + 1)
    cells = extents.shape[0]
    for k in range(stride):
        stacks[cells + k] = ZERO
    for cell in prange(cells):
        stacks[cell] = rows[cell]
        near = extents[cell, NEAREST]
        there = rows[cell] > ZERO
        thick = max(extents[cell, FARTHEST] - near, least)
        extents[cell, START] = near if there else ZERO
        extents[cell, SCALE] = np.float32(layers) * (ONE + ONE / (thick * over)) if there else ZERO
        if there:
            base = cells + np.int64(rows[cell]) * stride
            stacks[base + START] = extents[cell, START]
            stacks[base + SCALE] = extents[cell, SCALE]
            for k in range(HEAD, stride):
                stacks[base + k] = ZERO


@parallel
def sum_layers(cells, layers, stacks):
    """Replace the τ of each layer by the cumulative τ in front of its end, and store the mean of each cell's texels.

    cells: number of the map's cells; stacks (`opacity.numbers_of`,): changed in place.
    """
    stride = HEAD + FIVE * (layers + 1)
    for row in prange((stacks.shape[0] - cells) // stride - 1):
        base = cells + (row + 1) * stride + HEAD
        one = two = three = four = ZERO
        for k in range(layers + 1):
            at = base + FIVE * k
            one += stacks[at]
            two += stacks[at + 1]
            three += stacks[at + 2]
            four += stacks[at + 3]
            stacks[at] = one
            stacks[at + 1] = two
            stacks[at + 2] = three
            stacks[at + 3] = four
            stacks[at + 4] = HALF * HALF * ((one + two) + (three + four))
