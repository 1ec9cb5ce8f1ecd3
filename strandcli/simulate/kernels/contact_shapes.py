"""Search for the solid that a particle of a rod is deepest in, and the ball or face that it is kept out of.

Solids are packed as by `strandcli.solids.pack`, each row followed by the `MOTION` of this step. All solids of a kind
are a pair: the numbers of all rows, and how many numbers; a single solid is numbers and the index m of its row's
beginning. Coordinates are vectors of lanes.

If whole edges are kept out, each particle keeps such a distance from a solid that the adjacent halves of its edges, in
their present directions, are outside: √(r² + s²) from a ball, where s is the distance along a half edge to its point
nearest to the centre. So contact near the beginning of an edge does not act on its end by a lever. Of the first edge,
whose root is fixed, the particle accounts for the whole.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from ...jit import device, inlined
from ...simd import any_lane, broadcast, load3, sqrt, where
from ...solids import COLUMNS
from ...solids.kernels import box, capsule, plane, sphere
from ...solids.kernels.box import HALF, ROW_X, ROW_Y, ROW_Z
from .contact_others import by_others
from .contact_place import SLOT, TINY, is_nearer, write_slot
from .records import BOXES, CAPSULES, MOTION, PLANES, SPHERES
from .rod_scratch import EDGE, SEGMENT, SOLID_SLOTS

OUT_OF_REACH = -1.0 / TINY
"""Less than any depth."""
LEAST = 1e-6
"""Length below which a difference of two unit vectors has no direction."""
OF_SPHERE, OF_CAPSULE, OF_PLANE, OF_BOX = COLUMNS.values()
SPHERE, CAPSULE, PLANE, BOX = (columns + MOTION for columns in COLUMNS.values())
"""Columns of a packed solid without its motion, and with it."""


class Edges(NamedTuple):
    """The two edges of a particle."""

    edge: Any
    """Unit vector of the edge that ends at the particle."""
    next: Any
    """Unit vector of the edge that begins there; zero at the tip."""
    length: Any
    """Metres."""
    lever: Any
    """Greatest distance from the particle of the points of an edge that it accounts for, metres; 0 if only particles
    are kept out."""
    whole: Any
    """Whether edges are kept out, not only particles."""
    first: Any
    """Whether the edge begins at the root."""


@device
def edge_depth_in_box(boxes, m, x, y, z, dx, dy, dz, reach):
    """Return the depth in box m of the line from (x, y, z) along the unit vector d up to ``reach``, and the normal of
    the shortest way out; the depth is `OUT_OF_REACH` if the line meets no face.

    A line that enters by a face F and leaves by a face G cuts off an edge of the box; the way out is perpendicular to
    the line and to that edge, |d·G| F + |d·F| G. A line that passes G before it comes to F misses the edge, at a
    negative depth. One that leaves by the opposite face, or not at all, leaves by the face nearest to its middle.
    """
    zero = broadcast(x, 0.0)
    enter = zero
    leave = reach
    f = zero
    g = zero
    ax, ay, az = zero, zero, zero
    bx, by, bz = zero, zero, zero
    for k in range(3):
        half = boxes[m + HALF + k]
        q = box.own(boxes, m, k, x - boxes[m + box.X], y - boxes[m + box.Y], z - boxes[m + box.Z])
        d = box.own(boxes, m, k, dx, dy, dz)
        size = max(abs(d), TINY)
        way = where(d < 0.0, broadcast(x, -1.0), 1.0)
        begin = -(half + way * q) / size
        end = (half - way * q) / size
        later = begin > enter
        enter = max(enter, begin)
        f = where(later, size, f)
        ax = where(later, -way * boxes[m + ROW_X + k], ax)
        ay = where(later, -way * boxes[m + ROW_Y + k], ay)
        az = where(later, -way * boxes[m + ROW_Z + k], az)
        sooner = end < leave
        leave = min(leave, end)
        g = where(sooner, size, g)
        bx = where(sooner, way * boxes[m + ROW_X + k], bx)
        by = where(sooner, way * boxes[m + ROW_Y + k], by)
        bz = where(sooner, way * boxes[m + ROW_Z + k], bz)
    inside = leave > enter
    if not any_lane(inside | ((f > 0.0) & (g > 0.0))):
        return broadcast(x, OUT_OF_REACH), zero, zero, zero
    nx = g * ax + f * bx
    ny = g * ay + f * by
    nz = g * az + f * bz
    size = sqrt(nx * nx + ny * ny + nz * nz)
    edge = size > LEAST
    over = 1.0 / max(size, LEAST)
    depth = (leave - enter) * f * g * over
    nx *= over
    ny *= over
    nz *= over
    if any_lane(inside & ~edge):
        t = where(g > 0.0, 0.5 * (enter + leave), leave)
        d, ax, ay, az = box.depth(boxes, m, x + t * dx, y + t * dy, z + t * dz)
        depth = where(edge, depth, d)
        nx = where(edge, nx, ax)
        ny = where(edge, ny, ay)
        nz = where(edge, nz, az)
    return where(inside | edge, depth, OUT_OF_REACH), nx, ny, nz


@inlined
def nearest_on_edges(x, y, z, edge, next, half):
    """Return the distances along a particle's edges, back and on, to their points nearest to a point; the particle is
    at (x, y, z) relative to it. At most ``half``."""
    back = min(max(x * edge[0] + y * edge[1] + z * edge[2], 0.0), half)
    on = min(max(-(x * next[0] + y * next[1] + z * next[2]), 0.0), half)
    return back, on


@inlined
def clearance_radius(away, radius, edges):
    """Return the distance from a ball's centre at which the halves of a particle's edges are outside of the ball, and
    all of the first edge: there s is its part beyond the tangent point. A first edge that begins inside is kept from
    going deeper than its root. away: the particle relative to the centre."""
    if not edges.whole:
        return broadcast(away[0], radius)
    dx, dy, dz = away
    edge, length = edges.edge, edges.length
    back, on = nearest_on_edges(dx, dy, dz, edge, edges.next, 0.5 * length)
    reach = broadcast(length, radius)
    if edges.first:
        x = dx - length * edge[0]
        y = dy - length * edge[1]
        z = dz - length * edge[2]
        square = x * x + y * y + z * z
        back = max(length - sqrt(max(square - radius * radius, 0.0)), 0.0)
        reach = min(reach, sqrt(square))
    s = max(back, on)
    return max(sqrt(s * s + reach * reach), radius)


@device
def axis_point_near_edges(capsules, m, point, on_axis, edges):
    """Return the point of a capsule's axis nearest to a particle's edges, by alternating projections from ``on_axis``,
    the point nearest to the particle."""
    x, y, z = point
    ox, oy, oz = on_axis
    edge, next = edges.edge, edges.next
    for _ in range(2):
        back, on = nearest_on_edges(x - ox, y - oy, z - oz, edge, next, edges.lever)
        behind = back > on
        back = where(behind, back, 0.0)
        on = where(behind, 0.0, on)
        ox, oy, oz = capsule.on_axis(
            capsules, m, x - back * edge[0] + on * next[0], y - back * edge[1] + on * next[1],
            z - back * edge[2] + on * next[2],
        )  # fmt: skip
    return ox, oy, oz


@device
def deeper(one, other):
    """Return the one of two (depth, x, y, z), depth and normal, that has the greater depth."""
    a = one[0] > other[0]
    return (
        max(one[0], other[0]), where(a, one[1], other[1]), where(a, one[2], other[2]), where(a, one[3], other[3]),
    )  # fmt: skip


@device
def box_depth_with_edges(boxes, m, point, under, edges, reach):
    """Return depth and normal of a particle in box m: ``under``, from `box.depth`, or those of its edges if the
    particle is outside and its edges are at most ``reach`` outside."""
    x, y, z = point
    edge, next = edges.edge, edges.next
    out = under[0] <= 0.0
    back = edge_depth_in_box(boxes, m, x, y, z, -edge[0], -edge[1], -edge[2], edges.lever)
    on = edge_depth_in_box(boxes, m, x, y, z, next[0], next[1], next[2], 0.5 * edges.length)
    depth, nx, ny, nz = deeper(back, on)
    return deeper((where(out & (depth > -reach), depth, OUT_OF_REACH), nx, ny, nz), under)


@inlined
def edges_of(s, o, edge, length, whole, first):
    """Return the `Edges` of the particle at the end of the segment at index o of the scratch."""
    zero = broadcast(length, 0.0)
    next = zero, zero, zero
    lever = zero
    if whole:
        next = load3(s, o + SEGMENT + EDGE, 1)
        lever = length if first else 0.5 * length
    return Edges(edge, next, length, lever, whole, first)


@inlined
def nearest(s, point, edges, at, reach, solids):
    """Return the depth of a particle in the solid that it is deepest in, or nearest to within ``reach``, and the index
    of that solid's slot in the scratch; -reach if there is none.

    point: the particle; edges: its `Edges`; at: positions, and the index in them of the particle before this step;
    solids: `records.Contact.solids`.
    """
    return nearest_but(s, None, (SOLID_SLOTS, SOLID_SLOTS + SLOT), point, edges, at, reach, solids)


@inlined
def nearest_but(s, known, slots, point, edges, at, reach, solids):
    """Return `nearest` of all solids but that in the slot ``known``, where it is not None; ``slots``: places of two."""
    most, slots = nearest_sphere(s, known, slots, -reach, point, edges, at, solids[SPHERES])
    most, slots = nearest_capsule(s, known, slots, most, point, edges, at, solids[CAPSULES])
    most, slots = nearest_plane(s, known, slots, most, point, at, solids[PLANES])
    most, slots = nearest_box(s, known, slots, most, point, edges, at, solids[BOXES], reach)
    return by_others(s, known, slots, most, point, (edges.edge, edges.next), edges.lever, at, solids)


@inlined
def nearest_sphere(s, known, slots, most, point, edges, at, spheres):
    """Return `nearest` among spheres: the greatest depth, at least ``most``, and the indices of the slots, that of the
    solid first."""
    x, y, z = point
    rows, end = spheres
    found, other = slots
    for m in range(0, end, SPHERE):
        radius = rows[m + sphere.RADIUS]
        dx, dy, dz = x - rows[m + sphere.X], y - rows[m + sphere.Y], z - rows[m + sphere.Z]
        far = radius + edges.lever - most
        if any_lane(dx * dx + dy * dy + dz * dz < far * abs(far)):
            r = clearance_radius((dx, dy, dz), radius, edges)
            depth = sphere.ball_depth(dx, dy, dz, r)
            centre = (
                broadcast(x, rows[m + sphere.X]), broadcast(x, rows[m + sphere.Y]), broadcast(x, rows[m + sphere.Z]),
            )  # fmt: skip
            nearer = is_nearer(s, known, depth, most, centre, r)
            found, other = write_slot(s, found, other, nearer, 1.0, centre, r, rows, m + OF_SPHERE, at)
            most = where(nearer, depth, most)
    return most, (found, other)


@inlined
def nearest_capsule(s, known, slots, most, point, edges, at, capsules):
    """Return the same among capsules, each of which acts as a ball around the nearest point of its axis."""
    x, y, z = point
    rows, end = capsules
    found, other = slots
    for m in range(0, end, CAPSULE):
        radius = rows[m + capsule.RADIUS]
        ox, oy, oz = capsule.on_axis(rows, m, x, y, z)
        dx, dy, dz = x - ox, y - oy, z - oz
        far = radius + edges.lever - most
        if any_lane(dx * dx + dy * dy + dz * dz < far * abs(far)):
            r = broadcast(x, radius)
            if edges.whole:
                px, py, pz = axis_point_near_edges(rows, m, point, (ox, oy, oz), edges)
                clear = clearance_radius((x - px, y - py, z - pz), radius, edges)
                by_edge = sphere.ball_depth(x - px, y - py, z - pz, clear) > sphere.ball_depth(dx, dy, dz, radius)
                ox, oy, oz = where(by_edge, px, ox), where(by_edge, py, oy), where(by_edge, pz, oz)
                r = where(by_edge, clear, r)
            depth = sphere.ball_depth(x - ox, y - oy, z - oz, r)
            nearer = is_nearer(s, known, depth, most, (ox, oy, oz), r)
            found, other = write_slot(s, found, other, nearer, 1.0, (ox, oy, oz), r, rows, m + OF_CAPSULE, at)
            most = where(nearer, depth, most)
    return most, (found, other)


@inlined
def nearest_plane(s, known, slots, most, point, at, planes):
    """Return the same among planes, in which no edge is deeper than both of its ends."""
    x, y, z = point
    rows, end = planes
    found, other = slots
    for m in range(0, end, PLANE):
        depth = plane.depth(rows, m, x, y, z)
        if any_lane(depth > most):
            normal = broadcast(x, rows[m + plane.X]), broadcast(x, rows[m + plane.Y]), broadcast(x, rows[m + plane.Z])
            height = broadcast(x, rows[m + plane.HEIGHT])
            nearer = is_nearer(s, known, depth, most, normal, height)
            found, other = write_slot(s, found, other, nearer, 0.0, normal, height, rows, m + OF_PLANE, at)
            most = where(nearer, depth, most)
    return most, (found, other)


@inlined
def nearest_box(s, known, slots, most, point, edges, at, boxes, reach):
    """Return the same among boxes; at their edges and corners the face is the tangent plane."""
    x, y, z = point
    rows, end = boxes
    found, other = slots
    for m in range(0, end, BOX):
        depth, nx, ny, nz = box.depth(rows, m, x, y, z)
        if any_lane(depth + edges.lever > most):
            if edges.whole:
                depth, nx, ny, nz = box_depth_with_edges(rows, m, point, (depth, nx, ny, nz), edges, reach)
            level = depth + x * nx + y * ny + z * nz
            nearer = is_nearer(s, known, depth, most, (nx, ny, nz), level)
            found, other = write_slot(s, found, other, nearer, 0.0, (nx, ny, nz), level, rows, m + OF_BOX, at)
            most = where(nearer, depth, most)
    return most, (found, other)
