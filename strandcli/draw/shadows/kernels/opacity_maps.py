"""Building of deep opacity maps (see `opacity`): extents of cells, layers between them, and strands in these."""

from __future__ import annotations

import numpy as np

from ....jit import function, inlined, parallel, prange
from ....simd import lane_count, load, pointer, prefetch, store
from ...common.kernels.numbers import INF, ONE, ZERO
from ...zbuffer.kernels.lines import Window
from . import cell_extents, splats
from .map_parts import AT, BOTTOM, COUNT, TOP
from .minmax import FARTHEST, NEAREST
from .opacity import HEAD, ROW, SCALE, START, TEXELS, WHOLE

NEXT = np.uint64(1)
AHEAD = 12
"""Parts of strands that are fetched before they are drawn."""
LINE = 16
"""Numbers of a line of the processor's cache."""


@parallel
def measure(parts, size, extents):
    """Widen the extents (cells, 2) of a map's cells by strands.

    parts: `PartsInMap`; size: texels along a side, even."""
    for task in prange(parts.borders.shape[0] - 1):
        work = np.empty(cell_extents.ROOM, np.float32)
        window = Window(parts.borders[task], parts.borders[task + 1], size)
        for k in range(parts.order.shape[0]):
            ahead = min(k + AHEAD, parts.order.shape[0] - 1)
            if overlaps(parts.order, ahead, window):
                fetch(parts, ahead)
            if overlaps(parts.order, k, window):
                begin, count = np.int64(parts.order[k, AT]), np.int64(parts.order[k, COUNT])
                cell_extents.widen(work, parts.vertices, begin, count, INF, window, extents)


@parallel
def draw(parts, size, view, opacity_map):
    """Add strands to the layers of one map. parts: `PartsInMap`; size: texels along a side, even; view: `MapView`;
    opacity_map: `OpacityMap`."""
    for task in prange(parts.borders.shape[0] - 1):
        work = np.empty(splats.ROOM, np.float32)
        window = Window(parts.borders[task], parts.borders[task + 1], size)
        n = filled = np.int64(0)
        for k in range(parts.order.shape[0]):
            ahead = min(k + AHEAD, parts.order.shape[0] - 1)
            if overlaps(parts.order, ahead, window):
                fetch(parts, ahead)
            if overlaps(parts.order, k, window):
                n, filled = draw_part(work, n, filled, parts, k, window, view, opacity_map)
        n = draw_segments(work, n, max(filled - 1, 0), window, view, opacity_map)
        splats.add(work, n, window, opacity_map)


@inlined
def overlaps(order, k, window):
    """Return whether part k comes to rows of the window."""
    return order[k, TOP] < window.bottom and order[k, BOTTOM] >= window.top


@inlined
def fetch(parts, k):
    """Have the processor fetch the vertices of a part that is drawn soon: they are anywhere in memory."""
    rows = pointer(parts.vertices)
    begin = 4 * np.int64(parts.order[k, AT])
    end = begin + 4 * np.int64(parts.order[k, COUNT])
    for at in range(begin, end, LINE):
        prefetch(rows, at)
    prefetch(rows, end - 1)


@inlined
def draw_part(work, n, filled, parts, k, window, view, opacity_map):
    """Bring the vertices of part k into a run, and draw its segments once it has many. Return how many pieces the batch
    and how many vertices the run holds then, of n and `filled` before; work: rows of `splats`."""
    begin, count = np.int64(parts.order[k, AT]), np.int64(parts.order[k, COUNT])
    rows = pointer(work)
    for past in range(0, count, splats.RUN):
        filled = splats.append(work, filled, parts.vertices, begin + past, min(count - past, splats.RUN))
        if filled > splats.RUN:
            whole = (filled - 1) // splats.SEGMENTS * splats.SEGMENTS
            n = draw_segments(work, n, whole, window, view, opacity_map)
            filled -= whole  # and the rest comes to the beginning of the run
            for at in range(0, 4 * filled, lane_count(rows)):
                store(rows, splats.VERTICES + at, load(rows, splats.VERTICES + 4 * whole + at))
    return n, filled


