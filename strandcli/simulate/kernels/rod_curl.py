"""Curved rest shapes: what they add to c̄ in a step, and the twist of the frames that carry them.

A joint's rest is a vector m_j in the frame of the edge before it, and its energy κ_j |e_j − m_j|² / 2. Frames are
parallel-transported along the strand from the clamp and then turned about their edges by twist angles ψ_j, with the
energy χ κ_j (ψ_j − ψ_{j−1})² / 2. Twist has no inertia: ψ is where torques about edges balance (Bergou et al. 2008,
"Discrete Elastic Rods", §5). One iteration a step follows it, Newton's but for a bound in place of the second
derivative (`torque`). That is below 0 where frames lag by more than a quarter turn, from where Newton's method
would go anywhere: strands would gain energy from nothing.

A rest vector that is carried along also exerts a force on the edge before the joint, and through the frames on all
edges before that: with the moments T_j = κ_j e_j × m_j and twist torques q_j the edge j feels

    T_j − T_{j+1} + q_j e_{j−1} / (1 + e_{j−1}·e_j) − q_{j+1} e_{j+1} / (1 + e_j·e_{j+1}).

Without that reaction the force is no gradient, and strands of many curls gain energy from nothing. It enters through
c̄, so that the matrix of the step stays as it is: by Euler's method that of the edges before the step. BDF2, which such
a delay would drive, takes it, with all rest shapes, from where the strand's motion leads its edges (`rod_lead`).

That is stable where the matrix is too stiff, not where it is too soft. An edge that tilts by δ alone twists its frame
by θ δ and turns the rests after it, χ κ θ² δ² / 2 and some κ θ² δ² / 2, of which c̄ that stays knows nothing. So an edge
is kept where it is led, ê, by the energy σ |e − ê|² / 2 (Hunter & Lange 2004, majorisation): of edges of unit length
that is the force F = σ ê, with τ the greater by σ. It is what steps ask for that are long against the time in which a
coil stretches (`rod_coils`).
"""

from __future__ import annotations

from ...constants import FOLD
from ...jit import device, inlined
from ...simd import broadcast, load, load3, sqrt, store, store3, where
from ...simd.turning import cosine_sine
from . import rod_lead
from .records import DAMPING, ROOT_TWIST, ROUNDING, STEP, TORSION
from .rod_frames import CLAMP, carried, cross, first_normal
from .rod_scratch import AXES, EDGE, FIRST_SEGMENT, INNOVATION, LOAD, PACK, REST_BEND, SEGMENT, STIFFNESS
from .rod_tension import firm_force, particle_gain

GREATEST_TWIST_CHANGE = 3.0
"""Radians that ψ changes by in a step at the most. Frames of coils that swing about turn by one and more; where they
lag, rests turn the wrong way, and strands gain energy."""
PRESSED, PRESSED_BY_TURN = 0.1, 2.0
"""Rigidity that keeps edges between the root and what a solid presses where they were, in units of κ, up to 1: that of
all, and of θ². A force of contact is found once a step, and what is curled goes on giving way to it for many, so that
without it curls that lean on solids twitch for ever."""
LEAST_FOLD = 1e-6
"""1 + e·e' of two edges below which parallel transport from one to the other has no direction."""

# between the iterations, these vectors of a segment are free
TARGET = LOAD
"""(3) What of m_j is across the edge before it, by the ψ before the step."""
PAST_TWIST = INNOVATION
"""ψ_{j−1} before the step."""
TWIST_OFFSET, TWIST_FACTOR, FOLD_RATE = range(3)
"""a and b of ψ_{j−1} = a + b ψ_j, from the elimination; 1 / (1 + e_{j−1}·e_j). In place of the particles' gains."""


@device
def set_rest(s, at, state, material, forcing, scheme):
    """Set c̄ to the rest shape, by the edges that motion leads to or those before the step, and update the twist."""
    numbers = forcing.numbers
    transport_frames(s, at, state, material, forcing, scheme)
    share = 1 / (1 + numbers[DAMPING] / numbers[STEP])
    rigid = numbers[TORSION], load(forcing.firmness, at.strand)
    add_reactions(s, at, state, material, rigid, share, scheme.pressed)


