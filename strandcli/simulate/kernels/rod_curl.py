"""Curved rest shapes: what they add to c̄ in a step, and the twist of the frames that carry them.

A joint's rest is a vector m_j in the frame of the edge before it, and its energy κ_j |e_j − m_j|² / 2. Frames are
parallel-transported along the strand from the clamp and then turned about their edges by twist angles ψ_j, with the
energy χ κ_j (ψ_j − ψ_{j−1})² / 2. Twist has no inertia: ψ is where torques about edges balance (Bergou et al. 2008,
"Discrete Elastic Rods", §5). One iteration of Newton's method a step follows it.

A rest vector that is carried along also exerts a force on the edge before the joint, and through the frames on all
edges before that: with the moments T_j = κ_j e_j × m_j and twist torques q_j the edge j feels

    T_j − T_{j+1} + q_j e_{j−1} / (1 + e_{j−1}·e_j) − q_{j+1} e_{j+1} / (1 + e_j·e_{j+1}).

Without that reaction the force is no gradient, and strands of many curls gain energy from nothing. It enters through
c̄, so that the matrix of the step stays as it is: by Euler's method that of the edges before the step; by BDF2, which
such a delay would drive, iterations begin with that which the step before ended with, and go on with that of the edges
where the first of them has led to.
"""

from __future__ import annotations

from ...constants import FOLD
from ...jit import device, inlined
from ...simd import any_lane, broadcast, load, load3, sqrt, store, store3, where
from . import rod_held
from .records import DAMPING, ROTATION, STEP, TIP_JOINT, TORSION
from .rod import TINY
from .rod_scratch import AXES, EDGE, FIRST_SEGMENT, INNOVATION, LOAD, PACK, REST_BEND, SEGMENT
from .rod_tension import particle_gain
from .turning import cosine_sine

GREATEST_TWIST_CHANGE = 1.0
"""Radians that ψ changes by in a step at the most."""
LEAST_FOLD = 1e-6
"""1 + e·e' of two edges below which parallel transport from one to the other has no direction."""
NEARLY = 0.01
"""Error of |a|² of a transported normal up to which the first term brings it to unit length."""

# between the iterations, these vectors of a segment are free
TARGET = LOAD
"""(3) What of m_j is across the edge before it."""
PAST_TWIST = INNOVATION
"""ψ_{j−1} before the step."""
TWIST_OFFSET, TWIST_FACTOR, FOLD_RATE = range(3)
"""a and b of ψ_{j−1} = a + b ψ_j, from the elimination; 1 / (1 + e_{j−1}·e_j). In place of the particles' gains."""


@device
def set_rest(s, at, state, material, forcing, held, kept):
    """Add the rest shape to c̄, and update the twist. ``held``: whether tips are clamped; ``kept``: whether it is
    kept for the next step, and whether c̄ has what was kept before, which is replaced."""
    numbers = forcing.numbers
    transport_frames(s, at, state, material, forcing, held)
    share = 1 / (1 + numbers[DAMPING] / numbers[STEP])
    add_reactions(s, at, state, material, numbers[TORSION], share, held, kept)


@inlined
def unit_edge(s, o):
    """The edge at place o, brought to unit length to first order; one of wild length becomes 0."""
    x, y, z = load3(s, o + EDGE, 1)
    q = x * x + y * y + z * z
    f = 1.5 - 0.5 * q
    good = q < 3.0
    return where(good, f * x, 0.0), where(good, f * y, 0.0), where(good, f * z, 0.0)


@inlined
def first_normal(pose, bends, bend):
    """The normal that frames begin with at the clamp, in the world."""
    x, y, z = load3(bends, bend, PACK)
    return (
        pose[ROTATION] * x + pose[ROTATION + 1] * y + pose[ROTATION + 2] * z,
        pose[ROTATION + 3] * x + pose[ROTATION + 4] * y + pose[ROTATION + 5] * z,
        pose[ROTATION + 6] * x + pose[ROTATION + 7] * y + pose[ROTATION + 8] * z,
    )


