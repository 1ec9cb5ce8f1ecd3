"""Compiled functions of planes, whose solid is all below them: as `sphere`; `p` holds packed planes."""

from __future__ import annotations

from typing import Any

from ...constants import W
from ...jit import device
from ...simd import broadcast, load3
from ..shapes.plane import HEIGHT, X, Y, Z
from .sphere import INF, ZERO


@device
def meet(p, m, ox, oy, oz, dx, dy, dz):
    """Return the distance as `sphere.meet`, to the upper side of plane m. Without branches."""
    down = p[m, X] * dx + p[m, Y] * dy + p[m, Z] * dz
    over = p[m, X] * ox + p[m, Y] * oy + p[m, Z] * oz - p[m, HEIGHT]
    hit = -over / down
    return INF if (down >= ZERO) | (over < ZERO) else hit


@device
def normal(p, m, x, y, z):
    """Return the outward unit normal."""
    return p[m, X], p[m, Y], p[m, Z]


@device
def outside(p, m, x, y, z, clear):
    """Return a point, moved to `clear` metres from the surface if it is nearer or inside."""
    deep = max(p[m, HEIGHT] + clear - (x * p[m, X] + y * p[m, Y] + z * p[m, Z]), ZERO)
    return x + deep * p[m, X], y + deep * p[m, Y], z + deep * p[m, Z]


@device
def depth(p, m, x, y, z):
    """Return the depth of points below plane m, negative above; vectors of lanes."""
    return p[m + HEIGHT] - (x * p[m + X] + y * p[m + Y] + z * p[m + Z])


@device
def deepest(p, m, x, o, rows):
    """Return the greatest depths of particles and of points of segments, which are those of their ends, as
    `sphere.deepest`."""
    a = load3(x, o, W)
    most = broadcast(x, 0.0)
    along = most
    for i in range(1, rows):
        b = load3(x, o + i * 3 * W, W)
        most = max(most, depth(p, m, b[0], b[1], b[2]))
        if i == 1:
            along = max(along, most - max(0.0, depth(p, m, a[0], a[1], a[2])))
    return most, max(along, most) if rows > 2 else along


def collide(x: Any, parent: Any, grandparent: Any, root: Any, length: Any, p: Any, i: int, n: int) -> None:
    """Move particles below planes to the surface, as `sphere.collide`."""
    for s in range(p.shape[0]):
        nx = p[s, X]
        ny = p[s, Y]
        nz = p[s, Z]
        c = p[s, HEIGHT]
        for k in range(W):
            out = max(c - (x[k] * nx + x[W + k] * ny + x[2 * W + k] * nz), ZERO)
            x[k] += nx * out
            x[W + k] += ny * out
            x[2 * W + k] += nz * out
