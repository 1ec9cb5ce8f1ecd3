"""Deep opacity maps (Yuksel & Keyser 2008): how many strands a ray of light meets, texel by texel and layer by layer.

Layers divide the depths from the nearest strand about a texel to the farthest, so that of n, x metres behind the
nearest, n (x / (x + h)) (1 + h / D) have ended, where D is how far the farthest is. Where light falls off, within a few
times the length h, they are nearly even, and only what is dark anyhow shares the others. (In `hair`, whole, 13 that
grow as the square of their number leave a mean error of .041, 13 of these .036, 25 of them .031.) In each is gathered
projected length × width / texel area of the strands' pieces, between the four texels that each lies between: the mean
number of strands that a ray meets there, its optical depth τ. What is left of the light is e^-τ, the strands' places
being taken as independent.

Four texels, a cell, have their layers at the same depths, so that their mean is one texel twice as wide. Where strands
lie far apart, by what the layers about a point hold, that is read instead, and a mixture in between: an estimate of
density with a window as wide as it takes. A strand's own share of what lies in front of it, half of what it leaves in
the window's middle, is taken off.

A cell is a row of numbers in one flat array: nearest depth, n (1 + h / D), and then, for the ends of the layers from
the nearest depth on, the τ in front of them: five numbers, of the four texels and their mean. Within a layer τ is
linear.
"""

from __future__ import annotations

import math

import numpy as np

from ...jit import function, inlined, inner, parallel, prange
from .approximations import exp
from .project import wider
from .shadow import between, held, texel_of

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
TINY = np.float32(1e-12)
HEAD = 2
"""Numbers of a cell before its layers."""
TEXELS = 4
"""Of a cell."""
FIVE = 5
"""Numbers of the end of a layer: each texel's, and their mean."""
OWN = np.float32(0.375)
"""Half of what a strand as wide as a texel leaves in the middle of a quadratic spline about it."""
THIRD = np.float32(1 / 3)
SHORT = np.float32(1.5)
"""Texels. A spot is two texels wide."""
CLOSE = np.float32(0.8)
"""Texels that strands are apart, by the layers, up to which texels are read, and beyond twice as many cells' means."""


def stride_for(layers: int) -> int:
    """Numbers of a cell."""
    return HEAD + FIVE * (layers + 1)


@parallel
def draw(
    first, screen, members, begin, size, rows, workers, far, near, focal, width, taper, scale, extents, over, layers,
    stacks,
):  # fmt: skip
    """Draw strands into one map: into its extents where `stacks` is None, else into the layers between them.

    first, screen, members, begin, rows, workers, far, near, size: as in `shadow.fill`, rows and size even; focal:
    texels a metre, where far is 0 at a depth of one; width: of strands at the root, metres, of which `taper` is lost to
    the tip; scale (S,): factor of each strand's, or None; extents (cells, 2) float32 nearest and farthest depth, or
    what `divide` makes of them; over: 1 / h; stacks (cells * `stride_for`,) float32.
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


@inner
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
        if max(y0, y1) < np.float32(top) or min(y0, y1) >= np.float32(bottom) or q0 <= ZERO or q1 <= ZERO:
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


@inner
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
            far = max((d - heads[cell, 0]) * over, ZERO)
            k = min(np.int64(heads[cell, 1] * (far / (far + ONE))), layers - 1)
            at = np.int64(cell) * (HEAD + FIVE * (layers + 1)) + HEAD + FIVE * (k + 1) + 2 * (row & 1) + (column & 1)
            stacks[np.uint64(at)] += part * (u if right else ONE - u)


@parallel
def divide(extents, layers, least, over, stacks):
    """Empty layers between the extents (cells, 2) of each cell, which are taken to be `least` metres apart or more;
    over: 1 / h. Extents become what cells begin with."""
    stride = HEAD + FIVE * (layers + 1)
    for t in prange(extents.shape[0]):
        near = extents[t, 0]
        there = near <= extents[t, 1]
        thick = max(extents[t, 1] - near, least)
        base = t * stride
        extents[t, 0] = near if there else ZERO
        extents[t, 1] = np.float32(layers) * (ONE + ONE / (thick * over)) if there else ZERO
        stacks[base] = extents[t, 0]
        stacks[base + 1] = extents[t, 1]
        for k in range(HEAD, stride):
            stacks[base + k] = ZERO


@parallel
def add_up(cells, layers, stacks):
    """From what is in each layer to what is in front of its end; and the mean of four texels."""
    stride = HEAD + FIVE * (layers + 1)
    for cell in prange(cells):
        base = cell * stride + HEAD
        if stacks[base - 1] == ZERO:
            continue
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


@inlined
def cell_of(row, column, start, size, layers):
    """Where the cell of a texel begins, in the map that begins at `start` (uint64)."""
    cell = np.uint64((row >> 1) * (size >> 1) + (column >> 1))
    return start + cell * np.uint64(HEAD + FIVE * (layers + 1))


@inlined
def layer_at(d, base, over, layers, stacks):
    """Where the cell that begins at `base` (uint64) keeps what begins the layer of depth d, how much of τ in the layer
    is in front, the layer's number, and how many layers there are a metre."""
    far = max((d - stacks[base]) * over, ZERO)
    near = ONE / (far + ONE)
    ended = min(stacks[base + np.uint64(1)] * (far * near), np.float32(layers))
    k = min(np.int64(ended), layers - 1)
    return base + np.uint64(HEAD + FIVE * k), ended - np.float32(k), k, stacks[base + np.uint64(1)] * over * near * near


