"""Which segments of strands lie in which tile: chains of blocks out of one pool.

Each worker has its share of the pool and a chain of its own in every tile, so no worker waits for another. What is
listed are rows of consecutive segments of one strand, as long as their boxes touch the tile.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ....jit import device, inlined, parallel, prange
from ....simd import floor, half_width_pointer, lane_count, load, store, where
from .segments import (
    ALONG_X,
    ALONG_Y,
    BEGIN,
    BEHIND,
    DEPTH,
    NO_WAY,
    PIECES,
    RIBBON,
    ROW,
    WAY,
    WIDTH,
    X,
    Y,
    along,
    load_vertices,
    way_of,
)
from .tiles import TILE_HEIGHT, TILE_WIDTH

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
OUTSIDE = np.float32(-max(TILE_WIDTH, TILE_HEIGHT))
PER_X = np.float32(1 / TILE_WIDTH)
PER_Y = np.float32(1 / TILE_HEIGHT)
BLOCK = 16
"""Rows of segments a block."""
IN_BLOCK = np.int64(BLOCK - 1)
BLOCK_BITS = np.int64(4)
SHIFT = np.int64(32)
LOW = np.int64(0xFFFFFFFF)
REACH = np.float32(1.1)
"""Pixels that a piece reaches beyond its ends, but for its width: what it rises within a cell."""
MITRE = np.float32(0.7072)
"""Of its width, that a piece reaches beyond its ends: half, at the slant of a mitre."""


# Rows of numbers beside those of `segments` (X, Y, DEPTH and WIDTH, one a vertex; WAY and BEGIN, one a segment): the
# tiles that each segment touches, from LEFT to before RIGHT, from UP to before DOWN.
LEFT, RIGHT, UP, DOWN = (i * ROW for i in range(6, 10))
ROWS = 10


class TileSegments(NamedTuple):
    """Which rows of segments lie in which tile: for each worker and tile a chain of blocks out of one pool."""

    pool: NDArray[np.int64]
    """(blocks * BLOCK, 2) a row of segments: where the run of its first one began (the bits of a float32) above the
    vertex that this segment ends in; the strand above the vertex that its last segment ends in."""
    links: NDArray[np.int64]
    """(blocks,) the block after each in its chain."""
    heads: NDArray[np.int64]
    """(workers, tiles) the first block of each chain."""
    fills: NDArray[np.int64]
    """(workers, tiles) the slot of the pool after the last row of each chain; 0: the chain is empty."""
    used: NDArray[np.int64]
    """(workers,) blocks that each worker asked for."""


class Chains(NamedTuple):
    """The chains that one worker writes."""

    pool: NDArray[np.int64]
    links: NDArray[np.int64]
    heads: NDArray[np.int64]
    fills: NDArray[np.int64]
    used: NDArray[np.int64]
    """These as in `TileSegments`."""
    worker: int
    begin: int
    last: int
    """Its blocks; the last one is a place for what finds no room."""
    opened: NDArray[np.int64]
    """(tiles,) of each tile in which a row of segments is open, the first number of `TileSegments.pool` for it."""
    across: int
    """Tiles of the picture's width."""


class TileRange(NamedTuple):
    """Tiles from left to before right, from up to before down, as whole float32 numbers."""

    left: np.float32
    right: np.float32
    up: np.float32
    down: np.float32


