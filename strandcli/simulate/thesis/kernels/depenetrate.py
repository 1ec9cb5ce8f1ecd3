"""Search for a place outside of all solids, for particles that contact with one solid after the other leaves inside.

Contact puts a particle onto the surface of one solid, which may be inside of another one, or out of reach of its
parent. What turns of contact and exact lengths leave inside, which is little, is searched for here, lane by lane in
vectors.

No place at the length L from the parent is less deep than L short of the parent's depth in any one solid, since a
depth changes by no more than the distance. What comes so near that bound, or is outside, has no better place; straight
out of a convex solid reaches it.
"""

from __future__ import annotations

import math
from typing import Any

from ....constants import W
from ....jit import device, function, inlined
from ....simd import any_lane, broadcast, lane, lane_count, load, load3, pointer, sqrt, where, with_lane
from ....solids.kernels.box import chosen
from ....solids.kernels.outside import any_depth

NEAR = 3e-7
"""Depth that counts as none, metres."""
ROUNDING = 2.4e-7
"""Share of its coordinates by which a particle may besides be deeper: two roundings in single precision."""
WAYS = 26
"""Directions that are tried: to the faces, edges and corners of a cube."""
PROBES = 4
"""Directions in which a search about the best one looks each time."""
ROUNDS = 8
FIRST_TURN = 0.25
"""Tangent of the angle at which it looks first along either of two axes: half of that between two of the `WAYS`."""
CLOSER = 0.5
"""Share by which the angle becomes smaller after a round in vain."""
HALVINGS = 10
"""Of the turn back to where the particle was."""
STEPS = 48
"""On the way out along a direction, each as long as the depth there."""
FINE = 1e-2
"""Half the way over which the direction out of a solid is measured, as a share of the segment."""
FARTHEST = 1e20
"""Metres: more than any distance."""
TINY = 1e-30
HALF = 0.5


def turn(x: Any, parent: Any, grandparent: Any, root: Any, length: Any, p: Any, i: int, n: int) -> None:
    """A pass of the stage "particle": turn what is inside a solid about its parent; p: a `strandcli.solids.Solids`."""
    bring_out(x, parent, length, p)


def leave(x: Any, parent: Any, grandparent: Any, root: Any, length: Any, p: Any, i: int, n: int) -> None:
    """The same by the nearest way out, whatever the length."""
    bring_out(x, None, length, p)


@function
def bring_out(x, parent, length, solids):
    """Move particles that are in a solid to the nearest place found outside of all, or else the least deep one, at the
    rest length from their parents, or where ``parent`` is None at any. x, parent (3 W,), length (W,) float32."""
    rows, lengths = pointer(x), pointer(length)
    lanes = lane_count(rows)
    # of as many strands as a vector has lanes: their lanes in x, and of each particle its place, its parent's, the
    # segment's rest length, the depth, and a depth than which none is much less; metres
    zero, one = broadcast(rows, 0.0), broadcast(rows, 1.0)
    some = zero, (zero, zero, zero), (zero, zero, zero), one, zero, one
    count = 0
    for k in range(0, W, lanes):
        at = load3(rows, k, W)
        depth = any_depth(solids, at[0], at[1], at[2])
        none = nothing(at)
        if any_lane(depth > none):
            q, size, goal = at, load(lengths, k), none
            if parent is not None:
                q = load3(pointer(parent), k, W)
                goal = max(any_depth(solids, q[0], q[1], q[2]) - size, 0.0) + none
            for j in range(lanes):
                if lane(depth, j) > lane(goal, j):
                    some = with_strand(some, count, k + j, (at, q, size, depth, goal), j)
                    count += 1
                if count == lanes:
                    write(x, some, found_for(parent, solids, some), count)
                    count = 0
    if count > 0:
        write(x, some, found_for(parent, solids, some), count)


@device
def found_for(parent, solids, some):
    """Return where particles come."""
    if parent is None:
        return led_out(solids, some)
    return turned(solids, some)


@device
def with_strand(some, place, number, given, j):
    """Return those strands with one more at a place: lane ``number`` of x, lane j of the vectors given."""
    numbers, at, q, size, depth, goal = some
    p, r, length, under, least = given
    return (
        with_lane(numbers, place, 1.0 * number),
        (with_lane(at[0], place, lane(p[0], j)), with_lane(at[1], place, lane(p[1], j)),
         with_lane(at[2], place, lane(p[2], j))),
        (with_lane(q[0], place, lane(r[0], j)), with_lane(q[1], place, lane(r[1], j)),
         with_lane(q[2], place, lane(r[2], j))),
        with_lane(size, place, lane(length, j)),
        with_lane(depth, place, lane(under, j)),
        with_lane(goal, place, lane(least, j)),
    )  # fmt: skip


@device
def write(x, some, places, count):
    """Write the first places to the strands' lanes of x."""
    for j in range(count):
        k = int(lane(some[0], j))
        for axis in range(3):
            x[axis * W + k] = lane(places[0] if axis == 0 else (places[1] if axis == 1 else places[2]), j)


@device
def turned(solids, some):
    """Return where particles come that stay at their parents' distance."""
    _, at, q, size, depth, goal = some
    old = (at[0] - q[0]) / size, (at[1] - q[1]) / size, (at[2] - q[2]) / size
    new = old
    wanted = depth > goal
    for way in range(-1, WAYS):
        if way == 0:
            wanted = depth > goal
            if not any_lane(wanted):
                break
        d = outward(solids, q, FINE * size) if way < 0 else direction(depth, way)
        found = depth_along(solids, q, size, d)
        # of places outside the nearest, of others the least deep
        outside = ~(found > goal)
        nearer = (depth > goal) | (square_between(d, old) < square_between(new, old))
        better = wanted & ((outside & nearer) | (~outside & (found < depth)))
        depth = where(better, found, depth)
        new = chosen(better, d, new)
    new, depth = looked_about(solids, (q, size, goal), new, depth)
    new = turned_back(solids, (q, size, goal), old, new, ~(depth > goal))
    return q[0] + size * new[0], q[1] + size * new[1], q[2] + size * new[2]


