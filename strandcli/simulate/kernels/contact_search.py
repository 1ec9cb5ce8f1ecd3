"""Search for a direction of an edge that rotations have not moved out of all solids: starting directions, and the cost
of a result."""

from __future__ import annotations

from ...jit import device, inlined
from ...simd import any_lane, broadcast, sqrt, where
from ...solids.kernels import box, capsule, plane, sphere
from .contact_shapes import BOX, CAPSULE, PLANE, SPHERE
from .records import BOXES, CAPSULES, PLANES, SPHERES

STARTS = 7
"""Number of starting directions."""
PARTICLE = 1e5
"""Weight of a particle's depth relative to that of a segment in the cost."""


@inlined
def direction(d, start):
    """Return starting direction number ``start`` of the edge d: d itself, then both directions of each axis."""
    along = (start + 1) // 2
    way = broadcast(d[0], 1.0 if start % 2 == 1 else -1.0)
    zero = broadcast(d[0], 0.0)
    own = broadcast(d[0], 1.0 * start) < 0.5
    return (
        where(own, d[0], way if along == 1 else zero), where(own, d[1], way if along == 2 else zero),
        where(own, d[2], way if along == 3 else zero),
    )  # fmt: skip


@device
def segment_depth(q, e, first, solids):
    """Return the greatest depth of the segment from q to q + e in any solid, at least 0; of the ``first``, whose root
    is fixed, only what exceeds its root's. Solids as in `contact_shapes.nearest`, without those of other packages."""
    x, y, z = q
    size = sqrt(e[0] * e[0] + e[1] * e[1] + e[2] * e[2])
    ends = x + e[0], y + e[1], z + e[2]
    most = broadcast(x, 0.0)
    rows, last = solids[SPHERES]
    for m in range(0, last, SPHERE):
        if any_lane(sphere.depth(rows, m, ends[0], ends[1], ends[2]) + size > 0.0):
            depth = sphere.segment_depth(rows, m, q, e)
            most = max(most, below_root(depth, sphere.depth(rows, m, x, y, z), first))
    rows, last = solids[CAPSULES]
    for m in range(0, last, CAPSULE):
        if any_lane(capsule.depth(rows, m, ends[0], ends[1], ends[2]) + size > 0.0):
            depth = capsule.segment_depth(rows, m, q, e)
            most = max(most, below_root(depth, capsule.depth(rows, m, x, y, z), first))
    rows, last = solids[PLANES]
    for m in range(0, last, PLANE):
        under = plane.depth(rows, m, x, y, z)
        depth = max(under, plane.depth(rows, m, ends[0], ends[1], ends[2]))
        most = max(most, below_root(depth, under, first))
    rows, last = solids[BOXES]
    for m in range(0, last, BOX):
        if any_lane(box.depth(rows, m, ends[0], ends[1], ends[2])[0] + size > 0.0):
            depth = box.segment_depth(rows, m, q, e)
            most = max(most, below_root(depth, box.depth(rows, m, x, y, z)[0], first))
    return most


@inlined
def below_root(depth, under, first):
    """Return the depth of a segment; of the ``first``, what exceeds the depth ``under`` of its root."""
    return depth - max(under, 0.0) if first else depth
