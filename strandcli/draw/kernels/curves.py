"""From particles to smooth polylines (thesis §3): each segment becomes a cubic Bézier curve, cut into pieces.

Tangents point from root to tip here, the opposite of the source's sign, so the control points of the segment
p_{i-1} p_i are p_{i-1} + t_{i-1} L / 3 and p_i − t_i L / 3. The first tangent is the strand's direction, the last is
zero.
"""

from __future__ import annotations

import math

import numpy as np

from ...constants import W
from ...jit import function, parallel, prange

ZERO = np.float32(0.0)
ONE = np.float32(1.0)
TWO = np.float32(2.0)
THREE = np.float32(3.0)
SIX = np.float32(6.0)
THIRD = np.float32(1 / 3)
TINY = np.float32(1e-30)
WANG = np.float32(0.75)
BIG = np.float32(1e9)


@function
def difference(block, lane, i, n, out):  # type: ignore[no-untyped-def]
    """Unit tangent at particle i, root to tip: the central difference p_{i+1} − p_{i−1}, which for equal segments is
    the direction that the source constructs and has no singular case. out (3,) float32."""
    if i == n - 1:
        out[0] = ZERO
        out[1] = ZERO
        out[2] = ZERO
        return
    low = i
    high = i + 2 if i > 0 else i + 1  # the root: from the row before it, the strand's direction
    x = block[high, lane] - block[low, lane]
    y = block[high, W + lane] - block[low, W + lane]
    z = block[high, 2 * W + lane] - block[low, 2 * W + lane]
    size = ONE / math.sqrt(max(x * x + y * y + z * z, TINY))
    out[0] = x * size
    out[1] = y * size
    out[2] = z * size


@function
def printed(block, lane, i, n, out):  # type: ignore[no-untyped-def]
    """The tangent as the source gives it: v = p_i − p_{i−1}, w = p_i − p_{i+1} (printed p_{i−2}), u = v × w,
    t = u × (v + w), here turned to point from root to tip; zero where |u| or |v + w| < 0.1, whatever the scene's
    scale."""
    if i == 0 or i == n - 1:
        difference(block, lane, i, n, out)
        return
    vx = block[i + 1, lane] - block[i, lane]
    vy = block[i + 1, W + lane] - block[i, W + lane]
    vz = block[i + 1, 2 * W + lane] - block[i, 2 * W + lane]
    wx = block[i + 1, lane] - block[i + 2, lane]
    wy = block[i + 1, W + lane] - block[i + 2, W + lane]
    wz = block[i + 1, 2 * W + lane] - block[i + 2, 2 * W + lane]
    ux = vy * wz - vz * wy
    uy = vz * wx - vx * wz
    uz = vx * wy - vy * wx
    sx = vx + wx
    sy = vy + wy
    sz = vz + wz
    tx = uz * sy - uy * sz
    ty = ux * sz - uz * sx
    tz = uy * sx - ux * sy
    short = ONE / (SIX + THREE + ONE)  # 0.1
    bent = ux * ux + uy * uy + uz * uz >= short * short and sx * sx + sy * sy + sz * sz >= short * short
    size = ONE / math.sqrt(max(tx * tx + ty * ty + tz * tz, TINY)) if bent else ZERO
    out[0] = tx * size
    out[1] = ty * size
    out[2] = tz * size


