"""The start of a rod's step: its coefficients, edges as they are before anything else has moved, and u*."""

from __future__ import annotations

from ...jit import device, inlined
from ...simd import load, load3, store, store3
from .records import AIR, DAMPING, DRAG, GRAVITY, STEP
from .rod import AXES, FALL, FIRST, OVER, PACK, PRESS, REST, SEGMENT, SHIFT, STIFF, C, D, E, T

FARTHEST = 1e10


@device
def free_displacement(numbers):
    """How far an acceleration of 1 m/s² takes a free particle in a step, metres."""
    h = numbers[STEP]
    return h * h / (1 + numbers[DRAG] * h)


@device
def start(s, at, state, material, forcing, scheme):
    """Fill the scratch, in units of a segment, with edges as they are when the root alone has moved. Internal damping
    pulls each joint to the bend that it had."""
    # one pass: what long strands read here comes from far
    numbers = forcing.numbers
    h = numbers[STEP]
    length = load(material.lengths, at.strand)
    over = 1.0 / length
    store(s, OVER, over)
    drag = numbers[DRAG] * h
    store(s, REST, h / (1 + drag) * over)
    store(s, PRESS, free_displacement(numbers) / length)
    for c in range(3):
        store(s, FALL + c, h * numbers[GRAVITY + c] + drag * numbers[AIR + c] * load(forcing.gust, at.strand))
    damping = numbers[DAMPING] / h
    store(s, STIFF, load(material.stiffness, at.strand) * (h * h * (1 + damping)))
    share = damping / (1 + damping)
    x0, y0, z0 = load3(s, FIRST - SEGMENT + E, 1)
    for j in range(at.segments):
        o = FIRST + j * SEGMENT
        row = at.edge + j * AXES
        store(s, o + T, load(state.tension, at.tension + j * PACK) * (h * h))
        x, y, z = load3(state.edges, row, PACK)
        store3(s, o + E, 1, x, y, z)
        store3(s, o + C, 1, share * (x - x0), share * (y - y0), share * (z - z0))
        x0 = x
        y0 = y
        z0 = z
        x, y, z = predict(s, row, state, scheme)
        store3(s, o + D, 1, x, y, z)
    for c in range(3):
        store(s, FIRST + E + c, load(s, FIRST + E + c) - load(s, SHIFT + c) * over)


@inlined
def predict(s, row, state, scheme):
    """u* of a particle, in units of a segment: its free displacement, at most `FARTHEST`, and what the forces of
    contact of the step before add.

    BDF2 is an Euler step of h = 2/3 Δt from extrapolated values: x̂ = x_n + (x_n − x_{n−1}) / 3, v̂ likewise.
    """
    # computed anew where it is needed: it would take more scratch than it takes time
    x = predict_along(s, row, 0, state, scheme)
    y = predict_along(s, row, 1, state, scheme)
    z = predict_along(s, row, 2, state, scheme)
    return x, y, z


@inlined
def predict_along(s, row, c, state, scheme):
    """Coordinate c of `predict`."""
    place = row + c * PACK
    rest = load(s, REST)
    v = load(state.velocity, place)
    if scheme.second:
        v += (v - load(state.before, place)) * scheme.third
        u = load(state.moved, place) * scheme.third * load(s, OVER) + rest * (v + load(s, FALL + c))
    else:
        u = rest * (v + load(s, FALL + c))
    u = min(max(u, -FARTHEST), FARTHEST)
    if scheme.pressed:
        u += load(s, PRESS) * load(state.push, place)
    return u
