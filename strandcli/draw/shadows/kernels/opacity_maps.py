"""Making a deep opacity map (see `opacity`): extents of its cells, rows between them, and what strands add to these."""

from __future__ import annotations

import math

import numpy as np

from ....jit import device, function, parallel, prange
from ...view.kernels.project import wider
from .opacity import FIVE, HEAD, cell_of

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
SHORT = np.float32(1.5)
"""Texels. A spot is two texels wide."""


@parallel
def draw(
    first, screen, members, begin, size, rows, workers, far, near, focal, width, taper, scale, extents, over, layers,
    stacks,
):  # fmt: skip
    """Draw strands into one map: into its extents where `stacks` is None, else into the layers between them.

    first, screen, members, begin, rows, workers, far, near, size: as in `shadow.fill`, rows and size even; focal:
    texels a metre, where far is 0 at a depth of one; width: of strands at the root, metres, of which `taper` is lost to
    the tip; scale (S,): factor of each strand's, or None; extents (cells, 2) float32 nearest and farthest depth, or
    what `divide` makes of them; over: 1 / h; stacks (`numbers_of`,) float32.
    """
    for task in prange(workers):
        for b in range(task, begin.shape[0] - 1, workers):
            top = b * rows
            bottom = min(top + rows, size)
            for m in range(begin[b], begin[b + 1]):
                s = members[m]
                strand(
                    first[s], first[s + 1], screen, top, bottom, size, far, near, focal,
                    width if scale is None else width * scale[s], taper, extents, over, layers, stacks,
                )  # fmt: skip


@device
def strand(a, end, screen, top, bottom, size, far, near, focal, width, taper, extents, over, layers, stacks):
    """All pieces of the polyline a … end − 1 in the rows from `top` to before `bottom`."""
    thin = width * taper / np.float32(max(end - a - 1, 1))
    middle = HALF * np.float32(size)
    x1 = screen[a, 0]
    y1 = screen[a, 1]
    q1 = screen[a, 2]
    for v in range(a + 1, end):
        x0 = x1
        y0 = y1
        q0 = q1
        x1 = screen[v, 0]
        y1 = screen[v, 1]
        q1 = screen[v, 2]
        # what a piece drops reaches half a texel further than the piece itself, so pieces beside these rows count too
        if max(y0, y1) < np.float32(top) - ONE or min(y0, y1) > np.float32(bottom) + ONE:
            continue
        if q0 <= ZERO or q1 <= ZERO:
            continue
        d0 = near + (ONE - q0) * far if far > ZERO else ONE / q0
        d1 = near + (ONE - q1) * far if far > ZERO else ONE / q1
        scale = focal if far > ZERO else focal * HALF * (q0 + q1)
        w = (width - thin * (np.float32(v - a) - HALF)) * scale
        if far <= ZERO:  # as a lamp sees it
            w *= wider(x0 - middle, y0 - middle, x1 - x0, y1 - y0, focal)
        if stacks is None:
            widen(x0, y0, d0, x1, y1, d1, top, bottom, size, extents)
        else:
            piece(x0, y0, d0, x1, y1, d1, scale, w, top, bottom, size, extents, over, layers, stacks)


@function
def widen(x0, y0, d0, x1, y1, d1, top, bottom, size, extents):
    """Extents of all cells that `piece` may come to, in as many parts as keep the ones beside its way out."""
    dx = x1 - x0
    dy = y1 - y0
    length = max(abs(dx), abs(dy))
    if not length <= np.float32(4 * size):
        return
    parts = max(np.int64(length * HALF), 1)
    per = ONE / np.float32(parts)
    for part in range(parts):
        xa = x0 + dx * (np.float32(part) * per)
        ya = y0 + dy * (np.float32(part) * per)
        da = d0 + (d1 - d0) * (np.float32(part) * per)
        xb = x0 + dx * (np.float32(part + 1) * per)
        yb = y0 + dy * (np.float32(part + 1) * per)
        db = d0 + (d1 - d0) * (np.float32(part + 1) * per)
        first = max(np.int64(min(ya, yb) - HALF), top) >> 1
        last = min(np.int64(max(ya, yb) + HALF), bottom - 1) >> 1
        left = max(np.int64(min(xa, xb) - HALF), 0) >> 1
        right = min(np.int64(max(xa, xb) + HALF), size - 1) >> 1
        for row in range(first, last + 1):
            for column in range(left, right + 1):
                cell = np.uint64(row * (size >> 1) + column)
                extents[cell, 0] = min(extents[cell, 0], min(da, db))
                extents[cell, 1] = max(extents[cell, 1], max(da, db))


