"""Smooth polylines from particles (thesis §3): each segment becomes a cubic Bézier curve, cut into straight pieces.

Tangents point from root to tip, the opposite of the source's sign, so the control points of the segment p_{i-1} p_i are
p_{i-1} + t_{i-1} L / 3 and p_i − t_i L / 3. The first tangent is the strand's direction, the last is zero.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ....constants import W
from ....jit import device, inlined, parallel, prange
from ...common.kernels.view_columns import (
    AXIS_X,
    AXIS_Y,
    CORNER_STRETCH,
    FOCAL,
    NEAR_PLANE,
    PERSPECTIVE,
    SCREEN_HEIGHT,
    SCREEN_WIDTH,
    SLANT_X,
    SLANT_Y,
)
from ...view.kernels.project import to_view
from .tangents import difference, tangent

ZERO = np.float32(0.0)
ONE = np.float32(1.0)
TWO = np.float32(2.0)
THREE = np.float32(3.0)
THIRD = np.float32(1 / 3)
TINY = np.float32(1e-30)
WANG = np.float32(0.75)
"""Factor of Wang's bound, see `count`."""


class Splitting(NamedTuple):
    """Settings of how segments are cut into pieces."""

    most: int
    """Greatest number of pieces of a segment."""
    tolerance: np.float32
    """Greatest distance of a piece from its curve, pixels."""
    off_screen: int
    """Number of pieces of a segment off the screen; 0: strands that are entirely off the screen are left out."""
    fade: NDArray[np.float32]
    """(strands,) 0 for strands that are left out; (0,): none is."""
    as_printed: bool
    """Whether tangents are computed as the source prints them."""


class Sides(NamedTuple):
    """Distances of the picture's sides from the axis at a depth of one: those of a crop window differ."""

    left: np.float32
    right: np.float32
    above: np.float32
    below: np.float32


