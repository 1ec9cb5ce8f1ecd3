"""Compiled functions of planes, whose solid is all below them: as `sphere`; `p` holds packed planes."""

from __future__ import annotations

from typing import Any

from ...constants import W
from ...jit import device
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
def segment_depth(p, m, start, edge):
    """Return the depth as `sphere.segment_depth`: that of the deeper end."""
    end = start[0] + edge[0], start[1] + edge[1], start[2] + edge[2]
    return max(depth(p, m, start[0], start[1], start[2]), depth(p, m, end[0], end[1], end[2]))


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