@inlined
def within(at, part, which, stacks):
    """Of one of a cell's five, τ in front of a depth, of which `layer_at` tells where it is."""
    low = stacks[at + np.uint64(which)]
    return low + part * (stacks[at + np.uint64(which + FIVE)] - low)


@inlined
def growth_at(base, k, dense, layers, stacks):
    """By how much the mean τ of a cell grows a metre, about the layer k, where there are so many layers a metre."""
    span = min(layers, 3)
    before = min(max(k - 1, 0), layers - span)
    mean = base + np.uint64(HEAD + TEXELS + FIVE * before)
    return (stacks[mean + np.uint64(FIVE * span)] - stacks[mean]) * dense * (THIRD if span == 3 else ONE / span)


@inner
def depth_at(d, row, column, start, size, over, layers, stacks):
    """τ in front of depth d in a texel of the map that begins at `start` (uint64)."""
    at, part, _, _ = layer_at(d, cell_of(row, column, start, size, layers), over, layers, stacks)
    return within(at, part, 2 * (row & 1) + (column & 1), stacks)


@inlined
def one_of(lower, right, a, b, c, d):
    """Of a square's four."""
    return (d if right else c) if lower else (b if right else a)


@inner
def in_front(u, v, d, start, size, over, layers, stacks):
    """τ in front of a place of a map, column and row, whole at the texels' middles, and depth: by the texels about it,
    by the cells about it, of which these texels are some, and what the latter grows by a metre."""
    half = size >> 1
    wide_u = HALF * (u - HALF)
    wide_v = HALF * (v - HALF)
    left = min(max(np.int64(np.floor(wide_u)), 0), half - 2)
    up = min(max(np.int64(np.floor(wide_v)), 0), half - 2)
    wide_u = min(max(wide_u - np.float32(left), ZERO), ONE)
    wide_v = min(max(wide_v - np.float32(up), ZERO), ONE)
    a = cell_of(2 * up, 2 * left, start, size, layers)
    b = a + np.uint64(HEAD + FIVE * (layers + 1))
    c = cell_of(2 * up + 2, 2 * left, start, size, layers)
    e = c + np.uint64(HEAD + FIVE * (layers + 1))
    at_a, part_a, k_a, dense_a = layer_at(d, a, over, layers, stacks)
    at_b, part_b, k_b, dense_b = layer_at(d, b, over, layers, stacks)
    at_c, part_c, k_c, dense_c = layer_at(d, c, over, layers, stacks)
    at_e, part_e, k_e, dense_e = layer_at(d, e, over, layers, stacks)
    cells = between(
        wide_u, wide_v,
        within(at_a, part_a, TEXELS, stacks), within(at_b, part_b, TEXELS, stacks),
        within(at_c, part_c, TEXELS, stacks), within(at_e, part_e, TEXELS, stacks),
    )  # fmt: skip
    growth = between(
        wide_u, wide_v,
        growth_at(a, k_a, dense_a, layers, stacks), growth_at(b, k_b, dense_b, layers, stacks),
        growth_at(c, k_c, dense_c, layers, stacks), growth_at(e, k_e, dense_e, layers, stacks),
    )  # fmt: skip
    low_u = np.floor(u)
    low_v = np.floor(v)
    column = np.int64(low_u)
    row = np.int64(low_v)
    first = column >> 1 > left
    last = (column + 1) >> 1 > left
    upper = row >> 1 > up
    lower = (row + 1) >> 1 > up
    here = 2 * (row & 1) + (column & 1)
    texels = between(
        u - low_u, v - low_v,
        within(one_of(upper, first, at_a, at_b, at_c, at_e), one_of(upper, first, part_a, part_b, part_c, part_e),
               here, stacks),
        within(one_of(upper, last, at_a, at_b, at_c, at_e), one_of(upper, last, part_a, part_b, part_c, part_e),
               here ^ 1, stacks),
        within(one_of(lower, first, at_a, at_b, at_c, at_e), one_of(lower, first, part_a, part_b, part_c, part_e),
               here ^ 2, stacks),
        within(one_of(lower, last, at_a, at_b, at_c, at_e), one_of(lower, last, part_a, part_b, part_c, part_e),
               here ^ 3, stacks),
    )  # fmt: skip
    return texels, cells, growth


