"""The step of the rod solver over blocks of strands: predict, iterate, make lengths exact, take the new velocity.

The driver calls `step` from as many threads as it likes, each with a share of the blocks and scratch of its own; lanes
are independent, so that the number of threads changes no bit. A loop over `prange` would compile everything three
times over.
"""

from __future__ import annotations

import numpy as np

from ...jit import function, inner
from . import contact, rod, rod_contact, rod_long
from .rod import (
    BULK,
    DI,
    FIRST,
    GRIP,
    HALF,
    HELD,
    HIT,
    L1,
    L2,
    LANES,
    LENGTH,
    NOWHERE,
    OFF,
    OLD,
    ONE,
    PLACE,
    SEGMENT,
    SHIFT,
    THREE,
    TINY,
    U0,
    U1,
    U2,
    U3,
    ZERO,
    A,
    C,
    E,
    K,
    M,
    T,
    U,
    Y,
)  # fmt: skip

HUGE = np.float32(1e18)
NONE = np.float32(1e-12)
LEAST = np.float32(1e-6)
FARTHEST = np.float32(1e10)


@function
def step(
    edges, velocity, before, moved, tension, positions, lengths, stiffness, mass, joint, roots, directions, bends, gust,
    pose, delta, numbers, iterations, second, curled, balls, others, whole, push, touching, scratch, residuals, first,
    stride, long,
):  # fmt: skip
    """Move the strands of blocks first, first + stride, … by one step, in place.

    edges (blocks, N, 3 W): unit vectors; velocity (blocks, N, 3 W) m/s; for BDF2, that is where `second`, before: the
    same one step before, moved: the last displacement in metres, else (1, N, 3 W) and not touched; tension (blocks, N,
    W): force densities of the last step over h²; positions (blocks, N + 2, 3 W) world, row 0 one segment before the
    root, row 1 the root; lengths (blocks, W) of a segment; stiffness (blocks, W): B / (ρ A ℓ⁴) in 1/s²; mass, joint
    (N,): a particle's mass and the rigidity of the joint before an edge, relative (root joint 2, tip mass 1/2); roots,
    directions (blocks, 3 W) in the emitter's frame; bends (blocks, N + 1, 3 W): row 0 a unit vector across each
    direction, in the emitter's frame, then the rest value of c_j in the frame carried along the strand; where not
    `curled`, (1, …) and not read; gust (blocks, W): factor of the air's velocity; pose, delta (12,): the emitter's
    rotation by rows and its translation, and what they changed by in this step; numbers: [0] step in s, [1:4] gravity
    m/s², [4:7] velocity of the air, [7] drag 1/s, [8] material damping s, [9] 1/3 for BDF2 (0 for the Euler step that
    it starts with), [10] friction, [11] error of |e|² at which iterations stop; balls (m, 17) as in `rod_contact`;
    others: four arrays of all solids as in `contact`, or None where they are all balls and segments are not caught;
    whole: segments are caught too; push (blocks, N, 3 W): acceleration of particles by contact m/s², 0 where there is
    none, touching (blocks, N): whether it is anything but 0 in a row, (1, …) each where there are no solids; scratch as `rod.size_for` says; residuals (blocks,): greatest | |e| − 1 | before
    lengths are made exact; long: None, or anything for the kernel that is O(N). All of one floating type. There are
    flags where a None would have everything compiled once more.
    """
    n = edges.shape[1]
    solid = others is not None or balls.shape[0] > 0
    for b in range(first, edges.shape[0], stride):
        twin = b if second else 0
        place_root(scratch, roots[b], directions[b], pose, delta, positions[b, 1])
        weigh(scratch, n, edges[b], tension[b], lengths[b], stiffness[b], mass, joint, numbers)
        predict(scratch, n, velocity[b], before[twin], moved[twin], lengths[b], gust[b], numbers, second)
        if curled:
            recall(scratch, n, edges[b], bends[b], pose, numbers[8] / numbers[0])
        mine = b if solid else 0
        touched = solid and any_of(touching[b])
        if touched:
            press(scratch, n, push[b], touching[b], lengths[b], numbers)
        if long is None:
            worst = rod.iterate(scratch, np.uint64(n), iterations, numbers[11])
        else:
            worst = rod_long.iterate(scratch, np.uint64(n), iterations, numbers[11])
        # | |e| − 1 | from | |e|² − 1 |; where that is small it does not matter on which side
        residuals[b] = worst / (ONE + np.sqrt(ONE + (worst if worst > ONE else -worst)))
        keep(scratch, n, tension[b], numbers[0])
        if touched:
            respond(scratch, np.uint64(n), push[b], touching[b])
        sweep(
            scratch, n, edges[b], lengths[b], positions[b], velocity[b], push[mine], touching[mine], balls, others,
            whole, numbers,
        )  # fmt: skip
        settle(scratch, n, edges[b], velocity[b], before[twin], moved[twin], lengths[b], numbers, second)
        precede(scratch, lengths[b], positions[b])