@parallel
def bin_segments(lines, rows, top, bottom, width, workers, segments):
    """Append the segments of strands that can touch the rows top <= y < bottom of a picture of this width to the chains
    of their tiles, which begin at row `top`.

    lines: `ScreenLines`; rows (S, 2): as from `spans`; segments: `TileSegments`, whose fills and used are 0 before. The
    `workers` share strands and blocks evenly. Where one of them asked for more blocks than its share but one, there was
    no room for all, and no chain holds.
    """
    share = segments.links.shape[0] // workers
    strands = lines.first.shape[0] - 1
    for one in prange(workers):
        task = np.int64(one)  # the index is unsigned, and would make floats of what it is added to
        opened = np.empty(segments.heads.shape[1], np.int64)
        across = np.int64((width + TILE_WIDTH - 1) // TILE_WIDTH)
        chains = Chains(
            segments.pool, segments.links, segments.heads, segments.fills, segments.used, task, task * share,
            (task + 1) * share - 1, opened, across,
        )  # fmt: skip
        bin_strands(
            task * strands // workers, (task + 1) * strands // workers, lines, rows, top, bottom, width, chains,
            np.empty(ROWS * ROW, np.float32),
        )  # fmt: skip


@device
def bin_strands(low, high, lines, rows, top, bottom, width, chains, work):
    """What `bin_segments` does for one worker, with the strands from `low` to before `high`; work (ROWS * ROW,)
    float32 to work with.

    A row of segments goes on as long as their boxes touch the tile.
    """
    points = half_width_pointer(lines.screen)
    wide = np.float32(width)
    tall = np.float32(bottom - top)
    above = np.float32(top)
    nowhere = TileRange(ZERO, ZERO, ZERO, ZERO)
    for s in range(low, high):
        if not (rows[s, 0] < np.float32(bottom) and rows[s, 1] >= above):
            continue
        end = lines.first[s + 1]
        run = RIBBON
        start = ZERO
        v = lines.first[s]
        open_ = nowhere  # the tiles in which a row of segments is open
        for base in range(v + 1, end, PIECES):
            count = min(end - base, PIECES)
            load_vertices(points, lines.widths, base - 1, count + 1, work)
            find_tiles(work, count, above, wide, tall)
            for i in range(1, count + 1):
                way = work[WAY + i]
                if way == NO_WAY:
                    continue
                if way != run:
                    start = work[BEGIN + i]
                    run = way
                new = TileRange(work[LEFT + i], work[RIGHT + i], work[UP + i], work[DOWN + i])
                if (
                    (new.left != open_.left) | (new.right != open_.right)
                    | (new.up != open_.up) | (new.down != open_.down)
                ):  # fmt: skip
                    close_rows(open_, new, s << SHIFT | v, chains)
                    here = np.int64(np.float32(start).view(np.uint32)) << SHIFT | (base + i - 1)
                    open_rows(new, open_, here, chains)
                    open_ = new
                v = base + i - 1
        close_rows(open_, nowhere, s << SHIFT | v, chains)


@device
def find_tiles(work, count, above, wide, tall):
    """How the segments between count + 1 vertices go, where they begin, and which tiles they can touch of a picture so
    wide and tall whose first row is `above`: rows WAY, BEGIN, LEFT, RIGHT, UP and DOWN of work."""
    rows = half_width_pointer(work)
    for k in range(0, count, lane_count(rows)):
        x0, y0, q0, w0 = load(rows, X + k), load(rows, Y + k), load(rows, DEPTH + k), load(rows, WIDTH + k)
        k += 1
        x1, y1, q1, w1 = load(rows, X + k), load(rows, Y + k), load(rows, DEPTH + k), load(rows, WIDTH + k)
        w = max(w0, w1)
        way = way_of(x1 - x0, y1 - y0, min(q0, q1), w)
        store(rows, WAY + k, way)
        store(rows, BEGIN + k, along(way, x0, y0))
        y0 -= above
        y1 -= above
        # a thin piece's cells are those of its ends, whatever it reaches across
        reach = REACH + MITRE * w
        reach_x = where(abs(abs(way) - ALONG_X) <= ZERO, ZERO, reach)
        reach_y = where(abs(abs(way) - ALONG_Y) <= ZERO, ZERO, reach)
        there = way < BEHIND
        store(rows, LEFT + k, tile_of(there, min(x0, x1) - reach_x, ZERO, wide, PER_X, ZERO))
        store(rows, UP + k, tile_of(there, min(y0, y1) - reach_y, ZERO, tall, PER_Y, ZERO))
        store(rows, RIGHT + k, tile_of(there, max(x0, x1) + reach_x, OUTSIDE, wide - HALF, PER_X, ONE))
        store(rows, DOWN + k, tile_of(there, max(y0, y1) + reach_y, OUTSIDE, tall - HALF, PER_Y, ONE))


@inlined
def tile_of(there, x, low, high, per, more):
    """The tile at x between bounds, the lower one for what is not a number, or so many more; 0 where none is there."""
    return where(there, floor(min(high, max(low, x)) * per + more), ZERO)


@inlined
def close_rows(old, new, end, chains):
    """Append the rows of segments that are open in the tiles `old` but do not go on in `new`; end: the strand above the
    vertex that they end in."""
    task = chains.worker
    for y in range(np.int64(old.up), np.int64(old.down)):
        for x in range(np.int64(old.left), np.int64(old.right)):
            if (x >= new.left) & (x < new.right) & (y >= new.up) & (y < new.down):
                continue
            tile = y * chains.across + x
            slot = chains.fills[task, tile]
            if slot & IN_BLOCK == 0:
                slot = add_block(slot, tile, chains)
            chains.fills[task, tile] = slot + 1
            chains.pool[slot, 0] = chains.opened[tile]
            chains.pool[slot, 1] = end


@inlined
def open_rows(new, old, here, chains):
    """Open rows of segments in the tiles `new` where none is open from `old`; here: where their run began, above the
    vertex."""
    for y in range(np.int64(new.up), np.int64(new.down)):
        for x in range(np.int64(new.left), np.int64(new.right)):
            if not ((x >= old.left) & (x < old.right) & (y >= old.up) & (y < old.down)):
                chains.opened[y * chains.across + x] = here


@device
def add_block(slot, tile, chains):
    """The first slot of another block for a worker's chain in a tile, where the last one is full."""
    task = chains.worker
    block = min(chains.begin + chains.used[task], chains.last)
    chains.used[task] += 1
    if slot == 0:
        chains.heads[task, tile] = block
    else:
        chains.links[(slot - 1) >> BLOCK_BITS] = block
    return block << BLOCK_BITS
