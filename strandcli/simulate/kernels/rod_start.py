"""The start of a rod's step: coefficients of the strand, edges where the root alone has moved, and u*."""

from __future__ import annotations

from ...jit import device, inlined
from ...simd import load, load3, store, store3
from .records import AIR, DAMPING, DRAG, GRAVITY, STEP
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

FARTHEST = 1e10
"""Segments that a free particle moves in a step at the most."""


@device
def free_displacement(numbers):
    """Displacement of a free particle by an acceleration of 1 m/s² in a step, metres."""
    h = numbers[STEP]
    return h * h / (1 + numbers[DRAG] * h)


@device
def fill_scratch(s, at, state, material, forcing, scheme):
    """Set the strand's coefficients, and of each segment edge, u*, τ and what damping adds to c̄. The first edge gives
    way for the root, which alone has moved; `ROOT_SHIFT` and the edge before the first have been set.

    Damping pulls each joint toward the bend that it had: it multiplies κ by 1 + δ/h and adds δ/h κ c to κ c̄.
    """
    # one pass, since the state of long strands comes from far
    numbers = forcing.numbers
    h = numbers[STEP]
    length = load(material.lengths, at.strand)
    inverse_length = 1.0 / length
    store(s, INVERSE_LENGTH, inverse_length)
    drag = numbers[DRAG] * h
    store(s, VELOCITY_SCALE, h / (1 + drag) * inverse_length)
    store(s, ACCELERATION_SCALE, free_displacement(numbers) / length)
    for c in range(3):
        store(s, ADDED_VELOCITY + c, h * numbers[GRAVITY + c] + drag * numbers[AIR + c] * load(forcing.gust, at.strand))
    damping = numbers[DAMPING] / h
    store(s, STIFFNESS, load(material.stiffness, at.strand) * (h * h * (1 + damping)))
    share = damping / (1 + damping)
    px, py, pz = load3(s, FIRST_SEGMENT - SEGMENT + EDGE, 1)
    for j in range(at.segments):
        o = FIRST_SEGMENT + j * SEGMENT
        row = at.edge + j * AXES
        store(s, o + TENSION, load(state.tension, at.tension + j * PACK) * (h * h))
        x, y, z = load3(state.edges, row, PACK)
        store3(s, o + EDGE, 1, x, y, z)
        store3(s, o + REST_BEND, 1, share * (x - px), share * (y - py), share * (z - pz))
        px = x
        py = y
        pz = z
        x, y, z = predict(s, row, state, scheme)
        store3(s, o + INERTIAL, 1, x, y, z)
    for c in range(3):
        store(s, FIRST_SEGMENT + EDGE + c, load(s, FIRST_SEGMENT + EDGE + c) - load(s, ROOT_SHIFT + c) * inverse_length)


@inlined
def predict(s, row, state, scheme):
    """u* of a particle in segments: its free displacement, at most `FARTHEST`, that by the forces of contact of the
    step before, and that by the strands around. ``row``: place of its x in (P, N, 3 S).

    BDF2 is an Euler step of h = 2/3 Δt from extrapolated values: x̂ = x_n + (x_n − x_{n−1}) / 3, v̂ likewise.
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
    v = load(state.velocity, place)
    if scheme.second:
        v += (v - load(state.before, place)) * scheme.third
        u = load(state.moved, place) * scheme.third * load(s, INVERSE_LENGTH) + scale * (v + added)
    else:
        u = scale * (v + added)
    u = min(max(u, -FARTHEST), FARTHEST)
    if scheme.pressed:
        u += load(s, ACCELERATION_SCALE) * load(state.push, place)
    if scheme.crowded:
        u += load(s, ACCELERATION_SCALE) * load(state.crowd, place)
    return u
