"""From strands to fragments: their pieces sorted into runs, and into cells of which many are covered at once."""

from __future__ import annotations

import math

import numpy as np

from ...jit import inlined, inner, parallel, prange
from . import tiles
from .coverage import (
    AREA,
    CELL,
    CELLS,
    DEPTH,
    FLAT_WAY,
    INTEGERS,
    MIDDLE,
    PLACE,
    RISE,
    ROWS,
    THIN,
    VERTEX,
    ZERO,
    H,
    fragments,
    whole,
)
from .ribbon import ribbon
from .tiles import READY, TILE_WIDTH, append

HALF = np.float32(0.5)
ONE = np.float32(1.0)
TWO = np.float32(2.0)
WIDE = np.float32(0.7)
"""Pixels. Narrower than that, a cell of a piece touches three rows at the most."""
POINT = np.float32(1e-6)
"""Pixels. What is shorter is a point, and draws nothing."""


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
def gather(
    first, screen, widths, opacity, stride, bits, rows, top, bottom, width, hides, edges, depth, cover, workers,
    pool, links, heads, fills, used,
):  # fmt: skip
    """Append the fragments of the rows top <= y < bottom to the chains of their tiles, which begin at row `top`.

    first (S + 1,) int64; screen (V, 3) float32 as from `project.points`; widths (V,) float32 pixels, or None for lines
    one pixel wide; opacity: of the material; every `stride`-th vertex is lit, 2^(PLACES − bits); rows (S, 2): as from
    `spans`; hides: as in `coverage.fragments`; edges (E,) int64, depth, cover (E,) float32: pixels that a solid covers
    in part, its depth number and share, which become fragments too, number V + e; pool, links, heads, fills, used: as
    in `tiles.append`, fills and used zero before. The `workers` share strands and blocks evenly; one that used more
    than its share but one had no room for all, and then no chain holds.
    """
    share = links.shape[0] // workers
    strands_ = first.shape[0] - 1
    for one in prange(workers):
        task = np.int64(one)  # the index is unsigned, and would make floats of what it is added to
        strands(
            task * strands_ // workers, (task + 1) * strands_ // workers, first, screen, widths, opacity,
            stride, bits, rows, top, bottom, width, hides,
            pool, links, heads, fills, used, task * share, (task + 1) * share - 1, task,
        )  # fmt: skip
        count = edges.shape[0]
        solids(
            task * count // workers, (task + 1) * count // workers, edges, depth, cover, screen.shape[0],
            top, bottom, width, pool, links, heads, fills, used, task * share, (task + 1) * share - 1, task,
        )  # fmt: skip