@device
def looked_about(solids, reach, d, depth):
    """Return a less deep direction near to d, and the depth there."""
    q, size, goal = reach
    angle = broadcast(depth, FIRST_TURN)
    for turn in range(ROUNDS):
        wanted = depth > goal
        if not any_lane(wanted):
            break
        u, v = across(d)
        best, before = d, depth
        for probe in range(PROBES):
            a, b = aside(probe, turn)
            a, b = angle * a, angle * b
            e = unit((d[0] + a * u[0] + b * v[0], d[1] + a * u[1] + b * v[1], d[2] + a * u[2] + b * v[2]))
            found = depth_along(solids, q, size, e)
            better = wanted & (found < depth)
            depth = where(better, found, depth)
            best = chosen(better, e, best)
        d = best
        angle = where(depth < before, angle, CLOSER * angle)
    return d, depth


@device
def turned_back(solids, reach, old, new, mask):
    """Return directions that are outside, where the mask holds, as near to old ones as halving the angle finds."""
    q, size, goal = reach
    inside = broadcast(size, 0.0)
    outside = broadcast(size, 1.0)
    found = new
    for _ in range(HALVINGS):
        t = 0.5 * (inside + outside)
        e = old[0] + t * (new[0] - old[0]), old[1] + t * (new[1] - old[1]), old[2] + t * (new[2] - old[2])
        turned = e[0] * e[0] + e[1] * e[1] + e[2] * e[2] > FINE
        e = unit(e)
        good = turned & ~(depth_along(solids, q, size, e) > goal)
        outside = where(good, t, outside)
        inside = where(good, inside, t)
        found = chosen(mask & good, e, found)
    return found


@device
def led_out(solids, some):
    """Return the nearest places outside along some directions from particles, or their own."""
    _, at, _, size, depth, goal = some
    least = broadcast(depth, FARTHEST)
    place = at
    for way in range(-1, WAYS):
        d = outward(solids, at, FINE * size) if way < 0 else direction(depth, way)
        far = broadcast(depth, 0.0)
        under = depth
        for _ in range(STEPS):
            inside = (under > goal) & (far < least)
            if not any_lane(inside):
                break
            far = where(inside, far + under, far)
            under = where(inside, depth_along(solids, at, far, d), under)
        better = ~(under > goal) & (far < least)
        least = where(better, far, least)
        place = chosen(better, (at[0] + far * d[0], at[1] + far * d[1], at[2] + far * d[2]), place)
    return place


@device
def depth_along(solids, q, far, d):
    """Return the depth in any solid at a distance from q along d."""
    return any_depth(solids, q[0] + far * d[0], q[1] + far * d[1], q[2] + far * d[2])


@device
def outward(solids, q, h):
    """Return the unit direction in which the depth at q shrinks most, by differences over 2 h; up where it is flat."""
    x, y, z = q
    d = (
        any_depth(solids, x - h, y, z) - any_depth(solids, x + h, y, z),
        any_depth(solids, x, y - h, z) - any_depth(solids, x, y + h, z),
        any_depth(solids, x, y, z - h) - any_depth(solids, x, y, z + h),
    )
    steep = d[0] * d[0] + d[1] * d[1] + d[2] * d[2] > FINE * FINE * h * h
    zero = broadcast(h, 0.0)
    return unit(chosen(steep, d, (zero, broadcast(h, 1.0), zero)))


@device
def direction(like, way):
    """Return unit direction number ``way`` of the `WAYS`, in all lanes of vectors like this one."""
    place = way if way < WAYS // 2 else way + 1  # the middle one has no length
    a, b, c = place % 3 - 1, place // 3 % 3 - 1, place // 9 - 1
    size = math.sqrt(a * a + b * b + c * c)
    return broadcast(like, a / size), broadcast(like, b / size), broadcast(like, c / size)


@device
def across(d):
    """Return two unit vectors at right angles to unit vectors d and to each other."""
    zero, one = broadcast(d[0], 0.0), broadcast(d[0], 1.0)
    steep = abs(d[0]) > HALF
    a, b = where(steep, zero, one), where(steep, one, zero)
    u = unit((-d[2] * b, d[2] * a, d[0] * b - d[1] * a))  # d × (a, b, 0)
    return u, (d[1] * u[2] - d[2] * u[1], d[2] * u[0] - d[0] * u[2], d[0] * u[1] - d[1] * u[0])


@device
def aside(probe, turn):
    """Return one of the `PROBES` places about the middle, a corner of a square that other rounds turn by an eighth."""
    a = 1.0 if probe < 2 else -1.0
    b = 1.0 if probe % 2 == 0 else -1.0
    return (a, b) if turn % 2 == 0 else (0.7 * (a - b), 0.7 * (a + b))


@inlined
def nothing(at):
    """Return the depth that counts as none at a place, metres."""
    return NEAR + ROUNDING * (abs(at[0]) + abs(at[1]) + abs(at[2]))


@inlined
def unit(d):
    """Return vectors at unit length, those without any as they are."""
    size = sqrt(max(d[0] * d[0] + d[1] * d[1] + d[2] * d[2], TINY))
    return d[0] / size, d[1] / size, d[2] / size


@inlined
def square_between(a, b):
    """Return the squared distance of two points."""
    x, y, z = a[0] - b[0], a[1] - b[1], a[2] - b[2]
    return x * x + y * y + z * z