@inner
def place_root(s, local, direction, pose, delta, root):
    """The root in the world, by how much it moved, and the clamped direction, which is the edge before the first."""
    for c in range(U3):
        o = c * LANES
        a = pose[U3 * c]
        b = pose[U3 * c + U1]
        d = pose[U3 * c + U2]
        p = pose[c + U3 * U3]
        da = delta[U3 * c]
        db = delta[U3 * c + U1]
        dd = delta[U3 * c + U2]
        dp = delta[c + U3 * U3]
        for k in range(LANES):
            root[o + k] = a * local[k] + b * local[LANES + k] + d * local[U2 * LANES + k] + p
        for k in range(LANES):
            s[SHIFT + o + k] = da * local[k] + db * local[LANES + k] + dd * local[U2 * LANES + k] + dp
        for k in range(LANES):
            turned = a * direction[k] + b * direction[LANES + k] + d * direction[U2 * LANES + k]
            s[FIRST - SEGMENT + E + o + k] = turned


@inner
def weigh(s, n, edges, tension, lengths, stiffness, mass, joint, numbers):
    """Fill the scratch: the coefficients of the step, in units of a segment, and edges as they are when the root has
    moved and nothing else. Internal damping pulls each joint to the bend that it had."""
    h = numbers[0]
    damping = numbers[8] / h
    drag = numbers[7] * h
    share = damping / (ONE + damping)
    for k in range(LANES):
        s[FIRST - SEGMENT + M + k] = mass[0] * (ONE + drag)
    for j in range(np.uint64(n)):
        o = FIRST + j * SEGMENT
        heavy = mass[j] * (ONE + drag)
        stiff = h * h * joint[j] * (ONE + damping)
        for k in range(LANES):
            s[o + T + k] = tension[j, k] * (h * h)
            s[o + M + k] = heavy
            s[o + K + k] = stiffness[k] * stiff
        for c in range(U3):
            row = o + c * LANES
            for k in range(LANES):
                e = edges[j, c * LANES + k]
                s[row + E + k] = e
                s[row + U + k] = ZERO
                s[row + C + k] = share * (e - s[row - SEGMENT + E + k])
    for c in range(U3):
        row = FIRST + E + c * LANES
        for k in range(LANES):
            s[row + k] -= s[SHIFT + c * LANES + k] / lengths[k]


@inner
def predict(s, n, velocity, before, moved, lengths, gust, numbers, second):
    """u*: where particles would go alone, in units of a segment, and none further than `FARTHEST`.

    BDF2 is an Euler step of h = 2/3 Δt from extrapolated values: x̂ = x_n + (x_n − x_{n−1}) / 3, v̂ likewise.
    """
    h = numbers[0]
    third = numbers[9]
    drag = numbers[7] * h
    rest = h / (ONE + drag)
    for j in range(np.uint64(n)):
        for c in range(U3):
            o = FIRST + j * SEGMENT + A + c * LANES
            row = c * LANES
            fall = h * numbers[U1 + c]
            air = drag * numbers[U3 + U1 + c]
            if second:
                for k in range(LANES):
                    v = velocity[j, row + k]
                    v += (v - before[j, row + k]) * third
                    u = moved[j, row + k] * third + rest * (v + fall + air * gust[k])
                    s[o + k] = min(max(u / lengths[k], -FARTHEST), FARTHEST)
            else:
                for k in range(LANES):
                    u = rest * (velocity[j, row + k] + fall + air * gust[k]) / lengths[k]
                    s[o + k] = min(max(u, -FARTHEST), FARTHEST)