@parallel
def count(positions, lengths, strands, view, most, tolerance, fade, out, sizes, error):  # type: ignore[no-untyped-def]
    """How many pieces each segment needs on the screen.

    A cubic cut evenly into m pieces departs from its chords by at most 3/4 D / m², where D is the greater second
    difference of its control points (Wang 1984); D is taken in pixels at the nearer end.

    positions (blocks, n + 1, 3 W), lengths (blocks, W); view (20,) as in `project.points`; most: greatest number of
    pieces; tolerance in pixels; fade: pieces of segments that are off the screen (0 leaves their strands out);
    out (strands, n − 1) uint16; sizes (strands,) int64: vertices of each strand, 0 where it is left out;
    error (strands,) float32: bound in pixels that is left.
    """
    n = positions.shape[1] - 1
    for s in prange(strands):
        block = positions[s // W]
        lane = s % W
        third = lengths[s // W, lane] * THIRD
        t0 = np.empty(3, np.float32)
        t1 = np.empty(3, np.float32)
        difference(block, lane, 0, n, t0)
        bound = ZERO
        seen = False
        for i in range(1, n):
            difference(block, lane, i, n, t1)
            square = ZERO
            other = ZERO
            for c in range(3):
                a = block[i, c * W + lane]
                b = block[i + 1, c * W + lane]
                p = a + t0[c] * third
                q = b - t1[c] * third
                square += (a - TWO * p + q) * (a - TWO * p + q)
                other += (p - TWO * q + b) * (p - TWO * q + b)
            scale, inside = reach(block, lane, i, third, view)
            d = WANG * math.sqrt(max(square, other)) * scale
            if inside:
                seen = True
                pieces = min(max(math.ceil(math.sqrt(d / tolerance)), ONE), np.float32(most))
                out[s, i - 1] = np.uint16(pieces)
                bound = max(bound, d / (pieces * pieces))
            else:
                out[s, i - 1] = fade
            t0[0] = t1[0]
            t0[1] = t1[1]
            t0[2] = t1[2]
        error[s] = bound
        total = 0
        if seen or fade > 0:  # a strand that is seen in part is drawn whole, coarsely where it is not seen
            total = 1
            for i in range(1, n):
                out[s, i - 1] = max(out[s, i - 1], np.uint16(1))
                total += np.int64(out[s, i - 1])
        sizes[s] = total


@function
def reach(block, lane, i, margin, view):  # type: ignore[no-untyped-def]
    """Pixels a metre at the nearer end of segment i, and whether the segment can touch the picture."""
    x0, y0, z0 = into(block[i, lane], block[i, W + lane], block[i, 2 * W + lane], view)
    x1, y1, z1 = into(block[i + 1, lane], block[i + 1, W + lane], block[i + 1, 2 * W + lane], view)
    near = view[14]
    perspective = view[12] > ZERO
    focal = view[13]
    if max(z0, z1) + margin < near:
        return ZERO, False
    # half extents of the view in the plane z = 1 (perspective) or anywhere (orthographic), margins added
    nearest = max(min(z0, z1), near)
    scale = focal / nearest if perspective else focal
    wx = view[15] / focal
    wy = view[16] / focal
    f0 = max(z0, near) if perspective else ONE
    f1 = max(z1, near) if perspective else ONE
    wide = margin * view[17]
    tall = margin * view[18]
    if min(x0 - wx * f0, x1 - wx * f1) > wide or min(-x0 - wx * f0, -x1 - wx * f1) > wide:
        return scale, False
    if min(y0 - wy * f0, y1 - wy * f1) > tall or min(-y0 - wy * f0, -y1 - wy * f1) > tall:
        return scale, False
    return scale, True


@function
def into(x, y, z, view):  # type: ignore[no-untyped-def]
    """World to view: right, up, and depth along the view direction."""
    return (
        view[0] * x + view[1] * y + view[2] * z + view[3],
        view[4] * x + view[5] * y + view[6] * z + view[7],
        view[8] * x + view[9] * y + view[10] * z + view[11],
    )


@parallel
def flatten(positions, lengths, strands, pieces, fixed, as_printed, straight, first, world):  # type: ignore[no-untyped-def]
    """Write each strand's polyline.

    pieces (strands, n − 1) uint16, or None with `fixed` pieces for every segment; as_printed, straight: array or None
    switches for the source's tangents and for no smoothing; first (strands + 1,) int64 vertex offsets;
    world (V, 3) float32 metres.
    """
    n = positions.shape[1] - 1
    for s in prange(strands):
        v = first[s]
        if first[s + 1] == v:
            continue
        block = positions[s // W]
        lane = s % W
        world[v, 0] = block[1, lane]
        world[v, 1] = block[1, W + lane]
        world[v, 2] = block[1, 2 * W + lane]
        v += 1
        third = lengths[s // W, lane] * THIRD
        t0 = np.zeros(3, np.float32)
        t1 = np.zeros(3, np.float32)
        if straight is None:
            difference(block, lane, 0, n, t0)
        for i in range(1, n):
            m = fixed if pieces is None else np.int64(pieces[s, i - 1])
            if straight is None:
                if as_printed is None:
                    difference(block, lane, i, n, t1)
                else:
                    printed(block, lane, i, n, t1)
            per = ONE / np.float32(m)
            for c in range(3):
                a = block[i, c * W + lane]
                b = block[i + 1, c * W + lane]
                if straight is None:
                    # a + t (c1 + t (c2 + t c3)), from the Bernstein form
                    p = a + t0[c] * third
                    q = b - t1[c] * third
                    c1 = THREE * (p - a)
                    c2 = THREE * (a - TWO * p + q)
                    c3 = b - a + THREE * (p - q)
                    for j in range(1, m):
                        t = np.float32(j) * per
                        world[v + j - 1, c] = a + t * (c1 + t * (c2 + t * c3))
                else:
                    for j in range(1, m):
                        world[v + j - 1, c] = a + np.float32(j) * per * (b - a)
                world[v + m - 1, c] = b
                t0[c] = t1[c]
            v += m