@parallel
def count(positions, lengths, strands, view, split, out, sizes, error):
    """Write the number of pieces that each segment needs on the screen.

    A cubic cut evenly into m pieces departs from its chords by at most 3/4 D / m², where D is the greater second
    difference of its control points (Wang 1984). D is converted to pixels at the segment's nearest possible depth.

    positions (blocks, n + 1, 3 W), metres; lengths (blocks, W), or None: those of the chords; view: `view_columns`;
    split: `Splitting`; out (strands, n − 1) uint16; sizes (strands,) int64: number of vertices of each strand, 0 if it
    is left out; error (strands,) float32: bound on the distance from the curve, pixels.
    """
    fade = split.fade
    for s in prange(strands):
        if fade.shape[0] > 0 and fade[s] == ZERO:
            sizes[s] = 0
            error[s] = ZERO
        else:
            third = ZERO if lengths is None else lengths[s // W, s % W] * THIRD
            sizes[s], error[s] = count_pieces(positions[s // W], s % W, third, lengths, view, split, out[s])


@device
def count_pieces(block, lane, third, lengths, view, split, out):
    """Write the number of pieces of each segment of one strand to out (n − 1,); return its number of vertices and the
    bound on the distance from the curve, pixels. block (n + 1, 3 W); third: a third of the segments' length, if lengths
    is not None."""
    per = ONE / split.tolerance
    limit = np.float32(split.most)
    sides = sides_of(view)
    off_screen = split.off_screen
    n = block.shape[0] - 1
    tx, ty, tz = difference(block, lane, 0, n)
    ax = block[1, lane]
    ay = block[1, W + lane]
    az = block[1, 2 * W + lane]
    u0, v0, z0 = to_view(ax, ay, az, view)
    bound = ZERO
    seen = False
    total = 1
    for i in range(1, n):
        sx, sy, sz = tangent(block, lane, i, n, lengths, split.as_printed)
        bx = block[i + 1, lane]
        by = block[i + 1, W + lane]
        bz = block[i + 1, 2 * W + lane]
        if lengths is None:
            third = norm(bx - ax, by - ay, bz - az) * THIRD
        u1, v1, z1 = to_view(bx, by, bz, view)
        pieces = np.int64(off_screen)
        scale = greatest_scale(u0, v0, z0, u1, v1, z1, third, sides, view)
        if scale > ZERO:
            seen = True
            d = WANG * scale * np.sqrt(second_difference(bx - ax, by - ay, bz - az, tx, ty, tz, sx, sy, sz, third))
            wanted = min(max(np.ceil(np.sqrt(d * per)), ONE), limit)
            bound = max(bound, d / (wanted * wanted))
            pieces = np.int64(wanted)
        out[i - 1] = pieces
        total += pieces
        tx = sx
        ty = sy
        tz = sz
        ax = bx
        ay = by
        az = bz
        u0 = u1
        v0 = v1
        z0 = z1
    if off_screen == 0 and seen:  # a strand partly on the screen is drawn whole, coarsely off the screen
        for i in range(n - 1):
            if out[i] == 0:
                out[i] = 1
                total += 1
    return total if seen or off_screen > 0 else 0, bound


@device
def second_difference(ex, ey, ez, tx, ty, tz, sx, sy, sz, third):
    """Return the square of the greater second difference of the control points a, a + t L/3, b − s L/3, b, with
    b − a = e and third = L/3."""
    px = ex - (TWO * tx + sx) * third
    py = ey - (TWO * ty + sy) * third
    pz = ez - (TWO * tz + sz) * third
    qx = (tx + TWO * sx) * third - ex
    qy = (ty + TWO * sy) * third - ey
    qz = (tz + TWO * sz) * third - ez
    return max(px * px + py * py + pz * pz, qx * qx + qy * qy + qz * qz)


@device
def sides_of(view):
    """Return the `Sides` of a view: four divisions a strand instead of four a segment."""
    focal = view[FOCAL]
    right, below = view[SCREEN_WIDTH] - view[AXIS_X], view[SCREEN_HEIGHT] - view[AXIS_Y]
    return Sides(view[AXIS_X] / focal, right / focal, view[AXIS_Y] / focal, below / focal)


@inlined
def greatest_scale(u0, v0, z0, u1, v1, z1, margin, sides, view):
    """Return the greatest number of pixels a metre within a margin, metres, around a segment in view coordinates; 0 if
    none of that is on the screen; sides: `sides_of` the view."""
    near = view[NEAR_PLANE]
    if max(z0, z1) + margin < near:
        return ZERO
    f0 = ONE
    f1 = ONE
    if view[PERSPECTIVE] > ZERO:
        f0 = max(z0, near)
        f1 = max(z1, near)
    wide = margin * view[SLANT_X]
    tall = margin * view[SLANT_Y]
    if min(u0 - sides.right * f0, u1 - sides.right * f1) > wide:
        return ZERO
    if min(-u0 - sides.left * f0, -u1 - sides.left * f1) > wide:
        return ZERO
    if min(v0 - sides.above * f0, v1 - sides.above * f1) > tall:
        return ZERO
    if min(-v0 - sides.below * f0, -v1 - sides.below * f1) > tall:
        return ZERO
    scale = view[FOCAL]
    if view[PERSPECTIVE] > ZERO:
        least = max(min(z0, z1) - margin, near)
        u = max(abs(u0), abs(u1)) + margin
        v = max(abs(v0), abs(v1)) + margin
        # away from the axis a length along the depth shows as well
        scale *= min(np.sqrt(ONE + (u * u + v * v) / (least * least)), view[CORNER_STRETCH]) / least
    return scale


@parallel
def flatten(positions, lengths, strands, pieces, fixed, as_printed, straight, first, world):
    """Write the polylines of strands.

    positions (blocks, n + 1, 3 W), metres; lengths (blocks, W), or None: those of the chords; pieces (strands, n − 1)
    uint16, or (0, 0): every segment has `fixed` pieces; as_printed: whether tangents are computed as the source prints
    them; straight: whether segments stay straight; first (strands + 1,) int64 vertex offsets; world (V, 3) float32,
    metres, written.
    """
    for strand in prange(strands):
        s = np.int64(strand)
        if first[s + 1] != first[s]:
            write_polyline(positions[s // W], lengths, s, pieces, fixed, as_printed, straight, first[s], world)


@inlined
def write_polyline(block, lengths, s, pieces, fixed, as_printed, straight, v, world):
    """Write the polyline of strand s, in a block (n + 1, 3 W), from vertex v on; other arguments as in `flatten`."""
    n = block.shape[0] - 1
    lane = s % W
    ax, ay, az = block[1, lane], block[1, W + lane], block[1, 2 * W + lane]
    write_vertex(world, v, ax, ay, az)
    third = ZERO if lengths is None else lengths[s // W, lane] * THIRD
    tx, ty, tz = difference(block, lane, 0, n)
    for i in range(1, n):
        m = np.int64(fixed) if pieces.shape[0] == 0 else np.int64(pieces[s, i - 1])
        bx, by, bz = block[i + 1, lane], block[i + 1, W + lane], block[i + 1, 2 * W + lane]
        ex, ey, ez = bx - ax, by - ay, bz - az
        per = ONE / np.float32(m)
        if not straight:
            sx, sy, sz = tangent(block, lane, i, n, lengths, as_printed)
            if lengths is None:
                third = norm(ex, ey, ez) * THIRD
            for j in range(1, m):
                t = np.float32(j) * per
                x = bezier(t, ax, ex, tx * third, sx * third)
                y = bezier(t, ay, ey, ty * third, sy * third)
                z = bezier(t, az, ez, tz * third, sz * third)
                write_vertex(world, v + j, x, y, z)
            tx, ty, tz = sx, sy, sz
        else:
            for j in range(1, m):
                t = np.float32(j) * per
                write_vertex(world, v + j, ax + t * ex, ay + t * ey, az + t * ez)
        v += m
        write_vertex(world, v, bx, by, bz)
        ax, ay, az = bx, by, bz


@inlined
def write_vertex(world, v, x, y, z):
    """Write the position of one vertex."""
    world[v, 0] = x
    world[v, 1] = y
    world[v, 2] = z


@inlined
def bezier(t, a, e, g, h):
    """Return a coordinate at t, 0 to 1, of the Bézier curve with the control points a, a + g, a + e − h and a + e."""
    return a + t * (THREE * g + t * (second_coefficient(e, g, h) + t * third_coefficient(e, g, h)))


@device
def norm(x, y, z):
    """Return the length of a vector."""
    return np.sqrt(x * x + y * y + z * z)


@parallel
def longest_segment(positions):
    """Return the length of the longest segment of positions (blocks, n + 1, 3 W), metres."""
    found = np.zeros(positions.shape[0], np.float32)
    for block in prange(positions.shape[0]):
        most = ZERO
        for i in range(2, positions.shape[1]):
            for k in range(W):
                x = positions[block, i, k] - positions[block, i - 1, k]
                y = positions[block, i, W + k] - positions[block, i - 1, W + k]
                z = positions[block, i, 2 * W + k] - positions[block, i - 1, 2 * W + k]
                most = max(most, norm(x, y, z))
        found[block] = most
    return found.max()


@device
def second_coefficient(e, g, h):
    """Return the coefficient of t² of a Bézier curve; arguments as in `bezier`."""
    return THREE * (e - TWO * g - h)


@device
def third_coefficient(e, g, h):
    """Return the coefficient of t³ of a Bézier curve; arguments as in `bezier`."""
    return THREE * (g + h) - TWO * e