@inner
def strands(
    low, high, first, screen, widths, opacity, stride, bits, rows, top, bottom, width, hides,
    pool, links, heads, fills, used, begin, last, task,
):  # fmt: skip
    """What `gather` does for one worker, with the strands from `low` to before `high`."""
    work = np.empty(ROWS * CELLS, np.float32)
    cells = np.empty(INTEGERS * CELLS, np.int32)
    ready = np.empty(2 * READY, np.float32)
    places = np.empty(4 * READY, np.int32)
    across = np.int64((width + TILE_WIDTH - 1) // TILE_WIDTH)
    n = np.int64(0)
    for s in range(low, high):
        if not (rows[s, 0] < np.float32(bottom) and rows[s, 1] >= np.float32(top)):
            continue
        a = first[s]
        end = first[s + 1]
        run = np.int64(0)  # a literal would have `thin` compiled twice
        start = ZERO
        v = a
        for after in range(a + 1, end + 1):
            # what the piece before `after` is: whether the run of the piece before `v` goes on with it
            way = 0
            x0 = ZERO
            y0 = ZERO
            if after < end:
                x0 = screen[after - 1, 0]
                y0 = screen[after - 1, 1]
                dx = screen[after, 0] - x0
                dy = screen[after, 1] - y0
                flat = abs(dx) >= abs(dy)
                du = dx if flat else dy
                if screen[after - 1, 2] > ZERO and screen[after, 2] > ZERO:
                    if abs(du) < POINT:
                        continue
                    if widths is None or max(widths[after - 1], widths[after]) > WIDE:
                        ribbon(
                            screen, widths, opacity, after, a, end, (after - 1 - a) & (stride - 1), bits,
                            top, bottom, width, across, hides,
                            pool, links, heads, fills, used, begin, last, task, ready, places,
                        )  # fmt: skip
                    else:
                        way = 1 if flat else 2
                        way = way if du > ZERO else -way
            if widths is None:
                continue
            if run != 0:
                n = thin(
                    screen, widths, opacity, v, (v - 1 - a) & (stride - 1), bits, run, start, way != run,
                    top, bottom, width, across, hides,
                    pool, links, heads, fills, used, begin, last, task, work, cells, n,
                )  # fmt: skip
            if way != run:
                start = x0 if abs(way) == 1 else y0
                start = start if way > 0 else -start
                run = way
            v = after
    fragments(work, cells, n, top, bottom, width, across, hides, pool, links, heads, fills, used, begin, last, task)


@inner
def solids(
    low, high, edges, depth, cover, base, top, bottom, width, pool, links, heads, fills, used, begin, last, task
):
    """Append what solids cover of the pixels number `low` to before `high` of those that they cover in part."""
    ready = np.empty(2 * READY, np.float32)
    places = np.empty(4 * READY, np.int32)
    across = np.int64((width + TILE_WIDTH - 1) // TILE_WIDTH)
    n = np.int64(0)
    for e in range(low, high):
        y = edges[e] // width
        if top <= y < bottom and cover[e] > ZERO:
            places[tiles.X + n] = edges[e] % width
            places[tiles.Y + n] = y
            places[tiles.VERTEX + n] = base + e
            places[tiles.PLACE + n] = 0
            ready[tiles.DEPTH + n] = depth[e]
            ready[tiles.ALPHA + n] = cover[e]
            n += 1
            if n == READY:
                append(ready, places, n, top, across, pool, links, heads, fills, used, begin, last, task)
                n = np.int64(0)
    append(ready, places, n, top, across, pool, links, heads, fills, used, begin, last, task)


@inlined
def thin(
    screen, widths, opacity, v, lit_past, bits, run, start, closing, top, bottom, width, across, hides,
    pool, links, heads, fills, used, begin, last, task, work, cells, n,
):  # fmt: skip
    """List the cells that the piece from vertex v − 1 to v leaves behind, and, `closing`, the one that its run ends in;
    covers those listed so far where there are too many.

    run: 1 along x, 2 along y, negative against the axis; start: where the run begins, in the direction of travel; n:
    cells listed before. Returns how many there are then.
    """
    y0 = screen[v - 1, 1]
    y1 = screen[v, 1]
    seen = (max(y0, y1) + TWO >= np.float32(top)) & (min(y0, y1) - TWO < np.float32(bottom))
    flat = abs(run) == 1
    sign = ONE if run > 0 else -ONE
    u0 = sign * (screen[v - 1, 0] if flat else y0)
    u1 = sign * (screen[v, 0] if flat else y1)
    v0 = y0 if flat else screen[v - 1, 0]
    v1 = y1 if flat else screen[v, 0]
    low = 0 if flat else top
    high = width if flat else bottom
    cell = max(whole(u0), low if run > 0 else -high)
    stop = min(whole(u1) + np.int64(closing), high if run > 0 else -low) if seen else cell
    per = ONE / (u1 - u0)
    slope = (v1 - v0) * per
    q0 = screen[v - 1, 2]
    rise = screen[v, 2] - q0
    w0 = widths[v - 1]
    wider = widths[v] - w0
    stretch = math.sqrt(ONE + slope * slope)
    h = max(HALF * stretch * max(w0, widths[v]), THIN)
    stretch *= opacity
    most = np.int32(np.int64(1) << bits) - np.int32(1)
    fine = np.float32(most) + ONE
    lit = np.int32(lit_past << bits)
    way = np.int32(-1 if flat else 0)
    turned = np.int32(0 if run > 0 else -1)
    rises = abs(slope)
    while cell < stop:
        if n == CELLS:
            fragments(
                work, cells, n, top, bottom, width, across, hides, pool, links, heads, fills, used, begin, last, task
            )
            n = np.int64(0)
        here = min(stop, cell + CELLS - n)
        for c in range(cell, here):
            k = np.uint64(n)
            enter = max(np.float32(c), start)
            length = min(np.float32(c + 1), u1) - enter
            past = enter + HALF * length - u0
            t = min(max(past * per, ZERO), ONE)
            work[np.uint64(DEPTH) + k] = q0 + rise * t
            work[np.uint64(MIDDLE) + k] = v0 + slope * past
            work[np.uint64(AREA) + k] = stretch * length * (w0 + t * wider)
            work[np.uint64(RISE) + k] = rises * length
            work[np.uint64(H) + k] = h
            cells[np.uint64(PLACE) + k] = lit + min(np.int32(t * fine), most)
            cells[np.uint64(CELL) + k] = c ^ turned
            cells[np.uint64(VERTEX) + k] = v - 1
            cells[np.uint64(FLAT_WAY) + k] = way
            n += 1
        cell = here
    return n
