"""The start of a rod's step: coefficients of the strand, edges where the root alone has moved, and u*."""

from __future__ import annotations

from ...jit import device, inlined
from ...simd import any_lane, broadcast, load, load3, store, store3, where
from .records import AIR, CHANGED, DAMPING, DRAG, GRAVITY, LASTING, STEP, VELOCITY_STEP
from .rod_scratch import (
    ACCELERATION_SCALE,
    ADDED_VELOCITY,
    AXES,
    CROWD_CHANGE,
    CROWD_STEP,
    EDGE,
    FIRST_SEGMENT,
    INERTIAL,
    INVERSE_LENGTH,
    INVERSE_STEP,
    MOVED_SHARE,
    PACK,
    REACH,
    REST_BEND,
    ROOT_SHIFT,
    SEGMENT,
    SQUARE,
    STIFFNESS,
    TENSION,
    VELOCITY_SCALE,
)
from .rod_tension import firm_force

BLEND = 0.8
"""θ: share of BDF3 in the difference formula of velocities, the rest is BDF2. Two such steps, BDF2 for displacements
and this for velocities, lose (1 − θ) / 4 (ω Δt)⁴ of an oscillation's amplitude a step, and are stable at any step."""
VELOCITY_RATE = 1.5 + BLEND / 3
"""Δt over the h of velocities."""
GAIN = (0.5 + 2 * BLEND / 3) / VELOCITY_RATE
OLD_GAIN = BLEND / 3 / VELOCITY_RATE
"""Shares of the last change of velocity that v̂ goes on by, and of the one before it that it stays behind by."""
FARTHEST = 1e10
"""Segments that a free particle moves in a step at the most."""


@device
def set_coefficients(s, at, state, material, forcing, scheme):
    """Set the strand's coefficients in the scratch, by the method of each lane: Euler's in those that are `disturbed`,
    where BDF2 would go on with what has changed."""
    numbers = forcing.numbers
    h, g = numbers[STEP], numbers[VELOCITY_STEP]
    mass = 1 + numbers[DRAG] * g  # that `Material.mass` has been multiplied by
    if scheme.mixed and scheme.share > 0:
        calm = disturbed(s, state, at.strand, scheme.crowded, scheme.pressed, scheme.curled, numbers) > 0.0
        step = where(calm, broadcast(s, scheme.duration), h)
        velocity_step = where(calm, broadcast(s, scheme.duration), g)
        drag = 1.0 + numbers[DRAG] * velocity_step
        square = where(calm, step * velocity_step * (mass / drag), h * g)
        store(s, MOVED_SHARE, where(calm, broadcast(s, 0.0), scheme.share))
        store_coefficients(s, at, material, forcing, step, velocity_step, drag, square)
        if scheme.crowded:
            set_steps_of_crowd(s, velocity_step, numbers[LASTING], scheme)
    else:
        store(s, MOVED_SHARE, scheme.share)
        if scheme.crowded:
            set_steps_of_crowd(s, broadcast(s, g), numbers[LASTING], scheme)
        store_coefficients(s, at, material, forcing, h, g, mass, h * g)


@inlined
def set_steps_of_crowd(s, g, lasting, scheme):
    """Set how the strands around accelerate particles, from the h of velocities ``g``. What a grid gives changes the
    velocity that the step begins with, and BDF2 goes on without it. What contact gives, as ``lasting`` says, has the h
    of BDF2, as gravity has; in lanes that go by Euler's method BDF2 will go on without it, too."""
    whole = broadcast(s, scheme.duration)
    if lasting > 0 and scheme.share > 0:
        store(s, CROWD_STEP, g)
        store(s, CROWD_CHANGE, where(load(s, MOVED_SHARE) > 0.0, broadcast(s, 0.0), whole))
    else:
        store(s, CROWD_STEP, whole)
        store(s, CROWD_CHANGE, whole)


@inlined
def disturbs(s, state, strand, crowded, pressed, curled, numbers):
    """Whether some strand of a vector is `disturbed`."""
    if crowded is None and not (pressed or curled):
        return False
    return any_lane(disturbed(s, state, strand, crowded, pressed, curled, numbers) > 0.0)


@inlined
def disturbed(s, state, strand, crowded, pressed, curled, numbers):
    """Above 0 where a strand takes the step by Euler's method: one that is `State.jolted`, `State.calmed` where strands
    are ``curled``, or that solids press anew or no more; among strands that press each other any that solids press, for
    what these find knows solids of the step before, and may leave the strand to them at any time. ``pressed``: whether
    some of the vector are."""
    found = broadcast(s, 0.0)
    if crowded is not None:
        found = load(state.jolted, strand)
    if pressed:
        least = 0.0 if numbers[LASTING] > 0.0 else 0.5 * CHANGED
        found = max(found, load(state.touching, strand) - least)
    if curled:
        found = max(found, load(state.calmed, strand))
    return found


