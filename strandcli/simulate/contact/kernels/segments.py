"""Collision of whole segments, which may pass through a solid between two particles outside of it (``segments: true``):
passes of the stage "particle" (`rule.Pass`).

The deepest point of the segment lies at a share t of it. Moving the particle by depth / t along the surface normal
there brings that point out, exactly for a flat surface; `LEAST_SHARE` bounds the displacement. The segment is then
scaled to its length from before: it is turned, not stretched. A few sweeps are enough, because later steps continue
from the result.
"""

from __future__ import annotations

from ....constants import W
from ....jit import function, inlined
from ....simd import any_lane, broadcast, lane_count, load3, pointer, sqrt, store3, where
from ....simd.vectors import add_scaled, cross, dot, scaled, select
from ....solids.kernels import box as boxes
from ....solids.kernels import capsule as capsules
from ....solids.kernels import sphere as balls
from .search import nearest_share, place

LEAST_SHARE = 0.1
"""Least t by which the depth is divided."""
CENTRED = 1e-8
"""Squared share of the radius; nearer to the centre, rounding has destroyed the direction."""
PARALLEL = 1e-6
"""Squared sine of the angle below which two axes count as parallel."""
SWEEPS = 2
TINY = 1e-30


def sphere(x, parent, grandparent, root, length, p, i, n):
    """Turn segments out of balls; p: packed spheres."""
    turn_out_of_balls(x, parent, p)


def capsule(x, parent, grandparent, root, length, p, i, n):
    """Turn segments out of capsules; p: packed capsules."""
    turn_out_of_capsules(x, parent, p)


def box(x, parent, grandparent, root, length, p, i, n):
    """Turn segments out of boxes; p: packed boxes."""
    turn_out_of_boxes(x, parent, p)


@function
def turn_out_of_balls(x, parent, p):
    """`turn` among spheres."""
    turn(in_ball, x, parent, p)


@function
def turn_out_of_capsules(x, parent, p):
    """`turn` among capsules."""
    turn(in_capsule, x, parent, p)


@function
def turn_out_of_boxes(x, parent, p):
    """`turn` among boxes."""
    turn(in_box, x, parent, p)


@inlined
def turn(touch, x, parent, p):
    """Turn segments out of solids p (solids, columns). ``touch`` returns the depth of a segment's deepest place, the
    unit normal there, and the share of the segment at which it lies. x, parent (3 W,) float32, metres."""
    rows, before, solids = pointer(x), pointer(parent), pointer(p)
    for m in range(0, p.size, p.shape[1]):
        for k in range(0, W, lane_count(rows)):
            start, end = load3(before, k, W), load3(rows, k, W)
            for _ in range(SWEEPS):
                depth, normal, share = touch(solids, m, start, end)
                inside = (depth > 0.0) & (share > 0.0)
                if not any_lane(inside):
                    break
                edge = add_scaled(end, -1.0, start)
                turned = add_scaled(edge, depth / max(share, LEAST_SHARE), normal)
                scale = sqrt(dot(edge, edge) / max(dot(turned, turned), TINY))
                end = select(inside, add_scaled(start, scale, turned), end)
            store3(rows, k, W, end[0], end[1], end[2])


@inlined
def in_ball(p, m, start, end):
    """`turn`'s touch of sphere m."""
    centre, radius = (p[m + balls.X], p[m + balls.Y], p[m + balls.Z]), p[m + balls.RADIUS]
    share = nearest_share(start, end, centre, 0.0)
    away = add_scaled(place(start, end, share), -1.0, centre)
    depth, normal = of_ball(away, radius, sideways(add_scaled(end, -1.0, start)))
    return depth, normal, share


@inlined
def in_capsule(p, m, start, end):
    """`turn`'s touch of capsule m."""
    edge = add_scaled(end, -1.0, start)
    away, share = capsules.off_axis(p, m, start, edge)
    axis = p[m + capsules.AXIS_X], p[m + capsules.AXIS_Y], p[m + capsules.AXIS_Z]
    across = cross(edge, axis)
    askew = dot(across, across) > PARALLEL * dot(edge, edge) * dot(axis, axis)
    depth, normal = of_ball(away, p[m + capsules.RADIUS], select(askew, across, sideways(edge)))
    return depth, normal, share


@inlined
def in_box(p, m, start, end):
    """`turn`'s touch of box m."""
    return boxes.touch(p, m, start, end, 0.0)


@inlined
def of_ball(away, radius, aside):
    """Return the depth of a place in a ball, from whose centre it is ``away``, and the normal; one at the centre itself
    leaves ``aside``."""
    centred = dot(away, away) <= CENTRED * radius * radius
    direction = select(centred, aside, away)
    size = sqrt(max(dot(direction, direction), TINY))
    return radius - where(centred, 0.0, size), scaled(1.0 / size, direction)


@inlined
def sideways(edge):
    """Return a horizontal vector across an edge; across a vertical one, x."""
    flat = edge[0] * edge[0] + edge[2] * edge[2] > TINY
    return where(flat, edge[2], 1.0), broadcast(edge[0], 0.0), where(flat, -edge[0], 0.0)
