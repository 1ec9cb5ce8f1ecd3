"""Contact of rods with balls, a whole row of lanes at once; see `contact` for what is done and for other solids.

An edge from q along the unit vector d may make no less than a certain angle with the axis a from q to the ball's
centre, a distance D away: d·a <= (ℓ² + D² − r²) / (2 ℓ D). The edge keeps its length, so its particle touches the ball
on a circle about a, and friction can act along that circle alone.

A ball is a row of 17 numbers: centre, radius, a tiny number, and the rigid motion (rotation by rows, translation) that
took it through this step.
"""

from __future__ import annotations

import numpy as np

from ...jit import inner
from .rod import (
    BULK,
    GRIP,
    HALF,
    HELD,
    HIT,
    LANES,
    LENGTH,
    OLD,
    ONE,
    PLACE,
    SEGMENT,
    TINY,
    TRAY,
    U0,
    U1,
    U2,
    U3,
    U4,
    ZERO,
    T,
    Y,
    greatest,
)  # fmt: skip

U5, U6, U7, U8, U9, U10, U11, U12, U13, U14, U15, U16, U17 = (np.uint64(i) for i in range(5, 18))
NEAR = np.float32(1e-12)
DEPTH = T
"""τ has been kept already; the row is free."""


@inner
def inside(s, o, x, y, z, r):
    """Whether some lane's particle is inside a ball, or near enough for the force of the step before to hold it."""
    for v in range(LANES):
        k = o + v
        length = s[k + LENGTH]
        dx = s[k - SEGMENT + PLACE] + length * s[k + Y] - x
        dy = s[k - SEGMENT + PLACE + LANES] + length * s[k + Y + LANES] - y
        dz = s[k - SEGMENT + PLACE + U2 * LANES] + length * s[k + Y + U2 * LANES] - z
        reach = r + s[k + GRIP]
        s[k + DEPTH] = reach * reach - (dx * dx + dy * dy + dz * dz)
    return greatest(s, o + DEPTH) > ZERO


@inner
def touch_ball(s, o, ball, velocity, push, j, beat, over, friction):
    """Turn the edges in rows Y of the segment at o, the j-th, off one ball; rows OLD: where the particles were before
    the step. Forces are added to row j of ``push``. Returns whether there are any.

    Lanes that are inside are first collected, side by side."""
    ox, oy, oz, r = ball[0], ball[1], ball[2], ball[3]
    if not inside(s, o, ox, oy, oz, r):
        return False
    count = U0
    for k in range(LANES):
        if s[o + DEPTH + k] > ZERO:
            held = s[o + GRIP + k] > ZERO
            for c in range(U3):
                row = c * LANES
                s[TRAY + row + count] = s[o + Y + row + k]
                s[TRAY + row + U3 * LANES + count] = ball[c] - s[o - SEGMENT + PLACE + row + k]
                s[TRAY + row + U6 * LANES + count] = s[o + OLD + row + k] - ball[c]
                s[TRAY + row + U11 * LANES + count] = s[o + HELD + row + k] if held else ZERO
                s[TRAY + row + U14 * LANES + count] = velocity[j, row + k] * beat
            s[TRAY + U9 * LANES + count] = s[o + LENGTH + k]
            s[TRAY + U10 * LANES + count] = k
            s[TRAY + U17 * LANES + count] = s[o + BULK + k] if held else ZERO
            count += U1
    turn_off(s, (count + U7) // U8 * U8, ball, friction)
    found = False
    for i in range(count):
        if s[TRAY + U17 * LANES + i] > ZERO:
            k = np.uint64(s[TRAY + U10 * LANES + i])
            found = True
            if not s[o + GRIP + k] > ZERO:
                s[HIT + k] = ONE
            s[o + GRIP + k] = ZERO
            for c in range(U3):
                row = c * LANES
                s[o + Y + row + k] = s[TRAY + row + i]
                push[j, row + k] += s[TRAY + row + U11 * LANES + i] * over
    return found


@inner
def turn_off(s, count, ball, friction):
    """The first ``count`` lanes of the tray: rows 0-2 edges, which are turned off the ball, 3-5 from the particle
    before to the centre, 6-8 where the particle was before the step, less the centre, 9 the edge's length, 11-13 the
    force of the step before, which becomes that of this step, 14-16 how far the particle would go by its velocity
    alone, 17 how much heavier than the particle is what the force moves, or 0 where there was no force; then whether
    there is contact."""
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
        dx = length * s[k]
        dy = length * s[k + LANES]
        dz = length * s[k + U2 * LANES]
        ax = s[k + U3 * LANES]
        ay = s[k + U4 * LANES]
        az = s[k + U5 * LANES]
        bulk = s[k + U17 * LANES]
        held = bulk > ZERO
        bulk = bulk if held else ONE
        # the force that would bring the particle to the surface
        nx = dx - ax
        ny = dy - ay
        nz = dz - az
        q = np.sqrt(max(nx * nx + ny * ny + nz * nz, TINY))
        hx = s[k + U11 * LANES]
        hy = s[k + U12 * LANES]
        hz = s[k + U13 * LANES]
        depth = r - q
        force = max(hx * nx + hy * ny + hz * nz, ZERO) / q + bulk * depth
        away = np.sqrt(max(ax * ax + ay * ay + az * az, TINY))
        f = ONE / away
        ux = ax * f
        uy = ay * f
        uz = az * f
        c = dx * ux + dy * uy + dz * uz
        limit = HALF * f * (length * length + (away - r) * (away + r))
        limit = min(max(limit, -length), length)
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
        # across the normal: how far it slid along the surface as the ball carries that, and the force against it
        nx = (bx - ax) * over
        ny = (by - ay) * over
        nz = (bz - az) * over
        x = s[k + U6 * LANES]
        y = s[k + U7 * LANES]
        z = s[k + U8 * LANES]
        tx = t0 * x + t1 * y + t2 * z + cx
        ty = t3 * x + t4 * y + t5 * z + cy
        tz = t6 * x + t7 * y + t8 * z + cz
        f = hx * nx + hy * ny + hz * nz
        hx -= f * nx
        hy -= f * ny
        hz -= f * nz
        sx = bx - ax - tx
        sy = by - ay - ty
        sz = bz - az - tz
        f = sx * nx + sy * ny + sz * nz
        fx = hx - bulk * (sx - f * nx)
        fy = hy - bulk * (sy - f * ny)
        fz = hz - bulk * (sz - f * nz)
        f = min(friction * force / np.sqrt(max(fx * fx + fy * fy + fz * fz, TINY)), ONE)
        fx *= f
        fy *= f
        fz *= f
        f = ONE / bulk
        mx = bx + f * (fx - hx)
        my = by + f * (fy - hy)
        mz = bz + f * (fz - hz)
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
        # an impact is no force that stays: the share of the depth that velocity alone has led to
        f = nx * (tx - x - s[k + U14 * LANES]) + ny * (ty - y - s[k + U15 * LANES]) + nz * (tz - z - s[k + U16 * LANES])
        f = max(depth - max(f, ZERO), ZERO) / max(depth, TINY)
        f = ONE if held else f
        s[k] = i * bx
        s[k + LANES] = i * by
        s[k + U2 * LANES] = i * bz
        s[k + U11 * LANES] = f * (fx + force * nx)
        s[k + U12 * LANES] = f * (fy + force * ny)
        s[k + U13 * LANES] = f * (fz + force * nz)
        s[k + U17 * LANES] = force
