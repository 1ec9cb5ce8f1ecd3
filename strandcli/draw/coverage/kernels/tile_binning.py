"""Lists of the strand segments that overlap each tile, as chains of blocks from a common pool.

Each worker has a share of the pool and its own chain for every tile, so no worker waits for another. An entry is a row
of consecutive segments of one strand whose bounding boxes all touch the tile.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ....jit import device, inlined, parallel, prange
from ....simd import any_lane, floor, gather, half_width_pointer, lane_count, load, store, where
from ...common.kernels.numbers import HALF, ONE, ZERO
from ...geometry.kernels.ribbon import GREATEST_Y, LEAST_Y
from . import segments as seg
from .tiles import TILE_HEIGHT, TILE_WIDTH, PictureWindows, window_of

OUTSIDE = np.float32(-max(TILE_WIDTH, TILE_HEIGHT))
"""Coordinate in tile number −1."""
PER_X = np.float32(1 / TILE_WIDTH)
PER_Y = np.float32(1 / TILE_HEIGHT)
"""Tiles a pixel."""
BLOCK = 16
"""Rows of segments a block."""
IN_BLOCK = np.int64(BLOCK - 1)
BLOCK_BITS = np.int64(4)
START_AND_FIRST, STRAND_AND_LAST = 0, 1
"""Columns of the pool, see `TileSegments.pool`."""
SHIFT = np.int64(32)
LOW = np.int64(0xFFFFFFFF)
"""Bits and mask of the lower half of a number of the pool."""


# Rows of the scratch array: X, Y, DEPTH, WIDTH, KIND and BEGIN of `segments`, and the tiles that each segment can
# touch, LEFT <= column < RIGHT and UP <= row < DOWN.
LEFT, RIGHT, UP, DOWN = (i * seg.ROW for i in range(6, 10))
ROWS = 10


class TileSegments(NamedTuple):
    """The rows of segments in each tile: for each worker and tile a chain of blocks from one pool."""

    pool: NDArray[np.int64]
    """(blocks * BLOCK, 2) rows of segments. `START_AND_FIRST`: where the run of the first segment began (bits of a
    float32, see `cells`), above that segment's last vertex. `STRAND_AND_LAST`: the strand, above the last vertex of the
    last segment."""
    depths: NDArray[np.float32]
    """(blocks * BLOCK,) depth number of each row's first vertex."""
    links: NDArray[np.int64]
    """(blocks,) next block in the chain."""
    heads: NDArray[np.int64]
    """(workers, tiles) first block of each chain."""
    fills: NDArray[np.int64]
    """(workers, tiles) index in the pool after the last row of each chain; 0: the chain is empty."""
    used: NDArray[np.int64]
    """(workers,) number of blocks that each worker needed, even beyond its share."""


class Chains(NamedTuple):
    """The chains that one worker writes."""

    segments: TileSegments
    worker: int
    begin: int
    last: int
    """Its first and last block; rows for which there is no room are written to the last."""
    opened: NDArray[np.int64]
    """(tiles,) `START_AND_FIRST` of the open row of segments in each tile that has one."""
    across: int
    """Tiles across the picture."""
    screen: NDArray[np.float32]
    """As in `ScreenLines`."""


class Region(NamedTuple):
    """The rows of a picture that are tiled."""

    above: np.float32
    """The first one."""
    wide: np.float32
    tall: np.float32
    """Its width and height."""
    far: np.float32
    """As in `segments.nearest_of`."""
    depth_slope: Any
    """`strandcli.draw.common.kernels.view_columns.DepthSlope`"""
    windows: PictureWindows


class TileRange(NamedTuple):
    """The tiles left <= column < right, up <= row < down, integers as float32."""

    left: np.float32
    right: np.float32
    up: np.float32
    down: np.float32


