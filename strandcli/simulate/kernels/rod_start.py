"""The start of a rod's step: coefficients of the strand, edges where the root alone has moved, and u*."""

from __future__ import annotations

from ...jit import device, inlined
from ...simd import load, load3, store, store3
from .records import AIR, DAMPING, DRAG, GRAVITY, STEP, VELOCITY_STEP
from .rod_scratch import (
    ACCELERATION_SCALE,
    ADDED_VELOCITY,
    AXES,
    EDGE,
    FIRST_SEGMENT,
    INERTIAL,
    INVERSE_LENGTH,
    PACK,
    REST_BEND,
    ROOT_SHIFT,
    SEGMENT,
    STIFFNESS,
    TENSION,
    VELOCITY_SCALE,
)

BLEND = 0.8
"""θ: share of BDF3 in the difference formula of velocities, the rest is BDF2. Two such steps, BDF2 for displacements
and this for velocities, lose (1 − θ) / 8 (ω h)⁴ of an oscillation's amplitude a step, and are unconditionally stable up
to θ = 1."""
VELOCITY_RATE = 1.5 + BLEND / 3
"""Δt over the h of velocities."""
GAIN = (0.5 + 2 * BLEND / 3) / VELOCITY_RATE
OLD_GAIN = BLEND / 3 / VELOCITY_RATE
"""Shares of the last change of velocity that v̂ goes on by, and of the one before it that it stays behind by."""
FARTHEST = 1e10
"""Segments that a free particle moves in a step at the most."""


@device
def free_displacement(numbers):
    """Displacement of a free particle by an acceleration of 1 m/s² in a step, metres."""
    h = numbers[VELOCITY_STEP]
    return numbers[STEP] * h / (1 + numbers[DRAG] * h)


@device
def fill_scratch(s, at, state, material, forcing, scheme):
    """Set the strand's coefficients, and of each segment edge, u*, τ and what damping adds to c̄. The first edge gives
    way for the root, which alone has moved; `ROOT_SHIFT` and the edge before the first have been set.

    Damping pulls each joint toward the bend that it had: it multiplies κ by 1 + δ/h and adds δ/h κ c to κ c̄.
    """
    # one pass, since the state of long strands comes from far
    numbers = forcing.numbers
    h = numbers[VELOCITY_STEP]
    square = numbers[STEP] * h
    length = load(material.lengths, at.strand)
    inverse_length = 1.0 / length
    store(s, INVERSE_LENGTH, inverse_length)
    drag = numbers[DRAG] * h
    store(s, VELOCITY_SCALE, numbers[STEP] / (1 + drag) * inverse_length)
    store(s, ACCELERATION_SCALE, free_displacement(numbers) / length)
    for c in range(3):
        store(s, ADDED_VELOCITY + c, h * numbers[GRAVITY + c] + drag * numbers[AIR + c] * load(forcing.gust, at.strand))
    damping = numbers[DAMPING] / numbers[STEP]
    store(s, STIFFNESS, load(material.stiffness, at.strand) * (square * (1 + damping)))
    share = damping / (1 + damping)
    px, py, pz = load3(s, FIRST_SEGMENT - SEGMENT + EDGE, 1)
    for j in range(at.segments):
        o = FIRST_SEGMENT + j * SEGMENT
        row = at.edge + j * AXES
        store(s, o + TENSION, load(state.tension, at.tension + j * PACK) * square)
        x, y, z = load3(state.edges, row, PACK)
        store3(s, o + EDGE, 1, x, y, z)
        store3(s, o + REST_BEND, 1, share * (x - px), share * (y - py), share * (z - pz))
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
    return x, y, z


@inlined
def predict_along(s, row, c, state, scheme):
    """Coordinate c of `predict`."""
    place = row + c * PACK
    scale, added = load(s, VELOCITY_SCALE), load(s, ADDED_VELOCITY + c)
    v = load(scheme.velocity, place) + added
    if scheme.crowded:
        v += scheme.duration * load(state.crowd, place)
    u = scale * v
    if scheme.share > 0:
        u += load(state.moved, place) * scheme.share * load(s, INVERSE_LENGTH)
    u = min(max(u, -FARTHEST), FARTHEST)
    if scheme.pressed:
        u += load(s, ACCELERATION_SCALE) * load(state.push, place)
    return u