@inner
def recall(s, n, edges, bends, pose, damping):
    """Add the rest shape to c̄: bends are carried along by a frame that is transported without twist from the clamp, on
    the edges as they were before the step. Frames are kept in rows of the change y, which is not yet in use."""
    share = ONE / (ONE + damping)
    for c in range(U3):
        o = FIRST - SEGMENT + Y + c * LANES
        p = pose[U3 * c]
        q = pose[U3 * c + U1]
        r = pose[U3 * c + U2]
        for k in range(LANES):
            s[o + k] = p * bends[0, k] + q * bends[0, LANES + k] + r * bends[0, U2 * LANES + k]
    for j in range(np.uint64(n)):
        o = FIRST + j * SEGMENT
        b = o - SEGMENT
        bend = bends[j + U1]
        for k in range(LANES):
            tx = s[b + E + k] if j == U0 else edges[j - U1, k]
            ty = s[b + E + LANES + k] if j == U0 else edges[j - U1, LANES + k]
            tz = s[b + E + U2 * LANES + k] if j == U0 else edges[j - U1, U2 * LANES + k]
            ax = s[b + Y + k]
            ay = s[b + Y + LANES + k]
            az = s[b + Y + U2 * LANES + k]
            u = bend[k] * share
            v = bend[LANES + k] * share
            w = bend[U2 * LANES + k] * share
            s[o + C + k] += u * tx + v * ax + w * (ty * az - tz * ay)
            s[o + C + LANES + k] += u * ty + v * ay + w * (tz * ax - tx * az)
            s[o + C + U2 * LANES + k] += u * tz + v * az + w * (tx * ay - ty * ax)
            ex = edges[j, k]
            ey = edges[j, LANES + k]
            ez = edges[j, U2 * LANES + k]
            # the rotation that takes t to e takes a to a − (a·e) (t + e) / (1 + t·e)
            f = (ax * ex + ay * ey + az * ez) / max(ONE + tx * ex + ty * ey + tz * ez, np.float32(1e-6))
            ax -= f * (tx + ex)
            ay -= f * (ty + ey)
            az -= f * (tz + ez)
            f = ONE / np.sqrt(max(ax * ax + ay * ay + az * az, TINY))
            s[o + Y + k] = ax * f
            s[o + Y + LANES + k] = ay * f
            s[o + Y + U2 * LANES + k] = az * f
    for k in range(U3 * LANES):
        s[FIRST - SEGMENT + Y + k] = ZERO


@inner
def keep(s, n, tension, h):
    """τ / h² for the next step."""
    over = ONE / (h * h)
    for j in range(np.uint64(n)):
        o = FIRST + j * SEGMENT + T
        for k in range(LANES):
            t = s[o + k]
            tension[j, k] = t * over if abs(t) < HUGE else ZERO


@inner
def any_of(touching):
    """Whether some number of a row is not 0."""
    found = False
    for j in range(touching.shape[0]):
        found |= touching[j] != 0
    return found


@inner
def alone(numbers):
    """How far an acceleration of 1 m/s² takes a particle in a step that nothing else holds, in m."""
    h = numbers[0]
    return h * h / (ONE + numbers[7] * h)


@inner
def press(s, n, push, touching, lengths, numbers):
    """Add the force of contact to u*, as it was in the step before."""
    unit = alone(numbers)
    for j in range(np.uint64(n)):
        if touching[j] != 0:
            for c in range(U3):
                o = FIRST + j * SEGMENT + A + c * LANES
                for k in range(LANES):
                    s[o + k] += unit * push[j, c * LANES + k] / lengths[k]