@device
def transport_frames(s, at, state, material, forcing, held):
    """Transport frames from the root to the tip: set `TARGET` by the ψ before the step, and eliminate the torques about
    edges, linearised in ψ."""
    torsion = forcing.numbers[TORSION]
    n, bend, bends, joint = at.segments, at.bend, material.bends, material.joint
    tx, ty, tz = load3(s, FIRST_SEGMENT - SEGMENT + EDGE, 1)
    ax, ay, az = first_normal(forcing.pose, bends, bend)
    zero = broadcast(s, 0.0)
    angle = zero
    a = zero
    b = zero
    for j in range(n):
        o = FIRST_SEGMENT + j * SEGMENT
        free = particle_gain(n, j)
        _, v, w = load3(bends, bend + (j + 1) * AXES, PACK)
        c, d = cosine_sine(angle)
        v, w = v * c - w * d, v * d + w * c
        bx, by, bz = ty * az - tz * ay, tz * ax - tx * az, tx * ay - ty * ax
        x, y, z = v * ax + w * bx, v * ay + w * by, v * az + w * bz
        store3(s, o + TARGET, 1, x, y, z)
        ex, ey, ez = unit_edge(s, o)
        if j > 0:
            before = torsion * joint[j - 1]
            after = torsion * joint[j]
            if held is None and j + 1 == n:
                after = 0.0
            stiff = joint[j] * max(ex * x + ey * y + ez * z, 0.0)
            turn = (v * bx - w * ax) * ex + (v * by - w * ay) * ey + (v * bz - w * az) * ez
            over = 1.0 / (before * (1.0 - b) + after + stiff)
            a = (joint[j] * turn + stiff * angle + before * a) * over
            b = after * over
            store(s, free + TWIST_OFFSET, a)
            store(s, free + TWIST_FACTOR, b)
        store(s, o + PAST_TWIST, angle)
        angle = load(state.twist, at.tension + j * PACK)
        # parallel transport: the rotation that takes t to e takes a to a − (a·e) (t + e) / (1 + t·e)
        rate = 1.0 / max(1.0 + tx * ex + ty * ey + tz * ez, LEAST_FOLD)
        store(s, free + FOLD_RATE, rate)
        mx, my, mz = rate * (tx + ex), rate * (ty + ey), rate * (tz + ez)
        f = ax * ex + ay * ey + az * ez
        ax -= f * mx
        ay -= f * my
        az -= f * mz
        q = ax * ax + ay * ay + az * az
        f = 1.5 - 0.5 * q  # 1 / √q: what is carried keeps its length, but for rounding and folds
        folded = abs(q - 1.0) > NEARLY
        if any_lane(folded):
            f = where(folded, 1.0 / sqrt(max(q, TINY)), f)
        ax *= f
        ay *= f
        az *= f
        tx = ex
        ty = ey
        tz = ez
    if held is not None:
        rigid = torsion * joint[n - 1], torsion * forcing.numbers[TIP_JOINT]
        rod_held.turn_tip(s, at, state, forcing, rigid, ((tx, ty, tz), (ax, ay, az)), (a, b))


@device
def add_reactions(s, at, state, material, torsion, share, held, kept):
    """From the tip to the root: set the new ψ, and add rest vectors by it, with their reaction on edges before, to c̄.
    ``share``: of κ, that of the material without damping; ``held``, ``kept``: as in `set_rest`."""
    n, joint = at.segments, material.joint
    zero = broadcast(s, 0.0)
    sx, sy, sz = zero, zero, zero  # κ (m − e) of the joint after
    nx, ny, nz = zero, zero, zero  # the edge after it
    bx, by, bz = zero, zero, zero  # sum of the forces on edges so far
    after = zero  # q / (1 + e·e') of the joint after
    angle = zero
    ex, ey, ez = unit_edge(s, FIRST_SEGMENT + (n - 1) * SEGMENT)
    if held is not None:
        (nx, ny, nz), after, angle = rod_held.beyond(s, n)
    for j in range(n - 1, -1, -1):
        o = FIRST_SEGMENT + j * SEGMENT
        free = particle_gain(n, j)
        px, py, pz = unit_edge(s, o - SEGMENT)
        past = load(s, o + PAST_TWIST)
        now = zero
        q = zero
        if j > 0:
            now = load(s, free + TWIST_OFFSET) + load(s, free + TWIST_FACTOR) * angle
            now = past + min(max(now - past, -GREATEST_TWIST_CHANGE), GREATEST_TWIST_CHANGE)
            store(state.twist, at.tension + (j - 1) * PACK, now)
        rate = min(load(s, free + FOLD_RATE), 1.0 / FOLD)
        if held is not None or j + 1 < n:
            q = (torsion * joint[j]) * (now - angle)
        q = q * rate
        angle = now
        # moment and twist torque of the joint after, and the twist torque of this one
        mx, my, mz = cross(nx, ny, nz, sx, sy, sz)
        fx, fy, fz = cross(ex, ey, ez, mx - q * px + after * nx, my - q * py + after * ny, mz - q * pz + after * nz)
        f = sx * ex + sy * ey + sz * ez
        bx += fx + sx - f * ex
        by += fy + sy - f * ey
        bz += fz + sz - f * ez
        # this joint's rest vector
        x, y, z = load3(s, o + TARGET, 1)
        c, d = cosine_sine(now - past)
        wx, wy, wz = cross(px, py, pz, x, y, z)
        u = load(material.bends, at.bend + (j + 1) * AXES)
        x = u * px + c * x + d * wx
        y = u * py + c * y + d * wy
        z = u * pz + c * z + d * wz
        f = joint[j]
        sx, sy, sz = f * (x + px - ex), f * (y + py - ey), f * (z + pz - ez)
        f = 1.0 / joint[j]
        set_rest_bend(s, o, at.edge + j * AXES, state, share, kept, (x + f * bx, y + f * by, z + f * bz))
        nx, ny, nz = ex, ey, ez
        ex, ey, ez = px, py, pz
        after = q


@inlined
def set_rest_bend(s, o, row, state, share, kept, rest):
    """Add ``rest`` times ``share`` to c̄ of the segment at place o; where it is ``kept``, for the next step too, and
    perhaps in place of what has been kept."""
    x, y, z = load3(s, o + REST_BEND, 1)
    u, v, w = rest
    keep, before = kept
    if keep:
        if before:
            px, py, pz = load3(state.rest, row, PACK)
            x -= share * px
            y -= share * py
            z -= share * pz
        store3(state.rest, row, PACK, u, v, w)
    store3(s, o + REST_BEND, 1, x + share * u, y + share * v, z + share * w)


@inlined
def cross(ax, ay, az, bx, by, bz):
    """Vector product."""
    return ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
