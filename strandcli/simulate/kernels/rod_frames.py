"""Vectors and normals along a strand: where the frames that carry rest shapes begin, and how edges hand them on."""

from __future__ import annotations

from ...jit import inlined
from ...simd import any_lane, load3, sqrt, where
from .records import ROTATION
from .rod import TINY
from .rod_scratch import EDGE, FIRST_SEGMENT, PACK, SEGMENT

NEARLY = 0.01
"""Error of |a|² of a transported normal up to which the first term brings it to unit length."""
CLAMP = FIRST_SEGMENT - SEGMENT + EDGE
"""(3) The clamped direction."""


@inlined
def first_normal(pose, bends, bend):
    """The normal that frames begin with at the clamp, in the world; that before the step where rests are ``led``."""
    x, y, z = load3(bends, bend, PACK)
    return (
        pose[ROTATION] * x + pose[ROTATION + 1] * y + pose[ROTATION + 2] * z,
        pose[ROTATION + 3] * x + pose[ROTATION + 4] * y + pose[ROTATION + 5] * z,
        pose[ROTATION + 6] * x + pose[ROTATION + 7] * y + pose[ROTATION + 8] * z,
    )


@inlined
def carried(ax, ay, az, way, edge):
    """A normal in parallel transport from an edge t to the next one e: the rotation that takes t to e takes a to
    a − (a·e) (t + e) / (1 + t·e). ``way``: (t + e) / (1 + t·e)."""
    f = ax * edge[0] + ay * edge[1] + az * edge[2]
    ax -= f * way[0]
    ay -= f * way[1]
    az -= f * way[2]
    q = ax * ax + ay * ay + az * az
    f = 1.5 - 0.5 * q  # 1 / √q: what is carried keeps its length, but for rounding and folds
    folded = abs(q - 1.0) > NEARLY
    if any_lane(folded):
        f = where(folded, 1.0 / sqrt(max(q, TINY)), f)
    return ax * f, ay * f, az * f


@inlined
def cross(ax, ay, az, bx, by, bz):
    """Vector product."""
    return ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
