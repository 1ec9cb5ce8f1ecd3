"""Which parts of strands lie in which tile: chains of blocks out of one pool.

Each worker has its share of the pool and a chain of its own in every tile, so nobody waits for anybody. A part is a row
of pieces of one strand, as two 64-bit numbers: where the run of its first piece began (see `coverage`), above the
vertex that this piece ends in; and the strand, above the vertex that its last piece ends in.
"""

from __future__ import annotations

import math

import numpy as np

from ....jit import device, inlined, parallel, prange
from ....simd import floor, half_width_pointer, load, store, where
from ....simd import lane_count as vector
from .segments import (
    ACROSS,
    ALONG_X,
    ALONG_Y,
    BEGIN,
    BEHIND,
    DEPTH,
    END,
    FIRST,
    LAST,
    NO_WAY,
    PIECES,
    POINT,
    RIBBON,
    ROW,
    ROWS,
    WAY,
    WIDE,
    WIDTH,
    X,
    Y,
    along,
    take,
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
"""Parts a block."""
IN_BLOCK = np.int64(BLOCK - 1)
BLOCK_BITS = np.int64(4)
SHIFT = np.int64(32)
LOW = np.int64(0xFFFFFFFF)
REACH = np.float32(1.1)
"""Pixels that a piece reaches beyond its ends, but for its width: what it rises within a cell."""
MITRE = np.float32(0.7072)
"""Of its width, that a piece reaches beyond its ends: half, at the slant of a mitre."""


LEFT, RIGHT, UP, DOWN = END, FIRST, LAST, ACROSS
"""Rows of what is needed of a piece here, in place of some of those in `pieces`."""


@parallel
def spans(first, screen, margin, width, out):
    """The rows of the screen that each strand can touch.

    first (S + 1,) int64; screen (V, 3); margin: how far it reaches beyond its vertices, pixels; width of the screen;
    out (S, 2) float32: least and greatest y, inf and −inf for a strand that is not there.
    """
    for s in prange(first.shape[0] - 1):
        low = np.float32(np.inf)
        high = np.float32(-np.inf)
        left = np.float32(np.inf)
        right = np.float32(-np.inf)
        for v in range(first[s], first[s + 1]):
            if screen[v, 2] > ZERO:
                left = min(left, screen[v, 0])
                right = max(right, screen[v, 0])
                low = min(low, screen[v, 1])
                high = max(high, screen[v, 1])
        there = (right + margin >= ZERO) & (left - margin < np.float32(width))
        out[s, 0] = low - margin if there else np.float32(np.inf)
        out[s, 1] = high + margin if there else np.float32(-np.inf)


@parallel
def toil(first, screen, widths, width, height, out):
    """About how many places of the picture have to be looked at for the wide pieces of each strand: the cells that a
    piece's box has along the axis that it follows more, times the rows that its band has across or the picture.

    first, screen, widths: as in `share_out`; width, height of the picture; out (S,) float32.
    """
    for s in prange(first.shape[0] - 1):
        total = ZERO
        for v in range(first[s] + 1, first[s + 1]):
            w = max(widths[v - 1], widths[v])
            dx = abs(screen[v, 0] - screen[v - 1, 0])
            dy = abs(screen[v, 1] - screen[v - 1, 1])
            if w > WIDE and max(dx, dy) >= POINT and screen[v - 1, 2] > ZERO and screen[v, 2] > ZERO:
                size = np.float32(math.sqrt(dx * dx + dy * dy))
                across = inside(screen[v - 1, 0], screen[v, 0], HALF * w * dy / size, np.float32(width))
                down = inside(screen[v - 1, 1], screen[v, 1], HALF * w * dx / size, np.float32(height))
                total += min(across, w * size / dy) * down if dx < dy else across * min(down, w * size / dx)
        out[s] = total


@device
def inside(one, other, reach, end):
    """How much of the way between two places, and a reach beyond both, lies between 0 and an end."""
    return max(min(max(one, other) + reach, end) - max(min(one, other) - reach, ZERO), ZERO)


@parallel
def share_out(first, screen, widths, rows, top, bottom, width, workers, pool, links, heads, fills, used):
    """Append the parts of strands that can touch the rows top <= y < bottom to the chains of their tiles, which begin
    at row `top`.

    first (S + 1,) int64; screen (V, 3) float32 as from `project.points`; widths (V,) float32 pixels, or None for lines
    one pixel wide; rows (S, 2): as from `spans`; width of the picture; pool (blocks * BLOCK, 2) int64; links (blocks,)
    int64: the block after each; heads, fills (workers, tiles) int64: the first block of each chain, and the slot after
    its last part, 0 where there is none, as before; used (workers,) int64: blocks that were asked for, 0 before. The
    `workers` share strands and blocks evenly; one that used more than its share but one had no room for all, and then
    no chain holds.
    """
    share = links.shape[0] // workers
    strands = first.shape[0] - 1
    for one in prange(workers):
        task = np.int64(one)  # the index is unsigned, and would make floats of what it is added to
        opened = np.empty(heads.shape[1], np.int64)
        worker(
            task * strands // workers, (task + 1) * strands // workers, first, screen, widths, rows, top, bottom, width,
            pool, links, heads, fills, used, task * share, (task + 1) * share - 1, task, opened,
            np.empty(ROWS * ROW, np.float32),
        )  # fmt: skip


@device
def worker(
    low, high, first, screen, widths, rows, top, bottom, width, pool, links, heads, fills, used, begin, last, task,
    opened, pieces,
):  # fmt: skip
    """What `share_out` does for one worker, with the strands from `low` to before `high`, in the blocks from `begin` to
    `last`, of which the last is only a place for what finds no room; opened (tiles,) int64 and pieces (ROWS * ROW,)
    float32 to work with.

    A part goes on as long as its pieces' boxes touch the tile.
    """
    across = np.int64((width + TILE_WIDTH - 1) // TILE_WIDTH)
    points = half_width_pointer(screen)
    wide = np.float32(width)
    tall = np.float32(bottom - top)
    above = np.float32(top)
    for s in range(low, high):
        if not (rows[s, 0] < np.float32(bottom) and rows[s, 1] >= above):
            continue
        end = first[s + 1]
        run = RIBBON
        start = ZERO
        v = first[s]
        # tiles from left to before right, from up to before down, whose parts are open
        left = right = up = down = ZERO
        for base in range(v + 1, end, PIECES):
            count = min(end - base, PIECES)
            take(points, widths, base - 1, count + 1, pieces)
            touch(pieces, count, above, wide, tall)
            for i in range(1, count + 1):
                way = pieces[WAY + i]
                if way == NO_WAY:
                    continue
                if way != run:
                    start = pieces[BEGIN + i]
                    run = way
                new_left, new_right = pieces[LEFT + i], pieces[RIGHT + i]
                new_up, new_down = pieces[UP + i], pieces[DOWN + i]
                if (new_left != left) | (new_right != right) | (new_up != up) | (new_down != down):
                    close(
                        left, right, up, down, new_left, new_right, new_up, new_down, s << SHIFT | v, across, opened,
                        pool, links, heads, fills, used, begin, last, task,
                    )  # fmt: skip
                    here = np.int64(np.float32(start).view(np.uint32)) << SHIFT | (base + i - 1)
                    begin_in(new_left, new_right, new_up, new_down, left, right, up, down, here, across, opened)
                    left, right, up, down = new_left, new_right, new_up, new_down
                v = base + i - 1
        close(
            left, right, up, down, ZERO, ZERO, ZERO, ZERO, s << SHIFT | v, across, opened,
            pool, links, heads, fills, used, begin, last, task,
        )  # fmt: skip


@device
def touch(pieces, count, above, wide, tall):
    """How the pieces between count + 1 vertices go, where they begin, and which tiles they can touch of a picture so
    wide and tall whose first row is `above`: from `LEFT` to before `RIGHT`, from `UP` to before `DOWN`."""
    rows = half_width_pointer(pieces)
    for k in range(0, count, vector(rows)):
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
def close(
    left, right, up, down, new_left, new_right, new_up, new_down, end, across, opened,
    pool, links, heads, fills, used, begin, last, task,
):  # fmt: skip
    """Append the parts that are open in tiles from left to before right, from up to before down, but for those that go
    on; end: the strand above the vertex that they end in."""
    for y in range(np.int64(up), np.int64(down)):
        for x in range(np.int64(left), np.int64(right)):
            if (x >= new_left) & (x < new_right) & (y >= new_up) & (y < new_down):
                continue
            tile = y * across + x
            slot = fills[task, tile]
            if slot & IN_BLOCK == 0:
                slot = link(slot, tile, links, heads, used, begin, last, task)
            fills[task, tile] = slot + 1
            pool[slot, 0] = opened[tile]
            pool[slot, 1] = end


@inlined
def begin_in(left, right, up, down, old_left, old_right, old_up, old_down, here, across, opened):
    """Open parts in tiles where none is open; here: where their run began, above the vertex."""
    for y in range(np.int64(up), np.int64(down)):
        for x in range(np.int64(left), np.int64(right)):
            if not ((x >= old_left) & (x < old_right) & (y >= old_up) & (y < old_down)):
                opened[y * across + x] = here


@device
def link(slot, tile, links, heads, used, begin, last, task):
    """The first slot of another block for a worker's chain in a tile, where the last one is full."""
    block = min(begin + used[task], last)
    used[task] += 1
    if slot == 0:
        heads[task, tile] = block
    else:
        links[(slot - 1) >> BLOCK_BITS] = block
    return block << BLOCK_BITS