@inlined
def draw_segments(work, n, count, window, view, opacity_map):
    """Draw what lies within the window of the first segments of a run, so many; return how many pieces the batch holds
    then, of n before."""
    for first in range(0, count, splats.SEGMENTS):
        segments = splats.find_segments(work, first, count, window, view)
        s = past = np.int64(0)
        while s < segments:
            n, s, past = splats.collect(work, n, segments, s, past)
            if s < segments:
                splats.add(work, n, window, opacity_map)
                n = np.int64(0)
    return n


@function
def number_cells(extents, rows):
    """Number the cells that contain strands from 1 on; return how many there are.

    extents (cells, 2): `NEAREST` and `FARTHEST` depth, metres, (inf, −inf) in empty cells; rows (cells,) out: the
    numbers, 0 for empty cells. float32 represents every integer up to the greatest number of cells.
    """
    count = np.int64(0)
    for cell in range(extents.shape[0]):
        there = extents[cell, NEAREST] <= extents[cell, FARTHEST]
        count += np.int64(there)
        rows[cell] = np.float32(count) if there else ZERO
    return count


@parallel
def divide(extents, layers, least, over, rows, stacks, heads):
    """Initialise the rows of all cells with empty layers, and replace the extents by `START` and `SCALE` of these rows,
    0 in empty cells.

    extents (cells, 2): metres, at least `least` metres apart; over: 1 / h, 1/m; rows (cells,): from `number_cells`;
    stacks (`opacity.numbers_of`,) out; heads (cells, 4) out: of `OpacityMap`.
    """
    stride = TEXELS * (layers + 1)
    cells = extents.shape[0]
    for k in range(stride):
        stacks[HEAD * cells + k] = ZERO
    for cell in prange(cells):
        near = extents[cell, NEAREST]
        there = rows[cell] > ZERO
        thick = max(extents[cell, FARTHEST] - near, least)
        extents[cell, START] = near if there else ZERO
        extents[cell, SCALE] = np.float32(layers) * (ONE + ONE / (thick * over)) if there else ZERO
        if there:
            begin = np.uint64(HEAD * cells + np.int64(rows[cell]) * stride)
            for k in range(begin, begin + np.uint64(stride)):
                stacks[k] = ZERO
        heads[cell, START], heads[cell, SCALE] = extents[cell, START], extents[cell, SCALE]
        heads[cell, ROW] = rows[cell]
        head = np.uint64(HEAD * cell)
        for k in range(np.uint64(HEAD)):
            stacks[head + k] = ZERO
        stacks[head + np.uint64(START)], stacks[head + np.uint64(SCALE)] = extents[cell, START], extents[cell, SCALE]
        stacks[head + np.uint64(ROW)] = rows[cell]


@parallel
def sum_layers(cells, layers, stacks):
    """Replace the τ of each layer by the cumulative τ in front of its end, and store that of the last one
    in the cell's head, too.

    cells: number of the map's cells; stacks (`opacity.numbers_of`,): changed in place.
    """
    stride = TEXELS * (layers + 1)
    for cell in prange(cells):
        head = np.uint64(HEAD * cell)
        number = np.int64(stacks[head + np.uint64(ROW)])
        if number == 0:
            continue
        at = np.uint64(HEAD * cells + number * stride)
        one = two = three = four = ZERO
        for _ in range(layers + 1):
            one += stacks[at]
            two += stacks[at + NEXT]
            three += stacks[at + NEXT + NEXT]
            four += stacks[at + NEXT + NEXT + NEXT]
            stacks[at] = one
            stacks[at + NEXT] = two
            stacks[at + NEXT + NEXT] = three
            stacks[at + NEXT + NEXT + NEXT] = four
            at += np.uint64(TEXELS)
        for texel in range(np.uint64(TEXELS)):
            stacks[head + np.uint64(WHOLE) + texel] = stacks[at - np.uint64(TEXELS) + texel]