@parallel
def bin_segments(lines, extents, top, bottom, width, workers, segments, windows, depth_slope):
    """Append the segments that can touch the rows top <= y < bottom of a picture to the chains of their tiles, but
    those that solids hide.

    lines: `ScreenLines`; extents: from `geometry.kernels.ribbon.find_on_screen`; width: of the picture; segments:
    `TileSegments`, whose fills and used are 0 before; windows: `PictureWindows`; depth_slope: `DepthSlope`. The first
    tiles begin at row `top`. Workers share strands and blocks evenly. If `used` of a worker is not less than its share
    of the blocks, there was no room and the chains are invalid.
    """
    share = segments.links.shape[0] // workers
    strands = lines.first.shape[0] - 1
    for one in prange(workers):
        task = np.int64(one)  # the index is unsigned; sums of it and signed integers would be floats
        opened = np.empty(segments.heads.shape[1], np.int64)
        across = np.int64((width + TILE_WIDTH - 1) // TILE_WIDTH)
        chains = Chains(segments, task, task * share, (task + 1) * share - 1, opened, across, lines.screen)
        wide, above, below = np.float32(width), np.float32(top), np.float32(bottom)
        region = Region(
            above, wide, below - above, seg.from_axis(ZERO, wide, above, below, depth_slope), depth_slope, windows
        )  # fmt: skip
        bin_strands(
            task * strands // workers, (task + 1) * strands // workers, lines, extents, region, chains,
            np.empty(ROWS * seg.ROW, np.float32),
        )  # fmt: skip


@device
def bin_strands(low, high, lines, extents, region, chains, work):
    """Append the segments of the strands low … high − 1 to the `Chains` of one worker; region: `Region`; work
    (ROWS * ROW,) float32: scratch; other arguments as in `bin_segments`."""
    points = half_width_pointer(lines.screen)
    above, below = region.above, region.above + region.tall
    nowhere = TileRange(ZERO, ZERO, ZERO, ZERO)
    for s in range(low, high):
        if not (extents[s, LEAST_Y] < below and extents[s, GREATEST_Y] >= above):
            continue
        end = lines.first[s + 1]
        run = seg.RIBBON
        start = ZERO
        v = lines.first[s]
        open_ = nowhere  # the tiles in which a row of segments is open
        for base in range(v + 1, end, seg.SEGMENTS):
            count = min(end - base, seg.SEGMENTS)
            seg.load_vertices(points, lines.widths, base - 1, count + 1, work)
            find_tiles(work, lines.widths, count, region)
            for i in range(1, count + 1):
                kind = work[seg.KIND + i]
                if kind == seg.NO_LENGTH:
                    continue
                if kind != run:
                    start = work[seg.BEGIN + i]
                    run = kind
                new = TileRange(work[LEFT + i], work[RIGHT + i], work[UP + i], work[DOWN + i])
                if (
                    (new.left != open_.left) | (new.right != open_.right)
                    | (new.up != open_.up) | (new.down != open_.down)
                ):  # fmt: skip
                    here = np.int64(np.float32(start).view(np.uint32)) << SHIFT | (base + i - 1)
                    change_rows(open_, new, s << SHIFT | v, here, chains)
                    open_ = new
                v = base + i - 1
        change_rows(open_, nowhere, s << SHIFT | v, np.int64(0), chains)


@device
def find_tiles(work, widths, count, region):
    """Store the rows KIND, BEGIN, LEFT, RIGHT, UP and DOWN of the segments between count + 1 vertices; widths:
    as in `segments.kind_of`; region: `Region`. A hidden segment touches no tile."""
    rows = half_width_pointer(work)
    wide, tall = region.wide, region.tall
    for k in range(0, count, lane_count(rows)):
        x0, y0, q0, w0 = (
            load(rows, seg.X + k),
            load(rows, seg.Y + k),
            load(rows, seg.DEPTH + k),
            load(rows, seg.WIDTH + k),
        )
        k += 1
        x1, y1, q1, w1 = (
            load(rows, seg.X + k),
            load(rows, seg.Y + k),
            load(rows, seg.DEPTH + k),
            load(rows, seg.WIDTH + k),
        )
        w = max(w0, w1)
        kind = seg.kind_of(x1 - x0, y1 - y0, min(q0, q1), w, widths)
        store(rows, seg.KIND + k, kind)
        store(rows, seg.BEGIN + k, seg.along(kind, x0, y0))
        reach_x, reach_y = seg.reach_of(kind, w)
        left, right = min(x0, x1) - reach_x, max(x0, x1) + reach_x
        up, down = min(y0, y1) - reach_y, max(y0, y1) + reach_y
        there = kind < seg.BEHIND
        if region.windows.depths.shape[0] > 0:
            blocks = np.float32(region.windows.across), np.float32(region.windows.down)
            here = window_of(left, right, up, down, blocks)
            hidden = gather(half_width_pointer(region.windows.depths), 0, here, 1, ZERO)
            if any_lane(max(q0, q1) < hidden):
                per = ONE / (seg.along(kind, x1, y1) - seg.along(kind, x0, y0))
                there = there & ~(seg.nearest_of(q0, q1, w, per, region.far, region.depth_slope) < hidden)
        up -= region.above
        down -= region.above
        store(rows, LEFT + k, tile_of(there, left, ZERO, wide, PER_X, ZERO))
        store(rows, UP + k, tile_of(there, up, ZERO, tall, PER_Y, ZERO))
        store(rows, RIGHT + k, tile_of(there, right, OUTSIDE, wide - HALF, PER_X, ONE))
        store(rows, DOWN + k, tile_of(there, down, OUTSIDE, tall - HALF, PER_Y, ONE))


@inlined
def tile_of(there, x, low, high, per, more):
    """Return the number of the tile at x, clamped to low … high, plus `more`, or 0 where `there` is false; NaN counts
    as low. Vectors."""
    return where(there, floor(min(high, max(low, x)) * per + more), ZERO)


@inlined
def change_rows(old, new, end, here, chains):
    """Append to the chains the rows of segments that are open in the tiles `old` and not continued in `new`, and open
    one in those of `new` that are not among `old`; end: `STRAND_AND_LAST` of the former, here: `START_AND_FIRST` of the
    latter."""
    task = chains.worker
    for y in range(np.int64(old.up), np.int64(old.down)):
        for x in range(np.int64(old.left), np.int64(old.right)):
            if (x >= new.left) & (x < new.right) & (y >= new.up) & (y < new.down):
                continue
            tile = y * chains.across + x
            slot = chains.segments.fills[task, tile]
            if slot & IN_BLOCK == 0:
                slot = add_block(slot, tile, chains)
            chains.segments.fills[task, tile] = slot + 1
            chains.segments.pool[slot, START_AND_FIRST] = chains.opened[tile]
            chains.segments.pool[slot, STRAND_AND_LAST] = end
            chains.segments.depths[slot] = chains.screen[(chains.opened[tile] & LOW) - 1, 2]

    for y in range(np.int64(new.up), np.int64(new.down)):
        for x in range(np.int64(new.left), np.int64(new.right)):
            if not ((x >= old.left) & (x < old.right) & (y >= old.up) & (y < old.down)):
                chains.opened[y * chains.across + x] = here


@device
def add_block(slot, tile, chains):
    """Return the first index in the pool of a new block for a tile's chain; slot: end of the chain, whose last block is
    full."""
    task = chains.worker
    block = min(chains.begin + chains.segments.used[task], chains.last)
    chains.segments.used[task] += 1
    if slot == 0:
        chains.segments.heads[task, tile] = block
    else:
        chains.segments.links[(slot - 1) >> BLOCK_BITS] = block
    return block << BLOCK_BITS