@inner
def respond(s, n, push, touching):
    """BULK := how much heavier than the particle is what such forces move, 1 / w = H⁻¹ M χ with χ = 1 where there are
    some."""
    for j in range(n):
        o = FIRST + j * SEGMENT
        for v in range(LANES):
            k = o + v
            some = abs(push[j, v]) + abs(push[j, LANES + v]) + abs(push[j, U2 * LANES + v]) > ZERO
            y = s[k + M] if some else ZERO
            y -= s[k - SEGMENT + L1] * s[k - SEGMENT + BULK]
            s[k + BULK] = y - s[k - U2 * SEGMENT + L2] * s[k - U2 * SEGMENT + BULK]
    for a in range(n):
        o = FIRST + (n - U1 - a) * SEGMENT
        for v in range(LANES):
            k = o + v
            y = s[k + DI] * s[k + BULK] - s[k + L1] * s[k + SEGMENT + BULK]
            s[k + BULK] = y - s[k + L2] * s[k + U2 * SEGMENT + BULK]
    for j in range(n):
        o = FIRST + j * SEGMENT + BULK
        for k in range(LANES):
            y = s[o + k]
            s[o + k] = ONE / min(max(y, LEAST), ONE) if y > ZERO else ONE


@inner
def sweep(s, n, edges, lengths, positions, velocity, push, touching, balls, others, whole, numbers):
    """Root to tip: every edge gets its length exactly, heading for where the iterations put its end, and is turned off
    the solids. New edges go to rows Y; an edge that has no direction or none that is finite stays as it was.

    Rows of u, u* and c̄, no longer in use, hold where particles are, where they were, and how far they were put off."""
    solid = others is not None or balls.shape[0] > 0
    unit = alone(numbers)
    over = ONE / unit
    friction = numbers[10]
    beat = numbers[0] * (ONE + HALF * THREE * numbers[9])  # the whole step
    for k in range(LANES):
        s[HIT + k] = ZERO
    for k in range(U3 * LANES):
        s[FIRST - SEGMENT + PLACE + k] = positions[1, k]
    for j in range(np.uint64(n)):
        o = FIRST + j * SEGMENT
        p = positions[j + U2]
        for k in range(LANES):
            s[o + LENGTH + k] = lengths[k]
        straighten(s, o)
        if rod.greatest(s, o + NOWHERE) > ZERO:
            stay(s, o, edges[j])
        if solid:
            for k in range(U3 * LANES):
                s[o + OLD + k] = p[k]
            hold(s, o, push, touching, j, unit)
            found = False
            if others is not None:
                found = contact.touch(
                    s, o, lengths, velocity, push, j, beat, over, others[0], others[1], others[2], others[3], whole,
                    friction,
                )  # fmt: skip
            else:
                for m in range(balls.shape[0]):
                    found |= rod_contact.touch_ball(s, o, balls[m], velocity, push, j, beat, over, friction)
                if touching[j] != 0 and let_go(s, o):
                    for m in range(balls.shape[0]):
                        found |= rod_contact.touch_ball(s, o, balls[m], velocity, push, j, beat, over, friction)
            touching[j] = found
        advance(s, o)
        for k in range(U3 * LANES):
            p[k] = s[o + PLACE + k]


@inner
def hold(s, o, push, touching, j, unit):
    """Rows HELD and GRIP: the force of the step before, which is no more in row j of ``push``."""
    if touching[j] == 0:
        for k in range(LANES):
            s[o + GRIP + k] = ZERO
        return
    for v in range(LANES):
        k = o + v
        x = unit * push[j, v]
        y = unit * push[j, LANES + v]
        z = unit * push[j, U2 * LANES + v]
        s[k + HELD] = x
        s[k + HELD + LANES] = y
        s[k + HELD + U2 * LANES] = z
        s[k + GRIP] = np.sqrt(x * x + y * y + z * z)
    for k in range(U3 * LANES):
        push[j, k] = ZERO


