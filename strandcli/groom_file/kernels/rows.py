"""Points of strands in rows: packed in blocks; which of them are drawn, and how far along the strand each is. And
strands moved as a whole: by a shift that fades from the root on, or out of a solid, smoothly along each.

Strands s have the points first[s] to first[s + 1] of flat arrays (P, 3), root first.
"""

from __future__ import annotations

import math

import numpy as np

from ...constants import W
from ...exchange.kernels.along import distance, length
from ...jit import device, parallel, prange
from ...meshes.kernels.distance import distance as grid_distance


@parallel
def place(first, points, most, per, out):
    """Write to out (P,) the rows that points of strands get where all have ``most``, over ``per``; of a strand that has
    more of them, the shares of its length before them. First (S + 1,) int64 of points (P, 3)."""
    for s in prange(first.shape[0] - 1):
        place_strand(points, first[s], first[s + 1], most, per, out)


@device
def place_strand(points, begin, end, most, per, out):
    """`place` of the strand of the points from ``begin`` to ``end``; one without length has its points by number."""
    last = end - begin - 1
    whole = length(points, begin, end - 1)
    along = 0.0
    for i in range(last + 1):
        if i > 0:
            along += distance(points, begin + i - 1, begin + i)
        share = along / whole if 0.0 < whole < np.inf else i / last
        out[begin + i] = share if last >= most else (i + np.rint(share * (most - last - 1))) / per


@parallel
def pack(first, points, rows, order, out):
    """Write strands in an ``order`` (S,) to blocks out (blocks, n + 1, 3 W), as `groom.blocks` has them; first
    (S + 1,) of points (P, 3), of which each strand has n, or which get the rows (P,)."""
    for block in prange(out.shape[0]):
        b = np.int64(block)
        for lane in range(W):
            s = order[min(b * W + lane, order.shape[0] - 1)]
            for c in range(3):
                lay(points, rows, first[s], first[s + 1], c, out[b, 1:, c * W + lane])
        for k in range(3 * W):
            out[b, 0, k] = np.float32(2.0) * out[b, 1, k] - out[b, 2, k]


@parallel
def spread(first, values, rows, order, out):
    """Write values (P, 1) of the points of strands in an ``order`` (S,), which get the rows (P,), to out (S, n)."""
    for s in prange(out.shape[0]):
        lay(values, rows, first[order[s]], first[order[s] + 1], 0, out[s])


@device
def lay(values, rows, begin, end, c, out):
    """Write column c of the values from ``begin`` to ``end`` to out (n,): in their rows, and linear ones between."""
    if rows is None:
        for i in range(begin, end):
            out[i - begin] = values[i, c]
        return
    for i in range(begin, end - 1):
        low, high = np.int64(rows[i]), np.int64(rows[i + 1])
        a, b = np.float64(values[i, c]), np.float64(values[i + 1, c])
        out[low] = values[i, c]
        for k in range(low + 1, high):
            out[k] = a + (k - low) / (high - low) * (b - a)
    out[np.int64(rows[end - 1])] = values[end - 1, c]


@parallel
def choose(keep, counts, rows):
    """Rows (S, m) int32 of the points to draw of strands (S, n): those that ``keep`` (S, n) marks, so many each
    (S,), and of the others as many as are wanting, evenly chosen."""
    for s in prange(rows.shape[0]):
        fill(keep[s], counts[s], rows[s])


@device
def fill(keep, count, rows):
    """`choose` of one strand."""
    rest = keep.shape[0] - count
    wanting = rows.shape[0] - count
    k = 0
    seen = 0
    for i in range(keep.shape[0]):
        taken = keep[i]
        if not taken:
            taken = (seen + 1) * wanting // rest > seen * wanting // rest
            seen += 1
        if taken:
            rows[k] = i
            k += 1


@parallel
def write(points, rows, out):
    """out (S, m, 4) float32: the points ``rows`` (S, m) of strands (S, n, 3), and how far along the strand each is, as
    a share of its length."""
    for s in prange(out.shape[0]):
        travel(points[s], rows[s], out[s])


@device
def travel(points, rows, out):
    """`write` of one strand; of one without length by number."""
    last = points.shape[0] - 1
    whole = length(points, 0, last)
    along = 0.0
    i = 0
    for k in range(rows.shape[0]):
        while i < rows[k]:
            along += distance(points, i, i + 1)
            i += 1
        for c in range(3):
            out[k, c] = points[i, c]
        out[k, 3] = np.float32(min(along / whole if whole > 0.0 else i / last, 1.0))


TINY = 1e-300
TOWARD = 0.3
"""Share of its lateral distance from where it belongs that a strand makes good for on a segment."""
STEEP = 0.5
"""Tangent of the angle by which a segment is turned for that, at most."""
PASSES = 3
"""Of smoothing the shifts along a strand."""


