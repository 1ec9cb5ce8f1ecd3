"""How many pieces each segment of a curve needs on the screen, of neighbouring strands at once."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ....constants import W
from ....jit import device, inlined, parallel, prange
from ....simd import broadcast, floor, load, load3, pointer, sqrt, store, where
from ...common.kernels import view_columns as at
from ...common.kernels.numbers import ONE, TWO, ZERO
from ...view.kernels.project import to_view
from .tangents import LANES, STEP, difference, first_place, tangent

THIRD = np.float32(1 / 3)
WANG = np.float32(0.75)
"""Factor of Wang's bound, see `count`."""
SEEN, BOUND = 0, LANES
"""Rows of what is found, one number a strand: 1 where it is on the screen, else 0; bound on the distance from the
curve, pixels."""
PIECES = 2 * LANES
"""Then a row for each segment: the number of its pieces."""


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
    for group in prange((strands + LANES - 1) // LANES):
        s = np.int64(group) * LANES
        end = min(s + LANES, strands)
        work = np.empty(PIECES + positions.shape[1] * LANES, np.float32)
        drawn = split.fade.shape[0] == 0
        for k in range(s, end):
            drawn = drawn or split.fade[k] != ZERO
        if drawn:
            count_pieces(positions, s, lengths, view, split, work)
        for k in range(s, end):
            if split.fade.shape[0] > 0 and split.fade[k] == ZERO:
                sizes[k] = 0
                error[k] = ZERO
            else:
                sizes[k] = write_pieces(work, k - s, split.off_screen, out[k])
                error[k] = work[BOUND + k - s]


@device
def write_pieces(work, k, off_screen, out):
    """Write the pieces of strand k of a group to out (n − 1,); return its number of vertices."""
    seen = work[SEEN + k] > ZERO
    if not seen and off_screen == 0:
        out[:] = 0
        return 0
    total = 1
    for i in range(out.shape[0]):
        # a strand partly on the screen is drawn whole, coarsely off the screen
        pieces = np.int64(work[PIECES + i * LANES + k])
        pieces = pieces if pieces > 0 else max(off_screen, 1)
        out[i] = pieces
        total += pieces
    return total


@device
def count_pieces(positions, s, lengths, view, split, work):
    """Write what `count` needs of the strands s … s + `LANES` − 1 to the rows of `work`."""
    rows, found = pointer(positions), pointer(work)
    per = ONE / split.tolerance
    limit = np.float32(split.most)
    focal = view[at.FOCAL]
    right, below = view[at.SCREEN_WIDTH] - view[at.AXIS_X], view[at.SCREEN_HEIGHT] - view[at.AXIS_Y]
    sides = Sides(view[at.AXIS_X] / focal, right / focal, view[at.AXIS_Y] / focal, below / focal)
    n = positions.shape[1] - 1
    o = first_place(positions, s)
    none = broadcast(rows, ZERO)
    bound = seen = third = none
    if lengths is not None:
        third = load(pointer(lengths), s) * THIRD
    tx, ty, tz = difference(rows, o, 0, n)
    ax, ay, az = load3(rows, o + STEP, W)
    u0, v0, z0 = to_view(ax, ay, az, view)
    for i in range(1, n):
        sx, sy, sz = tangent(rows, o, i, n, lengths, split.as_printed)
        bx, by, bz = load3(rows, o + (i + 1) * STEP, W)
        ex, ey, ez = bx - ax, by - ay, bz - az
        if lengths is None:
            third = sqrt(ex * ex + ey * ey + ez * ez) * THIRD
        u1, v1, z1 = to_view(bx, by, bz, view)
        scale = greatest_scale(u0, v0, z0, u1, v1, z1, third, sides, view)
        there = scale > ZERO
        d = WANG * scale * sqrt(second_difference(ex, ey, ez, tx, ty, tz, sx, sy, sz, third))
        wanted = min(max(-floor(-sqrt(d * per)), ONE), limit)
        bound = where(there, max(bound, d / (wanted * wanted)), bound)
        seen = where(there, ONE, seen)
        store(found, PIECES + (i - 1) * LANES, where(there, wanted, none))
        ax, ay, az = bx, by, bz
        tx, ty, tz = sx, sy, sz
        u0, v0, z0 = u1, v1, z1
    store(found, SEEN, seen)
    store(found, BOUND, bound)


@inlined
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


@inlined
def greatest_scale(u0, v0, z0, u1, v1, z1, margin, sides, view):
    """Return the greatest number of pixels a metre within a margin, metres, around segments in view coordinates; 0 if
    none of that is on the screen; sides: of the view. Vectors."""
    near = view[at.NEAR_PLANE]
    none = broadcast(margin, ZERO)
    f0 = f1 = none + ONE
    if view[at.PERSPECTIVE] > ZERO:
        f0 = max(z0, near)
        f1 = max(z1, near)
    wide = margin * view[at.SLANT_X]
    tall = margin * view[at.SLANT_Y]
    off = max(z0, z1) + margin < near
    off = off | (min(u0 - sides.right * f0, u1 - sides.right * f1) > wide)
    off = off | (min(-u0 - sides.left * f0, -u1 - sides.left * f1) > wide)
    off = off | (min(v0 - sides.above * f0, v1 - sides.above * f1) > tall)
    off = off | (min(-v0 - sides.below * f0, -v1 - sides.below * f1) > tall)
    scale = none + view[at.FOCAL]
    if view[at.PERSPECTIVE] > ZERO:
        least = max(min(z0, z1) - margin, near)
        u = max(abs(u0), abs(u1)) + margin
        v = max(abs(v0), abs(v1)) + margin
        # away from the axis a length along the depth shows as well
        scale = scale * (min(sqrt(ONE + (u * u + v * v) / (least * least)), view[at.CORNER_STRETCH]) / least)
    return where(off, none, scale)