@inlined
def torque(x, y, v, w):
    """Torque about the edge before a joint by its bend, over κ, and how fast it may fall with ψ at the most. x, y: the
    edge along the two axes of the frame; v, w: its rest.

    At an angle φ from balance the energy is −ρ cos φ. Of all parabolas that touch it there and are nowhere below it,
    the flattest has the second derivative ρ sin φ / φ and is lowest at φ = 0 (de Leeuw & Lange 2009, "Sharp quadratic
    majorization in one dimension"); sin φ / φ is at most (2 + cos φ) / 3 (Cusa and Huygens).
    """
    f, g = v * y - w * x, v * x + w * y
    return f, (2.0 * sqrt(f * f + g * g) + g) * (1.0 / 3.0)


@device
def transport_frames(s, at, state, material, forcing, scheme):
    """Set edges as `first_edge` has them, and transport frames along them from the root to the tip: set `TARGET` by the
    ψ before the step, and eliminate the torques about edges, linear in ψ."""
    torsion = forcing.numbers[TORSION]
    n, bend, bends, joint = at.segments, at.bend, material.bends, material.joint
    tx, ty, tz = load3(s, CLAMP, 1)
    ax, ay, az = first_normal(forcing.pose, bends, bend)
    zero = broadcast(s, 0.0)
    angle = zero
    a = zero
    b = zero
    way, far = rod_lead.way_of(s, at, forcing, scheme)
    for j in range(n):
        o = FIRST_SEGMENT + j * SEGMENT
        free = particle_gain(n, j)
        _, v, w = load3(bends, bend + (j + 1) * AXES, PACK)
        c, d = cosine_sine(angle)
        bx, by, bz = ty * az - tz * ay, tz * ax - tx * az, tx * ay - ty * ax
        (ex, ey, ez), far = first_edge(at, j, state, way, far, forcing.numbers[ROUNDING], scheme.share > 0)
        store3(s, o + EDGE, 1, ex, ey, ez)
        f, g = ax * ex + ay * ey + az * ez, bx * ex + by * ey + bz * ez
        v, w = v * c - w * d, v * d + w * c
        turn, stiff = torque(f, g, v, w)
        store3(s, o + TARGET, 1, v * ax + w * bx, v * ay + w * by, v * az + w * bz)
        if j > 0:
            before = torsion * (joint[j - 1] if j > 1 else forcing.numbers[ROOT_TWIST])
            after = torsion * joint[j] if j + 1 < n else 0.0
            stiff = joint[j] * stiff
            over = 1.0 / (before * (1.0 - b) + after + stiff)
            a = (joint[j] * turn + stiff * angle + before * a) * over
            b = after * over
            store(s, free + TWIST_OFFSET, a)
            store(s, free + TWIST_FACTOR, b)
        store(s, o + PAST_TWIST, angle)
        angle = load(state.twist, at.tension + j * PACK)
        rate = 1.0 / max(1.0 + tx * ex + ty * ey + tz * ez, LEAST_FOLD)
        store(s, free + FOLD_RATE, rate)
        ax, ay, az = carried(ax, ay, az, (rate * (tx + ex), rate * (ty + ey), rate * (tz + ez)), (ex, ey, ez))
        tx = ex
        ty = ey
        tz = ez


@inlined
def first_edge(at, j, state, way, far, rounding, led):
    """The edge that a step's rest shapes are set by, and how far its end is led, where the step is BDF2's."""
    if led:
        return rod_lead.led_edge(at, j, state, way, far, rounding)
    return load3(state.edges, at.edge + j * AXES, PACK), far