@function
def piece(x0, y0, d0, x1, y1, d1, scale, w, top, bottom, size, heads, over, layers, stacks):
    """A spot for each texel's length, in depth too, or one in the middle of what is no longer than `SHORT`; `w` is the
    width in texels, `scale` texels a metre."""
    dx = x1 - x0
    dy = y1 - y0
    length = max(max(abs(dx), abs(dy)), abs(d1 - d0) * scale)
    if not length <= np.float32(4 * size):  # a light so near that a piece is wider than its map
        return
    spots = np.int64(length) + 1 if length > SHORT else np.int64(1)
    per = ONE / np.float32(spots)
    share = w * math.sqrt(dx * dx + dy * dy) * per
    dx *= per
    dy *= per
    rise = (d1 - d0) * per
    for spot in range(spots):
        t = np.float32(spot) + HALF
        u = x0 + t * dx - HALF
        v = y0 + t * dy - HALF
        drop(u, v, d0 + t * rise, share, top, bottom, size, heads, over, layers, stacks)


@device
def drop(u, v, d, share, top, bottom, size, heads, over, layers, stacks):
    """Divide a share among the four texels that a place lies between, those of them that lie in these rows."""
    left = np.floor(u)
    up = np.floor(v)
    u -= left
    v -= up
    for lower in range(2):
        row = np.int64(up) + lower
        if row < top or row >= bottom:
            continue
        part = share * (v if lower else ONE - v)
        for right in range(2):
            column = np.int64(left) + right
            if column < 0 or column >= size:
                continue
            cell = np.uint64((row >> 1) * (size >> 1) + (column >> 1))
            if heads[cell, 1] == ZERO:
                continue
            far = max((d - heads[cell, 0]) * over, ZERO)
            k = min(np.int64(heads[cell, 1] * (far / (far + ONE))), layers - 1)
            at = HEAD + FIVE * (k + 1) + 2 * (row & 1) + (column & 1)
            base = cell_of(row, column, np.uint64(0), size, layers, stacks)
            stacks[base + np.uint64(at)] += part * (u if right else ONE - u)


@function
def number(extents, rows):
    """Number the cells, extents (cells, 2), that strands come to, from 1 on; rows (cells,) float32, which can tell as
    many apart as the largest map has. Returns how many there are."""
    count = np.int64(0)
    for cell in range(extents.shape[0]):
        there = extents[cell, 0] <= extents[cell, 1]
        count += np.int64(there)
        rows[cell] = np.float32(count) if there else ZERO
    return count


@parallel
def divide(extents, layers, least, over, rows, stacks):
    """Empty layers between the extents (cells, 2) of each cell, which are taken to be `least` metres apart or more;
    over: 1 / h; rows (cells,): of `number`. Extents become what rows begin with."""
    stride = HEAD + FIVE * (layers + 1)
    cells = extents.shape[0]
    for k in range(stride):
        stacks[cells + k] = ZERO
    for cell in prange(cells):
        stacks[cell] = rows[cell]
        near = extents[cell, 0]
        there = rows[cell] > ZERO
        thick = max(extents[cell, 1] - near, least)
        extents[cell, 0] = near if there else ZERO
        extents[cell, 1] = np.float32(layers) * (ONE + ONE / (thick * over)) if there else ZERO
        if there:
            base = cells + np.int64(rows[cell]) * stride
            stacks[base] = extents[cell, 0]
            stacks[base + 1] = extents[cell, 1]
            for k in range(HEAD, stride):
                stacks[base + k] = ZERO


@parallel
def add_up(cells, layers, stacks):
    """From what is in each layer to what is in front of its end; and the mean of four texels."""
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
