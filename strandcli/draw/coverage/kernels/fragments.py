"""From the segments of strands in a tile to its fragments: segments in runs, and cells of which many are covered at
once."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ....jit import device, inlined
from ....simd import half_width_pointer, load, pointer, prefetch, store
from .cells import (
    ALONG,
    AREA,
    CELL,
    CELLS,
    DEPTH,
    FLAT_WAY,
    LANES,
    MIDDLE,
    PLACE,
    RISE,
    VERTEX,
    ZERO,
    H,
    add_fragment,
    cover_cells,
)
from .ribbon import cover_ribbon
from .segments import (
    ACROSS,
    BEGIN,
    BEHIND,
    DEEPER,
    END,
    FIRST,
    HEIGHT,
    LAST,
    NEAREST,
    NO_WAY,
    PER,
    PIECES,
    RIBBON,
    SLOPE,
    STRETCH,
    WAY,
    WIDER,
    Q,
    W,
    keep_last,
    load_vertices,
    measure_segments,
)
from .tile_binning import BLOCK, LOW, SHIFT
from .tiles import ROW_BITS

HALF = np.float32(0.5)
ONE = np.float32(1.0)
AHEAD = np.int64(2)
"""Rows of segments whose memory is prefetched before they are looked at."""
LINE = np.int64(16)
EIGHT = np.int64(8)
"""Numbers of a cache line, and of one of longer numbers."""
STEPS = np.arange(LANES, dtype=np.float32)
SURE = np.float32(1 - 1e-6)
"""What is so much behind is behind, whatever the rounding."""


class Strands(NamedTuple):
    """The strands of a picture, as all tiles see them."""

    first: NDArray[np.int64]
    screen: NDArray[np.float32]
    widths: NDArray[np.float32] | None
    """These as in `strandcli.draw.geometry.kernels.screen_lines.ScreenLines`."""
    opacity: np.float32
    """Of the material."""
    depth_slope: Any
    """`strandcli.draw.view.kernels.depth_slope.DepthSlope`"""
    stride: int
    """Every so-manieth vertex is lit."""


class SolidPixels(NamedTuple):
    """What solids hide of a picture, and the E pixels that one of them covers in part; these become fragments."""

    hides: NDArray[np.float32]
    """(height * width,) depth number behind which nothing is seen; (0,) where there is no solid."""
    pixels: NDArray[np.int64]
    """(E,) y * width + x, ascending."""
    depth: NDArray[np.float32]
    """(E,) depth number of the solid."""
    cover: NDArray[np.float32]
    """(E,) its share of the pixel."""


class SegmentRow(NamedTuple):
    """A row of consecutive segments of one strand."""

    begin: int
    end: int
    """The strand's vertices are begin … end − 1."""
    low: int
    high: int
    """Vertices that its first and its last segment end in."""
    start: np.float32
    """Where the run of its first segment began, along the axis that it follows."""


@device
def find_fragments(strands, solids, segments, tile, width, work, target, marks):
    """Find a tile's fragments, those of strands and those of solids, and return how many there are.

    strands: `Strands`; solids: `SolidPixels`; segments: `tile_binning.TileSegments` of all tiles; tile: its number;
    width of the picture; work: `cells.Work`; target: `cells.Target`, written. marks (V,): not read, but soon to
    be written to, as all that is seen.
    """
    target.counts[:] = 0
    hidden = ZERO  # depth number behind which nothing in the tile is seen
    if solids.hides.shape[0] == 0:
        target.occlusion_depth[:] = ZERO
    else:
        hidden = copy_occlusion(solids.hides, width, target) * SURE
    pool = segments.pool
    n = np.int64(0)
    m = add_solids(solids, strands.screen.shape[0], width, target)
    for one in range(segments.heads.shape[0]):
        block = segments.heads[one, tile]
        stop = segments.fills[one, tile]
        while stop > 0:
            final = block == (stop - 1) // BLOCK
            after = block if final else segments.links[block]
            for line in range(0, 2 * BLOCK, EIGHT):
                prefetch(pointer(pool), 2 * BLOCK * after + line)
            for slot in range(block * BLOCK, stop if final else block * BLOCK + BLOCK):
                prefetch_row(pool, min(slot + AHEAD, pool.shape[0] - 1), strands, strands.widths, marks)
                s = pool[slot, 1] >> SHIFT
                row = SegmentRow(
                    strands.first[s], strands.first[s + 1], pool[slot, 0] & LOW, pool[slot, 1] & LOW,
                    np.uint32(pool[slot, 0] >> SHIFT).view(np.float32),
                )  # fmt: skip
                n, m = add_row(row, strands, strands.widths, hidden, work, n, target, m)
            if final:
                break
            block = after
    return cover_cells(work, n, target, m)


@inlined
def prefetch_row(pool, slot, strands, widths, marks):
    """Prefetch what the row of segments in a slot needs."""
    low = (pool[slot, 0] & LOW) - 1
    prefetch(pointer(strands.first), pool[slot, 1] >> SHIFT)
    prefetch(pointer(strands.screen), 3 * low)
    prefetch(pointer(strands.screen), 3 * low + LINE)
    prefetch(pointer(marks), low)
    if widths is not None:
        prefetch(pointer(widths), low)


