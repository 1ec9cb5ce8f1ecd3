"""Which parts of strands lie in which tile: chains of blocks out of one pool.

Each worker has its share of the pool and a chain of its own in every tile, so nobody waits for anybody. A part is a row
of pieces of one strand, as two 64-bit numbers: where the run of its first piece began (see `coverage`), above the
vertex that this piece ends in; and the strand, above the vertex that its last piece ends in.
"""

from __future__ import annotations

import math

import numpy as np

from ...jit import inlined, inner, parallel, prange
from ...simd import lay
from .tiles import TILE_HEIGHT, TILE_WIDTH

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
OUTSIDE = np.float32(-max(TILE_WIDTH, TILE_HEIGHT))
BLOCK = 16
"""Parts a block."""
IN_BLOCK = np.int64(BLOCK - 1)
BLOCK_BITS = np.int64(4)
SHIFT = np.int64(32)
LOW = np.int64(0xFFFFFFFF)
WIDE = np.float32(0.7)
"""Pixels. Narrower than that, a cell of a piece touches three rows at the most."""
POINT = np.float32(1e-6)
"""Pixels. What is shorter is a point, and draws nothing."""
REACH = np.float32(1.1)
"""Pixels that a piece reaches beyond its ends, but for its width: what it rises within a cell."""
MITRE = np.float32(0.7072)
"""Of its width, that a piece reaches beyond its ends: half, at the slant of a mitre."""


RIBBON, BEHIND, NO_WAY = np.int64(0), np.int64(8), np.int64(9)
"""Ways of pieces that follow no axis: wide, behind the eye, or points."""


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


@inner
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
        )  # fmt: skip


@inner
def worker(
    low, high, first, screen, widths, rows, top, bottom, width, pool, links, heads, fills, used, begin, last, task,
    opened,
):  # fmt: skip
    """What `share_out` does for one worker, with the strands from `low` to before `high`, in the blocks from `begin` to
    `last`, of which the last is only a place for what finds no room; opened (tiles,) int64: to work with.

    A part goes on as long as its pieces' boxes touch the tile.
    """
    across = np.int64((width + TILE_WIDTH - 1) // TILE_WIDTH)
    points = lay(screen)
    wide = np.float32(width)
    tall = np.float32(bottom - top)
    above = np.float32(top)
    per_x = np.float32(1 / TILE_WIDTH)
    per_y = np.float32(1 / TILE_HEIGHT)
    for s in range(low, high):
        if not (rows[s, 0] < np.float32(bottom) and rows[s, 1] >= above):
            continue
        a = first[s]
        end = first[s + 1]
        run = np.int64(0)
        start = ZERO
        v = a
        # tiles from left to before right, from up to before down, whose parts are open
        left = np.int64(0)
        right = np.int64(0)
        up = np.int64(0)
        down = np.int64(0)
        for after in range(a + 1, end + 1):
            new_left = np.int64(0)
            new_right = np.int64(0)
            new_up = np.int64(0)
            new_down = np.int64(0)
            if after < end:
                x0, y0, q0 = points[3 * after - 3], points[3 * after - 2], points[3 * after - 1]
                x1, y1, q1 = points[3 * after], points[3 * after + 1], points[3 * after + 2]
                w = ONE if widths is None else max(widths[after - 1], widths[after])
                way, begun = way_of(x0, y0, q0, x1, y1, q1, w > WIDE)
                if way == NO_WAY:
                    continue
                if way != run:
                    start = begun
                    run = way
                if way != BEHIND:
                    y0 -= above
                    y1 -= above
                    # a thin piece's cells are those of its ends, whatever it reaches across
                    reach = REACH + MITRE * w
                    reach_x = ZERO if abs(way) == 1 else reach
                    reach_y = ZERO if abs(way) == 2 else reach
                    new_left = np.int64(within(min(x0, x1) - reach_x, ZERO, wide) * per_x)
                    new_up = np.int64(within(min(y0, y1) - reach_y, ZERO, tall) * per_y)
                    new_right = np.int64(within(max(x0, x1) + reach_x, OUTSIDE, wide - HALF) * per_x + ONE)
                    new_down = np.int64(within(max(y0, y1) + reach_y, OUTSIDE, tall - HALF) * per_y + ONE)
            if (new_left != left) | (new_right != right) | (new_up != up) | (new_down != down):
                for ty in range(up, down):
                    for tx in range(left, right):
                        if (tx >= new_left) & (tx < new_right) & (ty >= new_up) & (ty < new_down):
                            continue
                        tile = ty * across + tx
                        slot = fills[task, tile]
                        if slot & IN_BLOCK == 0:
                            slot = link(slot, tile, links, heads, used, begin, last, task)
                        fills[task, tile] = slot + 1
                        pool[slot, 0] = opened[tile]
                        pool[slot, 1] = s << SHIFT | v
                for ty in range(new_up, new_down):
                    for tx in range(new_left, new_right):
                        if (tx >= left) & (tx < right) & (ty >= up) & (ty < down):
                            continue
                        bits = np.int64(np.float32(start).view(np.uint32))
                        opened[ty * across + tx] = bits << SHIFT | after
                left = new_left
                right = new_right
                up = new_up
                down = new_down
            v = after


@inlined
def within(x, low, high):
    """x between bounds; the lower one for what is not a number."""
    x = x if x > low else low
    return x if x < high else high


@inlined
def way_of(x0, y0, q0, x1, y1, q1, wide):
    """How a piece goes from (x0, y0) to (x1, y1), of depth numbers q0 and q1, and where it begins: 1 along x, 2 along
    y, negative against the axis, with its first coordinate in this direction; or `RIBBON` if `wide`, `BEHIND`,
    `NO_WAY`."""
    dx = x1 - x0
    dy = y1 - y0
    flat = abs(dx) >= abs(dy)
    du = dx if flat else dy
    at = x0 if flat else y0
    way = np.int64(1 if flat else 2)
    way = way if du > ZERO else -way
    at = at if du > ZERO else -at
    way = RIBBON if wide else way
    way = NO_WAY if abs(du) < POINT else way
    return way if (q0 > ZERO) & (q1 > ZERO) else BEHIND, at


@inner
def link(slot, tile, links, heads, used, begin, last, task):
    """The first slot of another block for a worker's chain in a tile, where the last one is full."""
    block = min(begin + used[task], last)
    used[task] += 1
    if slot == 0:
        heads[task, tile] = block
    else:
        links[(slot - 1) >> BLOCK_BITS] = block
    return block << BLOCK_BITS