@device
def add_reactions(s, at, state, material, rigid, share, pressed):
    """From the tip to the root: set the new ψ, and add rest vectors by it to c̄, with their reaction on edges before,
    and set the forces that keep edges where they are led. ``rigid``: torsion and firmness; ``share``: of κ, that of
    the material without damping; ``pressed``: as in `Scheme`."""
    n, joint = at.segments, material.joint
    torsion, firm = rigid
    firm = firm * share * load(s, STIFFNESS)
    zero = broadcast(s, 0.0)
    sx, sy, sz = zero, zero, zero  # κ (m − e) of the joint after
    nx, ny, nz = zero, zero, zero  # the edge after it
    bx, by, bz = zero, zero, zero  # sum of the forces on edges so far
    after = zero  # q / (1 + e·e') of the joint after
    angle = zero
    turn_after = zero  # κ θ² of the joint after
    leaning = zero > 0.0
    ex, ey, ez = load3(s, FIRST_SEGMENT + (n - 1) * SEGMENT + EDGE, 1)
    for j in range(n - 1, -1, -1):
        o = FIRST_SEGMENT + j * SEGMENT
        free = particle_gain(n, j)
        px, py, pz = load3(s, o - SEGMENT + EDGE, 1)
        past = load(s, o + PAST_TWIST)
        now = zero
        q = zero
        if j > 0:
            now = load(s, free + TWIST_OFFSET) + load(s, free + TWIST_FACTOR) * angle
            now = past + min(max(now - past, -GREATEST_TWIST_CHANGE), GREATEST_TWIST_CHANGE)
            store(state.twist, at.tension + (j - 1) * PACK, now)
        rate = min(load(s, free + FOLD_RATE), 1.0 / FOLD)
        if j + 1 < n:
            q = (torsion * joint[j]) * (now - angle)
        q = q * rate
        angle = now
        # moment and twist torque of the joint after, and the twist torque of this one
        fx, fy, fz = cross(ex, ey, ez, after * nx - q * px, after * ny - q * py, after * nz - q * pz)
        f = sx * ex + sy * ey + sz * ez
        g = 1.0 - (nx * ex + ny * ey + nz * ez)
        bx += fx + f * (nx - ex) + g * sx
        by += fy + f * (ny - ey) + g * sy
        bz += fz + f * (nz - ez) + g * sz
        # this joint's rest vector
        bend = at.bend + (j + 1) * AXES
        (x, y, z), square = rest_vector(s, o, (px, py, pz), now - past, load(material.bends, bend))
        f = joint[j]
        sx, sy, sz = f * (x + px - ex), f * (y + py - ey), f * (z + pz - ez)
        turn = f * square
        f = firm * (turn + turn_after)
        store3(s, firm_force(n, j), 1, f * ex, f * ey, f * ez)
        store(s, firm_force(n, j) + 3, f)
        if pressed:
            f = joint[j] * min(PRESSED + PRESSED_BY_TURN * square, 1.0)
            leaning = keep_pressed(s, at, j, state, load(s, STIFFNESS) * f, leaning)
        turn_after = turn
        f = share / joint[j]
        store3(s, o + REST_BEND, 1, share * x + f * bx, share * y + f * by, share * z + f * bz)
        nx, ny, nz = ex, ey, ez
        ex, ey, ez = px, py, pz
        after = q


@inlined
def is_pressed(at, j, state):
    """Whether solids press particle j."""
    x, y, z = load3(state.push, at.edge + j * AXES, PACK)
    return abs(x) + abs(y) + abs(z) > 0.0


@device
def keep_pressed(s, at, j, state, rigidity, beyond):
    """Add the force that keeps edge j where it was before the step, of ``rigidity``, in lanes where solids press its
    end or, as ``beyond`` says, a particle after that. Return ``beyond`` of the edge before."""
    pressed = beyond | is_pressed(at, j, state)
    f = where(pressed, rigidity, broadcast(s, 0.0))
    x, y, z = load3(state.edges, at.edge + j * AXES, PACK)
    o = firm_force(at.segments, j)
    u, v, w = load3(s, o, 1)
    store3(s, o, 1, u + f * x, v + f * y, w + f * z)
    store(s, o + 3, load(s, o + 3) + f)
    return pressed


@inlined
def rest_vector(s, o, before, turned, along):
    """The rest vector of the joint at place o, after the edge ``before``, whose frame has ``turned`` by an angle, and
    the square of what is across that edge; ``along``: what is along it."""
    px, py, pz = before
    x, y, z = load3(s, o + TARGET, 1)
    c, d = cosine_sine(turned)
    wx, wy, wz = cross(px, py, pz, x, y, z)
    square = x * x + y * y + z * z
    return (along * px + c * x + d * wx, along * py + c * y + d * wy, along * pz + c * z + d * wz), square