@inner
def let_go(s, o):
    """Edges in lanes that no solid holds any more lose what the force of the step before did; whether there are
    any."""
    if not rod.greatest(s, o + GRIP) > ZERO:
        return False
    for v in range(LANES):
        k = o + v
        f = ONE / (s[k + LENGTH] * s[k + BULK]) if s[k + GRIP] > ZERO else ZERO
        x = s[k + Y] - f * s[k + HELD]
        y = s[k + Y + LANES] - f * s[k + HELD + LANES]
        z = s[k + Y + U2 * LANES] - f * s[k + HELD + U2 * LANES]
        f = ONE / np.sqrt(max(x * x + y * y + z * z, TINY))
        s[k + Y] = x * f
        s[k + Y + LANES] = y * f
        s[k + Y + U2 * LANES] = z * f
        s[k + GRIP] = ZERO
    return True


@inner
def straighten(s, o):
    """Rows Y of the segment at o: the unit vector along e, less how far the particle before has been put off. A row
    is marked with 1 in lanes where there is none."""
    for v in range(LANES):
        k = o + v
        x = s[k + E] - s[k - SEGMENT + OFF]
        y = s[k + E + LANES] - s[k - SEGMENT + OFF + LANES]
        z = s[k + E + U2 * LANES] - s[k - SEGMENT + OFF + U2 * LANES]
        q = x * x + y * y + z * z
        f = ONE / np.sqrt(max(q, TINY))
        s[k + Y] = x * f
        s[k + Y + LANES] = y * f
        s[k + Y + U2 * LANES] = z * f
        good = (q > NONE) & (q < HUGE * HUGE)
        s[k + NOWHERE] = ZERO if good else ONE


@inner
def stay(s, o, edge):
    """The edge as it was, in marked lanes."""
    for k in range(LANES):
        if s[o + NOWHERE + k] > ZERO:
            for c in range(U3):
                row = c * LANES + k
                s[o + Y + row] = edge[row]
                s[o + E + row] = edge[row] + s[o - SEGMENT + OFF + row]


@inner
def advance(s, o):
    """Where the particle comes to be, and how far that is from where the iterations put it."""
    for c in range(U3):
        row = o + c * LANES
        for v in range(LANES):
            k = row + v
            y = s[k + Y]
            s[k + OFF] = s[k - SEGMENT + OFF] + (y - s[k + E])
            s[k + PLACE] = s[k - SEGMENT + PLACE] + s[o + v + LENGTH] * y


@inner
def settle(s, n, edges, velocity, before, moved, lengths, numbers, second):
    """New edges, and the velocity that led to them: (u − û) / h, with u summed up from the changes of edges. A strand
    that has run into something goes on from u alone: BDF2 would take a jump of velocity further, and strands bounce."""
    over = ONE / numbers[0]
    third = numbers[9]
    rate = over / (ONE + HALF * THREE * third)
    for c in range(U3):
        sum = SHIFT + c * LANES
        row = c * LANES
        for j in range(np.uint64(n)):
            o = FIRST + j * SEGMENT + Y + row
            for k in range(LANES):
                s[sum + k] += lengths[k] * (s[o + k] - edges[j, row + k])
            for k in range(LANES):
                edges[j, row + k] = s[o + k]
            if second:
                for k in range(LANES):
                    hit = s[HIT + k] > ZERO
                    u = s[sum + k]
                    v = rate * u if hit else (u - moved[j, row + k] * third) * over
                    before[j, row + k] = v if hit else velocity[j, row + k]
                    velocity[j, row + k] = v
                    moved[j, row + k] = u
            else:
                for k in range(LANES):
                    velocity[j, row + k] = s[sum + k] * over


@inner
def precede(s, lengths, positions):
    """Row 0: one segment before the root, against the clamped direction; and no change is left in the scratch."""
    for c in range(U3):
        row = c * LANES
        for k in range(LANES):
            positions[0, row + k] = positions[1, row + k] - lengths[k] * s[FIRST - SEGMENT + E + row + k]