@inner
def through(u, v, start, size, layers, stacks):
    """τ of all strands at a place of a map."""
    low_u = np.floor(u)
    low_v = np.floor(v)
    column = np.int64(low_u)
    row = np.int64(low_v)
    here = 2 * (row & 1) + (column & 1)
    end = np.uint64(HEAD + FIVE * layers)
    return between(
        u - low_u, v - low_v,
        stacks[cell_of(row, column, start, size, layers) + end + np.uint64(here)],
        stacks[cell_of(row, column + 1, start, size, layers) + end + np.uint64(here ^ 1)],
        stacks[cell_of(row + 1, column, start, size, layers) + end + np.uint64(here ^ 2)],
        stacks[cell_of(row + 1, column + 1, start, size, layers) + end + np.uint64(here ^ 3)],
    )  # fmt: skip


@inner
def settled(texels, cells, growth, width, scale):
    """Which of both, in which mixture, less the strand's own share; width of strands in metres, and texels a metre
    there."""
    apart = math.sqrt(width / max(growth, TINY)) * scale
    share = min(max(apart * (ONE / CLOSE) - ONE, ZERO), ONE)
    own = OWN * width * scale * (ONE - HALF * share)
    return max(texels + share * (cells - texels) - own, ZERO)


@function
def optical_depth(x, y, z, width, lights, i, stacks, starts, sizes, views):
    """τ between a light and a point; 0 where no map of the light holds the point.

    As `shadow.transmittance`; width: mean one of strands, metres, or 0 for a point that is on none; lights [10]:
    layers, [14]: 1 / h; starts: where a map begins in stacks.
    """
    layers = np.int64(lights[i, 10])
    for one in range(int(lights[i, 7]), int(lights[i, 7] + lights[i, 8])):
        u, v, d = texel_of(x, y, z, views, one)
        if not held(u, v, d, views, one, np.float32(sizes[one] - 1)):
            continue
        scale = views[one, 13] / d if views[one, 12] > ZERO else views[one, 13]
        d -= lights[i, 9]
        start, size = np.uint64(starts[one]), np.int64(sizes[one])
        texels, cells, growth = in_front(u, v, d, start, size, lights[i, 14], layers, stacks)
        return settled(texels, cells, growth, width, scale)
    return ZERO


@function
def transmittance(x, y, z, width, lights, i, stacks, starts, sizes, views):
    """Share of light that reaches a point: e^-τ."""
    return exp(-optical_depth(x, y, z, width, lights, i, stacks, starts, sizes, views))
