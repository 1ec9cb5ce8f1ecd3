"""Contact of rods with balls, a whole row of lanes at once; see `contact` for what is done and for other solids.

An edge from q along the unit vector d may make no less than a certain angle with the axis a from q to the ball's
centre, a distance D away: d·a <= (ℓ² + D² − r²) / (2 ℓ D). The edge keeps its length, so its particle touches the ball
on a circle about a, and friction, Coulomb's on displacements, can act along that circle alone.

A ball is a row of 17 numbers: centre, radius, a tiny number, and the rigid motion (rotation by rows, translation) that
took it through this step.
"""

from __future__ import annotations

import numpy as np

from ...jit import function
from . import contact
from .rod import LANES, OLD, ONE, TINY, TWO, U1, U2, U3, ZERO, Y

NEAR = np.float32(1e-12)


@function
def inside(s, o, q, lengths, ball):
    """How many lanes' particles at q + ℓ y are inside a ball."""
    x = ball[0]
    y = ball[1]
    z = ball[2]
    r = ball[3]
    count = ZERO
    for k in range(LANES):
        dx = q[k] + lengths[k] * s[o + Y + k] - x
        dy = q[LANES + k] + lengths[k] * s[o + Y + LANES + k] - y
        dz = q[U2 * LANES + k] + lengths[k] * s[o + Y + U2 * LANES + k] - z
        s[OLD + U3 * LANES + k] = r * r - (dx * dx + dy * dy + dz * dz)
    for k in range(LANES):
        count = max(count, s[OLD + U3 * LANES + k])
    return count > ZERO


@function
def touch_ball(s, o, q, lengths, ball, friction):
    """Turn the edges in rows Y of the segment at o off one ball; rows OLD: where the particles were before the step."""
    if not inside(s, o, q, lengths, ball):
        return
    for k in range(LANES):
        length = lengths[k]
        dx = s[o + Y + k]
        dy = s[o + Y + LANES + k]
        dz = s[o + Y + U2 * LANES + k]
        ax = ball[0] - q[k]
        ay = ball[1] - q[LANES + k]
        az = ball[2] - q[U2 * LANES + k]
        away = np.sqrt(max(ax * ax + ay * ay + az * az, TINY))
        f = ONE / away
        ax *= f
        ay *= f
        az *= f
        limit = (length * length + (away - ball[3]) * (away + ball[3])) / (TWO * length * away)
        c = dx * ax + dy * ay + dz * az
        hit = c > limit
        limit = max(limit, -ONE)
        out = np.sqrt(max(ONE - limit * limit, ZERO))
        # across a: the way that the edge leans already, or where it points straight at the centre, any
        mx = dx - c * ax
        my = dy - c * ay
        mz = dz - c * az
        size = mx * mx + my * my + mz * mz
        lost = size < NEAR
        tilted = abs(ax) > abs(ay)
        mx = (-az * ax if tilted else -ay * ax) if lost else mx
        my = (-az * ay if tilted else ONE - ay * ay) if lost else my
        mz = (ONE - az * az if tilted else -ay * az) if lost else mz
        f = out / np.sqrt(max(mx * mx + my * my + mz * mz, TINY))
        bx = limit * ax + f * mx
        by = limit * ay + f * my
        bz = limit * az + f * mz
        # how far it was lifted along the normal, and slid along the surface as the ball carries that
        f = ONE / ball[3]
        px = q[k] + length * bx
        py = q[LANES + k] + length * by
        pz = q[U2 * LANES + k] + length * bz
        nx = (px - ball[0]) * f
        ny = (py - ball[1]) * f
        nz = (pz - ball[2]) * f
        lifted = abs(length * ((bx - dx) * nx + (by - dy) * ny + (bz - dz) * nz))
        x = s[OLD + k]
        y = s[OLD + LANES + k]
        z = s[OLD + U2 * LANES + k]
        sx = px - (ball[5] * x + ball[6] * y + ball[7] * z + ball[14])
        sy = py - (ball[8] * x + ball[9] * y + ball[10] * z + ball[15])
        sz = pz - (ball[11] * x + ball[12] * y + ball[13] * z + ball[16])
        f = sx * nx + sy * ny + sz * nz
        sx -= f * nx
        sy -= f * ny
        sz -= f * nz
        slid = np.sqrt(max(sx * sx + sy * sy + sz * sz, TINY))
        back = min(friction * lifted, slid) / (slid * length)
        ex = bx - back * sx
        ey = by - back * sy
        ez = bz - back * sz
        f = ex * ax + ey * ay + ez * az
        mx = ex - f * ax
        my = ey - f * ay
        mz = ez - f * az
        size = mx * mx + my * my + mz * mz
        f = out / np.sqrt(max(size, TINY))
        stays = size < NEAR
        bx = bx if stays else limit * ax + f * mx
        by = by if stays else limit * ay + f * my
        bz = bz if stays else limit * az + f * mz
        s[o + Y + k] = bx if hit else dx
        s[o + Y + LANES + k] = by if hit else dy
        s[o + Y + U2 * LANES + k] = bz if hit else dz


@function
def touch_others(s, o, q, lengths, others, whole, friction):
    """Turn them off solids of every kind."""
    contact.touch(s, o + Y, OLD, q, lengths, others[0], others[1], others[2], others[3], whole, friction)
