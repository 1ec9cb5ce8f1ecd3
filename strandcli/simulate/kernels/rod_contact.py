"""Contact of rods with balls alone; see `contact` for what is done and for other solids.

An edge from q along the unit vector d may make no less than a certain angle with the axis a from q to the ball's
centre, a distance D away: d·a <= (ℓ² + D² − r²) / (2 ℓ D). The edge keeps its length, so its particle touches the ball
on a circle about a, and friction, Coulomb's on displacements, can act along that circle alone.

A ball is a row of 17 numbers: centre, radius, a tiny number, and the rigid motion (rotation by rows, translation) that
took it through this step.
"""

from __future__ import annotations

from ...jit import inner
from .contact import motion
from .rod import TINY
from .simd import root, some, where

NEAR = 1e-12


@inner
def touch_ball(ex, ey, ez, qx, qy, qz, ox, oy, oz, length, balls, m, friction):
    """The unit edge e from q, turned off the ball at place m; its particle was at o before the step."""
    r = balls[m + 3]
    ax = balls[m + 0] - qx
    ay = balls[m + 1] - qy
    az = balls[m + 2] - qz
    dx = length * ex
    dy = length * ey
    dz = length * ez
    x = dx - ax
    y = dy - ay
    z = dz - az
    if not some(x * x + y * y + z * z < r * r):
        return ex, ey, ez
    away = root(max(ax * ax + ay * ay + az * az, TINY))
    f = 1.0 / away
    ux = ax * f
    uy = ay * f
    uz = az * f
    c = dx * ux + dy * uy + dz * uz
    limit = 0.5 * f * (length * length + (away - r) * (away + r))
    hit = c > limit
    limit = max(limit, -length)
    out = max((length - limit) * (length + limit), 0.0)
    # across the axis: the way that the edge leans already, or where it points straight at the centre, any
    mx = dx - c * ux
    my = dy - c * uy
    mz = dz - c * uz
    size = mx * mx + my * my + mz * mz
    lost = size < NEAR * length * length
    if some(lost):
        tilted = abs(ux) > abs(uy)
        mx = where(lost, where(tilted, -uz * ux, -uy * ux), mx)
        my = where(lost, where(tilted, -uz * uy, 1.0 - uy * uy), my)
        mz = where(lost, where(tilted, 1.0 - uz * uz, -uy * uz), mz)
        size = mx * mx + my * my + mz * mz
    f = root(out / max(size, TINY))
    bx = limit * ux + f * mx
    by = limit * uy + f * my
    bz = limit * uz + f * mz
    # how far it was lifted along the normal, and slid along the surface as the ball carries that
    over = 1.0 / r
    nx = (bx - ax) * over
    ny = (by - ay) * over
    nz = (bz - az) * over
    lifted = abs((bx - dx) * nx + (by - dy) * ny + (bz - dz) * nz)
    # all from the centre: a place in the world has fewer digits
    cx, cy, cz = motion(balls, m + 5, balls[m + 0], balls[m + 1], balls[m + 2])
    tx, ty, tz = motion(balls, m + 5, ox - balls[m + 0], oy - balls[m + 1], oz - balls[m + 2])
    sx = bx - ax - (tx - balls[m + 14] + (cx - balls[m + 0]))
    sy = by - ay - (ty - balls[m + 15] + (cy - balls[m + 1]))
    sz = bz - az - (tz - balls[m + 16] + (cz - balls[m + 2]))
    f = sx * nx + sy * ny + sz * nz
    sx -= f * nx
    sy -= f * ny
    sz -= f * nz
    slid = max(sx * sx + sy * sy + sz * sz, TINY)
    back = min(friction * lifted / root(slid), 1.0)
    mx = bx - back * sx
    my = by - back * sy
    mz = bz - back * sz
    f = mx * ux + my * uy + mz * uz
    mx -= f * ux
    my -= f * uy
    mz -= f * uz
    size = mx * mx + my * my + mz * mz
    stays = size < NEAR * length * length
    f = root(out / max(size, TINY))
    i = 1.0 / length
    bx = where(stays, bx, limit * ux + f * mx)
    by = where(stays, by, limit * uy + f * my)
    bz = where(stays, bz, limit * uz + f * mz)
    return where(hit, i * bx, ex), where(hit, i * by, ey), where(hit, i * bz, ez)