@parallel
def seat(first, points, shifts, fades, lengths):
    """Move the root of each strand by its shift (S, 3), and the points after it by less and less, up to none at
    ``fades`` (S,) metres from it; segments keep their lengths (P,), of which that of a point is the one before it."""
    for s in prange(first.shape[0] - 1):
        along = 0.0
        px = py = pz = 0.0  # the point before, as it was and moved
        for i in range(first[s], first[s + 1]):
            along += lengths[i]
            t = min(along / max(fades[s], TINY), 1.0)
            left = 1.0 - t * t * (3.0 - 2.0 * t)
            x = points[i, 0] + left * shifts[s, 0]
            y = points[i, 1] + left * shifts[s, 1]
            z = points[i, 2] + left * shifts[s, 2]
            if i == first[s]:
                points[i, 0], points[i, 1], points[i, 2] = x, y, z
            else:
                follow(points, i, lengths[i], px, py, pz, x, y, z)
            px, py, pz = x, y, z


@parallel
def lead_out(first, points, needs, outward, reach, lengths, shifts):
    """Move points along ``outward`` (P, 3) by what they need (P,), metres, 0 for those that are far enough out, and
    their neighbours on the strand, too, by less the farther they are, over about ``reach`` (S,) metres; roots stay.
    Segments keep their lengths (P,). shifts (P, 3): scratch."""
    for s in prange(first.shape[0] - 1):
        strand(first[s], first[s + 1], points, needs, outward, reach[s], lengths, shifts)


@device
def strand(begin, end, points, needs, outward, reach, lengths, shifts):
    """`lead_out` of one strand."""
    deep = end
    for i in range(end - 1, begin, -1):
        need = max(needs[i], 0.0)
        if need > 0.0:
            deep = i
        for c in range(3):
            shifts[i, c] = need * outward[i, c]
    if deep == end:
        return
    for c in range(3):
        shifts[begin, c] = 0.0
    for i in range(begin + 2, end):
        spread_shift(shifts, i - 1, i, lengths[i], reach)
    for i in range(end - 2, begin, -1):
        spread_shift(shifts, i + 1, i, lengths[i + 1], reach)
    whole = 0.0  # from the root, which stays, up to the first point that has to move
    for i in range(begin + 1, deep + 1):
        whole += lengths[i]
    along = 0.0
    for i in range(begin + 1, deep):
        along += lengths[i]
        for c in range(3):
            shifts[i, c] *= along / max(whole, TINY)
    for _ in range(PASSES):
        smooth(shifts, begin, end)
    px, py, pz = points[begin, 0], points[begin, 1], points[begin, 2]
    for i in range(begin + 1, end):
        x = points[i, 0] + shifts[i, 0]
        y = points[i, 1] + shifts[i, 1]
        z = points[i, 2] + shifts[i, 2]
        follow(points, i, lengths[i], px, py, pz, x, y, z)
        px, py, pz = x, y, z


@device
def spread_shift(shifts, source, i, length, reach):
    """Let a point's shift be that of its neighbour, which fades over ``reach``, where that is greater."""
    less = 1.0 / (1.0 + length / max(reach, TINY))
    own = other = 0.0
    for c in range(3):
        own += shifts[i, c] * shifts[i, c]
        other += shifts[source, c] * shifts[source, c]
    if other * less * less > own:
        for c in range(3):
            shifts[i, c] = less * shifts[source, c]


@device
def smooth(shifts, begin, end):
    """Mix the shift of each point of a strand but the root's with those of its neighbours."""
    for c in range(3):
        before = shifts[begin, c]
        for i in range(begin + 1, end):
            own = shifts[i, c]
            after = shifts[i + 1, c] if i + 1 < end else own
            shifts[i, c] = 0.25 * before + 0.5 * own + 0.25 * after
            before = own


@device
def follow(points, i, length, px, py, pz, x, y, z):
    """Put point i at a length from the one before it, in the direction from (px, py, pz) to (x, y, z), where both
    belong, turned toward that line as far as the point before is off it."""
    bx, by, bz = points[i - 1, 0], points[i - 1, 1], points[i - 1, 2]
    tx, ty, tz = x - px, y - py, z - pz
    size = math.sqrt(tx * tx + ty * ty + tz * tz)
    if length <= 0.0 or size <= 0.0:
        points[i, 0], points[i, 1], points[i, 2] = bx, by, bz
        return
    tx, ty, tz = tx / size, ty / size, tz / size
    ex, ey, ez = px - bx, py - by, pz - bz
    lengthwise = ex * tx + ey * ty + ez * tz
    ex, ey, ez = ex - lengthwise * tx, ey - lengthwise * ty, ez - lengthwise * tz
    off = math.sqrt(ex * ex + ey * ey + ez * ez)
    turn = min(TOWARD, STEEP * length / max(off, TINY)) / length
    tx, ty, tz = tx + turn * ex, ty + turn * ey, tz + turn * ez
    size = length / math.sqrt(tx * tx + ty * ty + tz * tz)
    points[i, 0] = bx + size * tx
    points[i, 1] = by + size * ty
    points[i, 2] = bz + size * tz


@parallel
def grid_distances(grid, points, out):
    """Write the signed distances of points (n, 3) to out (n,); outside of the grid a lower bound."""
    for i in prange(points.shape[0]):
        out[i] = grid_distance(grid, points[i, 0], points[i, 1], points[i, 2])
