"""Where else an edge may go that its turns have not brought out of all solids: directions to begin anew from, and how
bad an edge is where it has ended up."""

from __future__ import annotations

from ...jit import device, inlined
from ...simd import any_lane, broadcast, sqrt, where
from ...solids.kernels import box, capsule, plane, sphere
from .contact_shapes import BOX, CAPSULE, PLANE, SPHERE

STARTS = 7
"""Directions from which an edge is turned anew."""
PARTICLE = 1e5
"""How much worse the depth of a particle is than that of a segment."""


@inlined
def direction(d, start):
    """Direction number ``start`` to turn the edge d anew from: d, then there and back along each axis."""
    along = (start + 1) // 2
    way = broadcast(d[0], 1.0 if start % 2 == 1 else -1.0)
    zero = broadcast(d[0], 0.0)
    own = broadcast(d[0], float(start)) < 0.5
    return (
        where(own, d[0], way if along == 1 else zero), where(own, d[1], way if along == 2 else zero),
        where(own, d[2], way if along == 3 else zero),
    )  # fmt: skip


@device
def segment_depth(q, e, first, solids):
    """Depth of the deepest place of the segment from q to q + e in any solid, 0 where it is in none. Of the ``first``
    one, whose root cannot give way, what is deeper than its root. Solids are those of `contact_shapes.nearest`; those
    of other packages do not count."""
    x, y, z = q
    size = sqrt(e[0] * e[0] + e[1] * e[1] + e[2] * e[2])
    ends = x + e[0], y + e[1], z + e[2]
    most = broadcast(x, 0.0)
    rows, last = solids[0]
    for m in range(0, last, SPHERE):
        if any_lane(sphere.depth(rows, m, ends[0], ends[1], ends[2]) + size > 0.0):
            depth = sphere.segment_depth(rows, m, q, e)
            most = max(most, below_root(depth, sphere.depth(rows, m, x, y, z), first))
    rows, last = solids[1]
    for m in range(0, last, CAPSULE):
        if any_lane(capsule.depth(rows, m, ends[0], ends[1], ends[2]) + size > 0.0):
            depth = capsule.segment_depth(rows, m, q, e)
            most = max(most, below_root(depth, capsule.depth(rows, m, x, y, z), first))
    rows, last = solids[2]
    for m in range(0, last, PLANE):
        under = plane.depth(rows, m, x, y, z)
        depth = max(under, plane.depth(rows, m, ends[0], ends[1], ends[2]))
        most = max(most, below_root(depth, under, first))
    rows, last = solids[3]
    for m in range(0, last, BOX):
        if any_lane(box.depth(rows, m, ends[0], ends[1], ends[2])[0] + size > 0.0):
            depth = box.segment_depth(rows, m, q, e)
            most = max(most, below_root(depth, box.depth(rows, m, x, y, z)[0], first))
    return most


@inlined
def below_root(depth, under, first):
    """A segment's depth; of the ``first``, whose root is ``under`` the surface, what is deeper than that."""
    return depth - max(under, 0.0) if first else depth
