"""Contact of rods with balls, a whole row of lanes at once; see `contact` for what is done and for other solids.

An edge from q along the unit vector d may make no less than a certain angle with the axis a from q to the ball's
centre, a distance D away: d·a <= (ℓ² + D² − r²) / (2 ℓ D). The edge keeps its length, so its particle touches the ball
on a circle about a, and friction, Coulomb's on displacements, can act along that circle alone.

A ball is a row of 17 numbers: centre, radius, a tiny number, and the rigid motion (rotation by rows, translation) that
took it through this step.
"""

from __future__ import annotations

import numpy as np

from ...jit import inner
from .rod import HALF, LANES, LENGTH, OLD, ONE, PLACE, SEGMENT, TINY, TRAY, U0, U1, U2, U3, U4, ZERO, T, Y, greatest

U5, U6, U7, U8, U9, U10 = (np.uint64(i) for i in range(5, 11))
NEAR = np.float32(1e-12)
DEPTH = T
"""τ has been kept already; the row is free."""


@inner
def inside(s, o, x, y, z, r):
    """Whether some lane's particle is inside a ball."""
    for v in range(LANES):
        k = o + v
        length = s[k + LENGTH]
        dx = s[k - SEGMENT + PLACE] + length * s[k + Y] - x
        dy = s[k - SEGMENT + PLACE + LANES] + length * s[k + Y + LANES] - y
        dz = s[k - SEGMENT + PLACE + U2 * LANES] + length * s[k + Y + U2 * LANES] - z
        s[k + DEPTH] = r * r - (dx * dx + dy * dy + dz * dz)
    return greatest(s, o + DEPTH) > ZERO


@inner
def touch_ball(s, o, ball, friction):
    """Turn the edges in rows Y of the segment at o off one ball; rows OLD: where the particles were before the step.

    Lanes that are inside are first collected, side by side."""
    ox, oy, oz, r = ball[0], ball[1], ball[2], ball[3]
    if not inside(s, o, ox, oy, oz, r):
        return
    count = U0
    for k in range(LANES):
        if s[o + DEPTH + k] > ZERO:
            for c in range(U3):
                row = c * LANES
                s[TRAY + row + count] = s[o + Y + row + k]
                s[TRAY + row + U3 * LANES + count] = ball[c] - s[o - SEGMENT + PLACE + row + k]
                s[TRAY + row + U6 * LANES + count] = s[o + OLD + row + k] - ball[c]
            s[TRAY + U9 * LANES + count] = s[o + LENGTH + k]
            s[TRAY + U10 * LANES + count] = k
            count += U1
    turn_off(s, (count + U7) // U8 * U8, ball, friction)
    for i in range(count):
        k = np.uint64(s[TRAY + U10 * LANES + i])
        for c in range(U3):
            s[o + Y + c * LANES + k] = s[TRAY + c * LANES + i]


@inner
def turn_off(s, count, ball, friction):
    """The first ``count`` lanes of the tray: rows 0-2 edges, which are turned off the ball, 3-5 from the particle
    before to the centre, 6-8 where the particle was before the step, less the centre, 9 the edge's length."""
    # read here, for what is read in the loop might have been written there
    r = ball[3]
    t0, t1, t2, t3, t4, t5, t6, t7, t8 = (
        ball[5], ball[6], ball[7], ball[8], ball[9], ball[10], ball[11], ball[12], ball[13],
    )  # fmt: skip
    # where the motion takes the centre of now, less that centre
    cx = t0 * ball[0] + t1 * ball[1] + t2 * ball[2] + ball[14] - ball[0]
    cy = t3 * ball[0] + t4 * ball[1] + t5 * ball[2] + ball[15] - ball[1]
    cz = t6 * ball[0] + t7 * ball[1] + t8 * ball[2] + ball[16] - ball[2]
    over = ONE / r
    for v in range(count):
        k = TRAY + v
        length = s[k + U9 * LANES]
        ex = s[k]
        ey = s[k + LANES]
        ez = s[k + U2 * LANES]
        dx = length * ex
        dy = length * ey
        dz = length * ez
        ax = s[k + U3 * LANES]
        ay = s[k + U4 * LANES]
        az = s[k + U5 * LANES]
        away = np.sqrt(max(ax * ax + ay * ay + az * az, TINY))
        f = ONE / away
        ux = ax * f
        uy = ay * f
        uz = az * f
        c = dx * ux + dy * uy + dz * uz
        limit = HALF * f * (length * length + (away - r) * (away + r))
        hit = c > limit
        limit = max(limit, -length)
        out = max((length - limit) * (length + limit), ZERO)
        # across the axis: the way that the edge leans already, or where it points straight at the centre, any
        mx = dx - c * ux
        my = dy - c * uy
        mz = dz - c * uz
        lost = mx * mx + my * my + mz * mz < NEAR * length * length
        tilted = abs(ux) > abs(uy)
        mx = (-uz * ux if tilted else -uy * ux) if lost else mx
        my = (-uz * uy if tilted else ONE - uy * uy) if lost else my
        mz = (ONE - uz * uz if tilted else -uy * uz) if lost else mz
        f = np.sqrt(out / max(mx * mx + my * my + mz * mz, TINY))
        bx = limit * ux + f * mx
        by = limit * uy + f * my
        bz = limit * uz + f * mz
        # how far it was lifted along the normal, and slid along the surface as the ball carries that
        nx = (bx - ax) * over
        ny = (by - ay) * over
        nz = (bz - az) * over
        lifted = abs((bx - dx) * nx + (by - dy) * ny + (bz - dz) * nz)
        x = s[k + U6 * LANES]
        y = s[k + U7 * LANES]
        z = s[k + U8 * LANES]
        sx = bx - ax - (t0 * x + t1 * y + t2 * z + cx)
        sy = by - ay - (t3 * x + t4 * y + t5 * z + cy)
        sz = bz - az - (t6 * x + t7 * y + t8 * z + cz)
        f = sx * nx + sy * ny + sz * nz
        sx -= f * nx
        sy -= f * ny
        sz -= f * nz
        slid = max(sx * sx + sy * sy + sz * sz, TINY)
        back = min(friction * lifted / np.sqrt(slid), ONE)
        mx = bx - back * sx
        my = by - back * sy
        mz = bz - back * sz
        f = mx * ux + my * uy + mz * uz
        mx -= f * ux
        my -= f * uy
        mz -= f * uz
        size = mx * mx + my * my + mz * mz
        stays = size < NEAR * length * length
        f = np.sqrt(out / max(size, TINY))
        i = ONE / length
        bx = bx if stays else limit * ux + f * mx
        by = by if stays else limit * uy + f * my
        bz = bz if stays else limit * uz + f * mz
        s[k] = i * bx if hit else ex
        s[k + LANES] = i * by if hit else ey
        s[k + U2 * LANES] = i * bz if hit else ez