@device
def add_solids(solids, base, width, target):
    """Add what solids cover of the tile's pixels that they cover in part, as vertices from number `base` on; returns
    how many fragments these are."""
    m = np.int64(0)
    pixels = solids.pixels
    for e in range(np.searchsorted(pixels, target.top * width), np.searchsorted(pixels, target.bottom * width)):
        x = pixels[e] % width
        if target.left <= x < target.right and solids.cover[e] > ZERO:
            pixel = (pixels[e] // width - target.top) << ROW_BITS | (x - target.left)
            m = add_fragment(target, m, solids.depth[e], solids.cover[e], base + e, 0, pixel)
    return m


@inlined
def add_row(row, strands, widths, hidden, work, n, target, m):
    """List the cells of a row's thin segments, beside the n before, and draw its wide ones, beside the m fragments
    before; returns how many cells are listed then, and how many fragments were found.

    hidden: depth number behind which nothing is seen. A thin segment waits for the next one, which tells whether its
    run goes on: points do not, nor does the strand's end.
    """
    pieces = work.segments
    points = half_width_pointer(strands.screen)
    run = RIBBON
    start = row.start
    v = row.low - 1
    k = np.int64(0)
    base = row.low
    while True:
        count = min(max(row.high + 1 - base, 0) + 1, min(row.end - base, PIECES))
        load_vertices(points, widths, base - 1, count + 1, pieces)
        measure_segments(pieces, count, strands.opacity)
        ends = np.int64(base + count == row.end)
        if ends:
            pieces[WAY + count + 1] = BEHIND
        for i in range(1, count + 1 + ends):
            way = pieces[WAY + i]
            if way == NO_WAY:
                continue
            after = base + i - 1
            if widths is not None:  # noqa: SIM102  a branch of its own is left out where there are none
                if (run != RIBBON) & (run != BEHIND) & (not pieces[NEAREST + k] < hidden):
                    place = ((v - 1 - row.begin) & (strands.stride - 1)) << target.place_bits
                    n, m = list_cells(work, k, v, place, run, start, way != run, n, target, m)
            if after > row.high:
                return n, m
            if way == RIBBON:
                m = cover_ribbon(strands, widths, after, row.begin, row.end, target, m)
            if way != run:
                start = pieces[BEGIN + i] if v >= row.low else start
                run = way
            v = after
            k = i
        keep_last(pieces, k)
        k = np.int64(0)
        base += count


@inlined
def list_cells(work, k, v, place, run, start, closing, n, target, m):
    """List the cells that segment number k, from vertex v − 1 to v, leaves behind, and, `closing`, the one that its run
    ends in; covers those listed so far where there are too many.

    place: of the segment's beginning after a lit vertex (see `tiles.fixed`); run: 1 along x, 2 along y, negative
    against the axis; start: where the run begins, in the direction of travel; n: cells listed before; m: fragments
    found before. Returns how many there are then.

    Most segments leave few cells: a vector of them is written, and what is too many written over by the next.
    """
    p = pointer(work.segments)
    flat = abs(run) == 1
    low = target.left if flat else target.top
    high = target.right if flat else target.bottom
    cell = max(np.int64(p[FIRST + k]), low if run > 0 else -high)
    stop = min(np.int64(p[LAST + k]) + np.int64(closing), high if run > 0 else -low)
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
        length = min(here + ONE, p[END + k]) - enter
        past = enter + HALF * length - p[BEGIN + k]
        t = min(max(past * p[PER + k], ZERO), ONE)
        store(floats, DEPTH + n, p[Q + k] + p[DEEPER + k] * t)
        store(floats, MIDDLE + n, p[ACROSS + k] + p[SLOPE + k] * past)
        store(floats, AREA + n, p[STRETCH + k] * length * (p[W + k] + t * p[WIDER + k]))
        store(floats, RISE + n, abs(p[SLOPE + k]) * length)
        store(floats, H + n, p[HEIGHT + k])
        store(floats, ALONG + n, t)
        store(floats, CELL + n, sign * here - back)
        store(integers, PLACE + n, place)
        store(integers, VERTEX + n, v - 1)
        store(integers, FLAT_WAY + n, -np.int64(flat))
        n += min(stop - cell, LANES)
        cell += LANES
    return n, m


@device
def copy_occlusion(hides, width, target):
    """Copy the depth numbers behind which solids hide all, of the tile's pixels; returns the least."""
    least = np.int32(np.float32(np.inf).view(np.int32))
    depth = target.occlusion_depth
    for y in range(target.top, target.bottom):
        to = np.uint64((y - target.top) << ROW_BITS)
        at = np.uint64(y * width + target.left)
        for x in range(np.uint64(target.right - target.left)):
            depth[to + x] = hides[at + x]
        for x in range(np.uint64(target.right - target.left)):  # the bits of what is not negative are in its order
            least = min(least, np.int32(np.float32(depth[to + x]).view(np.int32)))
    return np.int32(least).view(np.float32)
