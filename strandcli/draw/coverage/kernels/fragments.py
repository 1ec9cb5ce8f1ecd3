"""Fragments of a tile, from the strand segments in it: runs of thin segments as cells, wide segments as ribbons."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ....jit import device, inlined
from ....jit.indices import first_not_below
from ....simd import half_width_pointer, load, pointer, prefetch, store
from ...common.kernels.numbers import HALF, ONE, STEPS, ZERO
from . import cells
from . import segments as seg
from .cells import CELLS, LANES, cover_cells, write_fragment
from .ribbon import cover_ribbon
from .segments import BEHIND, NO_LENGTH, RIBBON, SEGMENTS, from_axis, load_vertices, measure_joints, measure_segments
from .tile_binning import LOW, SHIFT, START_AND_FIRST, STRAND_AND_LAST
from .tiles import ROW_BITS, THIN, TILE_HEIGHT, TILE_WIDTH, find_windows

AHEAD = np.int64(8)
"""Rows of segments that memory is prefetched ahead of their use."""
FAR_AHEAD = np.int64(20)
"""Rows of segments that where they begin and end is prefetched ahead of their use."""
LINE = np.int64(16)
"""32-bit numbers of a cache line."""
EVERY = np.int64(4096)
"""Fragments after which the windows of a tile are found anew."""
A_ROW = np.int64(8)
"""Fragments that a row of segments counts for there, in addition to its own."""
NEAREST = np.float32(np.inf)
"""Depth number in front of which nothing is."""


class Strands(NamedTuple):
    """The strands of a picture, as all tiles see them."""

    first: NDArray[np.int64]
    screen: NDArray[np.float32]
    widths: NDArray[np.float32] | None
    """These as in `strandcli.draw.geometry.kernels.ribbon.ScreenLines`."""
    opacity: np.float32
    """Opacity of the material."""
    depth_slope: Any
    """`strandcli.draw.common.kernels.view_columns.DepthSlope`"""
    stride: int
    """Every stride-th vertex is lit."""


class SolidPixels(NamedTuple):
    """Occlusion by solids, and the E edge pixels that a solid covers in part, which become fragments."""

    hides: NDArray[np.float32]
    """(height * width,) depth number behind which nothing is visible; (0,): there are no solids."""
    pixels: NDArray[np.int64]
    """(E,) y * width + x, ascending."""
    depth: NDArray[np.float32]
    """(E,) depth number of the solid."""
    cover: NDArray[np.float32]
    """(E,) share of the pixel that it covers."""


class SegmentRow(NamedTuple):
    """A row of consecutive segments of one strand."""

    begin: int
    end: int
    """Vertices of the strand: begin … end − 1."""
    low: int
    high: int
    """Last vertices of its first and of its last segment."""
    start: np.float32
    """Where the run of its first segment began, along (see `segments`)."""


@device
def find_fragments(strands, solids, pool, slots, width, work, target, marks):
    """Find the fragments of strands and of solids' edges in a tile; return their number, without those that are found
    to be hidden by others.

    strands: `Strands`; solids: `SolidPixels`; pool: of `tile_binning.TileSegments`; slots: from `crowds.list_rows`;
    width: of the picture; work: `cells.Work`; target: `cells.Target`, written; marks (V,): only prefetched, because
    compositing writes to it soon.
    """
    target.counts[:] = 0
    target.through[:] = ONE
    target.least[:] = NEAREST
    target.widest[0] = ZERO
    copy_occlusion(solids.hides, width, target)
    find_windows(target.occlusion_depth, target.blocks, target.windows)
    n = np.int64(0)
    m = add_solids(solids, strands.screen.shape[0], width, target)
    last = slots.shape[0] - 1
    due = m + EVERY
    for i in range(last + 1):
        prefetch(pointer(pool), 2 * np.int64(slots[min(i + FAR_AHEAD, last)]))
        prefetch_row(pool, np.int64(slots[min(i + AHEAD, last)]), strands, strands.widths, marks)
        slot = np.int64(slots[i])
        s = pool[slot, STRAND_AND_LAST] >> SHIFT
        row = SegmentRow(
            strands.first[s], strands.first[s + 1],
            pool[slot, START_AND_FIRST] & LOW, pool[slot, STRAND_AND_LAST] & LOW,
            np.uint32(pool[slot, START_AND_FIRST] >> SHIFT).view(np.float32),
        )  # fmt: skip
        n, m = add_row(row, strands, strands.widths, work, n, target, m)
        if m + A_ROW * i >= due:
            find_windows(target.occlusion_depth, target.blocks, target.windows)
            due = m + A_ROW * i + EVERY
    return cover_cells(work, n, target, m)


@inlined
def prefetch_row(pool, slot, strands, widths, marks):
    """Prefetch the vertices of the row of segments at index `slot` of the pool."""
    low = (pool[slot, START_AND_FIRST] & LOW) - 1
    high = pool[slot, STRAND_AND_LAST] & LOW
    prefetch(pointer(strands.first), pool[slot, STRAND_AND_LAST] >> SHIFT)
    prefetch(pointer(strands.screen), 3 * low)
    prefetch(pointer(strands.screen), 3 * low + LINE)
    prefetch(pointer(strands.screen), 3 * high + 2)
    prefetch(pointer(marks), low)
    if widths is not None:
        prefetch(pointer(widths), low)
        prefetch(pointer(widths), high)


@device
def add_solids(solids, base, width, target):
    """Append a fragment for each edge pixel of a solid in the tile, with the vertex base + e for edge pixel e; return
    their number."""
    m = np.int64(0)
    pixels = solids.pixels
    for e in range(first_not_below(pixels, target.top * width), first_not_below(pixels, target.bottom * width)):
        x = pixels[e] % width
        if target.left <= x < target.right and solids.cover[e] > ZERO:
            pixel = (pixels[e] // width - target.top) << ROW_BITS | (x - target.left)
            write_fragment(target.found, m, solids.depth[e], solids.cover[e], base + e, 0, pixel)
            target.counts[pixel] += 1
            m += 1
    return m


@inlined
def add_row(row, strands, widths, work, n, target, m):
    """Collect the cells of a row's thin segments and draw its wide ones; return the new numbers n of collected cells
    and m of fragments.

    row: `SegmentRow`; widths: of the strands; other arguments as in `find_fragments`. A thin segment is drawn when the
    next segment is known, which tells whether its run ends; segments without length are skipped, and those that lie
    behind all that can be seen in their part of the tile.
    """
    rows = work.segments
    points = half_width_pointer(strands.screen)
    left, top = np.float32(target.left), np.float32(target.top)
    far = from_axis(left, np.float32(target.right), top, np.float32(target.bottom), strands.depth_slope)
    run = RIBBON
    start = row.start
    v = row.low - 1
    k = np.int64(0)
    base = row.low
    while True:
        count = min(max(row.high + 1 - base, 0) + 1, min(row.end - base, SEGMENTS))
        load_vertices(points, widths, base - 1, count + 1, rows)
        ribbons = measure_segments(
            rows, widths, count, strands.opacity, left, top, far, strands.depth_slope, target.windows
        )
        if ribbons:
            measure_joints(points, base, count, row.begin, row.end, rows)
        ends = np.int64(base + count == row.end)
        if ends:
            rows[seg.KIND + count + 1] = BEHIND
        for i in range(1, count + 1 + ends):
            kind = rows[seg.KIND + i]
            if kind == NO_LENGTH:
                continue
            after = base + i - 1
            if widths is not None:  # noqa: SIM102  a condition of its own is pruned if widths is None
                if (run != RIBBON) & (run != BEHIND) & (not rows[seg.NEAREST + k] < rows[seg.HIDDEN + k]):
                    place = ((v - 1 - row.begin) & (2 * strands.stride - 1)) << target.place_bits
                    n, m = list_cells(work, k, v, place, run, start, kind != run, n, target, m)
            if after > row.high:
                return n, m
            if (kind == RIBBON) & (not rows[seg.NEAREST + i] < rows[seg.HIDDEN + i]):
                m = cover_ribbon(strands, widths, after, row.begin, i, work, target, m)
            if kind != run:
                start = rows[seg.BEGIN + i] if v >= row.low else start
                run = kind
            v = after
            k = i
        for one in range(seg.SEGMENT_ROWS):  # the segment before those that are loaded next
            rows[seg.KIND + one * seg.ROW] = rows[seg.KIND + one * seg.ROW + k]
        k = np.int64(0)
        base += count


@inlined
def list_cells(work, k, v, place, run, start, closing, n, target, m):
    """Collect the cells that segment number k, from vertex v − 1 to v, leaves, and, if `closing`, the cell in which its
    run ends; draw the cells collected so far if there is no room. Return the new numbers n of cells and m of fragments.

    place: fixed-point position of the segment's beginning (see `tiles`); run: kind of the segments; start:
    where the run begins, along.

    Most segments leave few cells: a whole vector is written, and the next segment overwrites the excess.
    """
    p = pointer(work.segments)
    flat = abs(run) == 1
    low = target.left if flat else target.top
    high = target.right if flat else target.bottom
    cell = max(np.int64(p[seg.FIRST + k]), low if run > 0 else -high)
    stop = min(np.int64(p[seg.LAST + k]) + np.int64(closing), high if run > 0 else -low)
    sign = ONE if run > 0 else -ONE
    back = ZERO if run > 0 else ONE
    floats = half_width_pointer(work.cells)
    integers = half_width_pointer(work.numbers)
    steps = load(half_width_pointer(STEPS), 0)
    while cell < stop:
        if n > CELLS - LANES:
            m = cover_cells(work, n, target, m)
            n = np.int64(0)
        here = steps + np.float32(cell)
        enter = max(here, start)
        length = min(here + ONE, p[seg.END + k]) - enter
        past = enter + HALF * length - p[seg.BEGIN + k]
        t = min(max(past * p[seg.PER_LENGTH + k], ZERO), ONE)
        store(floats, cells.DEPTH + n, p[seg.BEGIN_DEPTH + k] + p[seg.DEPTH_RISE + k] * t)
        store(floats, cells.MIDDLE + n, p[seg.ACROSS + k] + p[seg.SLOPE + k] * past)
        width = p[seg.BEGIN_WIDTH + k] + t * p[seg.WIDENING + k]
        store(floats, cells.AREA + n, p[seg.STRETCH + k] * length * width)
        store(floats, cells.RISE + n, abs(p[seg.SLOPE + k]) * length)
        store(floats, cells.H + n, max(p[seg.HEIGHT + k] + t * p[seg.GROWTH + k], THIN))
        store(floats, cells.ALONG + n, t)
        store(floats, cells.CELL + n, sign * here - back)
        store(integers, cells.PLACE + n, place)
        store(integers, cells.VERTEX + n, v - 1)
        store(integers, cells.FLAT_MASK + n, -np.int64(flat))
        n += min(stop - cell, LANES)
        cell += LANES
    return n, m


@device
def copy_occlusion(hides, width, target):
    """Copy the depth numbers behind which solids hide all to the tile; nothing is visible outside the picture."""
    depth = target.occlusion_depth
    if hides.shape[0] == 0 or target.bottom - target.top < TILE_HEIGHT or target.right - target.left < TILE_WIDTH:
        depth[:] = NEAREST
    for y in range(target.top, target.bottom):
        to = np.uint64((y - target.top) << ROW_BITS)
        at = np.uint64(y * width + target.left)
        for x in range(np.uint64(target.right - target.left)):
            depth[to + x] = hides[at + x] if hides.shape[0] > 0 else ZERO