@inlined
def store_coefficients(s, at, material, forcing, h, g, drag, square):
    """Store what follows from the h of displacements, s, that of velocities, what drag makes of a mass, and h², s²;
    numbers, or vectors where lanes differ."""
    numbers = forcing.numbers
    length = load(material.lengths, at.strand)
    reach = h * g / drag
    store(s, INVERSE_LENGTH, 1.0 / length)
    store(s, VELOCITY_SCALE, h / (drag * length))
    store(s, ACCELERATION_SCALE, reach / length)
    store(s, REACH, reach)
    store(s, SQUARE, square)
    store(s, INVERSE_STEP, 1.0 / h)
    air = numbers[DRAG] * load(forcing.gust, at.strand)
    for c in range(3):
        store(s, ADDED_VELOCITY + c, g * (numbers[GRAVITY + c] + air * numbers[AIR + c]))
    store(s, STIFFNESS, load(material.stiffness, at.strand) * (square * (1 + numbers[DAMPING] / numbers[STEP])))


@device
def fill_scratch(s, at, state, material, forcing, scheme):
    """Set the strand's coefficients, and of each segment edge, u*, τ and what damping adds to c̄. The edge before the
    first has been set.

    Damping pulls each joint toward the bend that it had: it multiplies κ by 1 + δ/Δt and adds δ/Δt κ c to κ c̄.
    """
    # one pass, since the state of long strands comes from far
    damping = forcing.numbers[DAMPING] / forcing.numbers[STEP]
    square = load(s, SQUARE)
    share = damping / (1 + damping)
    px, py, pz = load3(s, FIRST_SEGMENT - SEGMENT + EDGE, 1)
    for j in range(at.segments):
        o = FIRST_SEGMENT + j * SEGMENT
        row = at.edge + j * AXES
        t = load(state.tension, at.tension + j * PACK) * square
        if scheme.curled:
            t += load(s, firm_force(at.segments, j) + 3)
        store(s, o + TENSION, t)
        x, y, z = load3(state.edges, row, PACK)
        store3(s, o + EDGE, 1, x, y, z)
        cx, cy, cz = share * (x - px), share * (y - py), share * (z - pz)
        if scheme.curled:  # what `rod_curl.set_rest` has left
            u, v, w = load3(s, o + REST_BEND, 1)
            cx, cy, cz = cx + u, cy + v, cz + w
        store3(s, o + REST_BEND, 1, cx, cy, cz)
        px = x
        py = y
        pz = z
        x, y, z = predict(s, row, state, scheme)
        store3(s, o + INERTIAL, 1, x, y, z)


@device
def give_way(s):
    """Have the first edge give way for the root, which has moved by `ROOT_SHIFT`."""
    for c in range(3):
        edge = load(s, FIRST_SEGMENT + EDGE + c)
        store(s, FIRST_SEGMENT + EDGE + c, edge - load(s, ROOT_SHIFT + c) * load(s, INVERSE_LENGTH))


@inlined
def predict(s, row, state, scheme):
    """u* of a particle in segments: its free displacement, at most `FARTHEST`, that by the forces of contact of the
    step before, and that by the strands around. ``row``: place of its x in (P, N, 3 S).

    BDF2 is an Euler step of h = 2/3 Δt from extrapolated values: x̂ = x_n + (x_n − x_{n−1}) / 3, and v̂, which the step
    before has left (`rod_sweep.update_velocity`).
    """
    # computed anew where it is needed: to keep it would cost more, by the room that it takes in the scratch
    x = predict_along(s, row, 0, state, scheme)
    y = predict_along(s, row, 1, state, scheme)
    z = predict_along(s, row, 2, state, scheme)
    if scheme.pressed:
        px, py, pz = load3(state.push, row, PACK)
        scale = load(s, ACCELERATION_SCALE)
        x += scale * px
        y += scale * py
        z += scale * pz
    return x, y, z


@inlined
def predict_along(s, row, c, state, scheme):
    """Coordinate c of the free displacement, by the method of the step or of its lane."""
    place = row + c * PACK
    scale, added = load(s, VELOCITY_SCALE), load(s, ADDED_VELOCITY + c)
    if scheme.crowded:
        added += load(s, CROWD_STEP) * load(state.crowd, place)
    if scheme.share > 0:
        v = load(state.ahead, place)
        if scheme.mixed:
            v = where(load(s, MOVED_SHARE) > 0.0, v, load(state.velocity, place))
        u = scale * (v + added) + load(state.moved, place) * load(s, MOVED_SHARE) * load(s, INVERSE_LENGTH)
    else:
        u = scale * (load(state.velocity, place) + added)
    return min(max(u, -FARTHEST), FARTHEST)
