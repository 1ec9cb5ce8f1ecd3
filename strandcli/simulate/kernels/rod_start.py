"""The start of a rod's step: its coefficients, edges as they are before anything else has moved, and u*."""

from __future__ import annotations

from ...jit import device, inlined
from ...simd import load, load3, store, store3
from .rod import AXES, FALL, FIRST, OVER, PACK, PRESS, REST, SEGMENT, SHIFT, STIFF, C, D, E, T

FARTHEST = 1e10


@device
def alone(numbers):
    """How far an acceleration of 1 m/s² takes a particle in a step that nothing else holds, in m."""
    h = numbers[0]
    return h * h / (1 + numbers[7] * h)


@device
def start(
    s, n, edge, tip, strand, edges, tension, velocity, before, moved, push, lengths, stiffness, gust, numbers, second,
    pressed,
):  # fmt: skip
    """Fill the scratch, in units of a segment: edges are as they are when the root has moved and nothing else. Internal
    damping pulls each joint to the bend that it had. All in one pass: of long strands, what it reads comes from far."""
    h = numbers[0]
    length = load(lengths, strand)
    over = 1.0 / length
    store(s, OVER, over)
    drag = numbers[7] * h
    store(s, REST, h / (1 + drag) * over)
    store(s, PRESS, alone(numbers) / length)
    for c in range(3):
        store(s, FALL + c, h * numbers[1 + c] + drag * numbers[4 + c] * load(gust, strand))
    damping = numbers[8] / h
    store(s, STIFF, load(stiffness, strand) * (h * h * (1 + damping)))
    share = damping / (1 + damping)
    x0, y0, z0 = load3(s, FIRST - SEGMENT + E, 1)
    for j in range(n):
        o = FIRST + j * SEGMENT
        row = edge + j * AXES
        store(s, o + T, load(tension, tip + j * PACK) * (h * h))
        x, y, z = load3(edges, row, PACK)
        store3(s, o + E, 1, x, y, z)
        store3(s, o + C, 1, share * (x - x0), share * (y - y0), share * (z - z0))
        x0 = x
        y0 = y
        z0 = z
        x, y, z = wish(s, row, velocity, before, moved, push, numbers[9], second, pressed)
        store3(s, o + D, 1, x, y, z)
    for c in range(3):
        store(s, FIRST + E + c, load(s, FIRST + E + c) - load(s, SHIFT + c) * over)


@inlined
def wish(s, row, velocity, before, moved, push, third, second, pressed):
    """u* of a particle, in units of a segment: where it would go alone, and no further than `FARTHEST`, and where
    ``pressed`` by the force that contact had in the step before. Scratch that kept it would be more than it takes.

    BDF2 is an Euler step of h = 2/3 Δt from extrapolated values: x̂ = x_n + (x_n − x_{n−1}) / 3, v̂ likewise.
    """
    x = wish_along(s, row, 0, velocity, before, moved, push, third, second, pressed)
    y = wish_along(s, row, 1, velocity, before, moved, push, third, second, pressed)
    z = wish_along(s, row, 2, velocity, before, moved, push, third, second, pressed)
    return x, y, z


@inlined
def wish_along(s, row, c, velocity, before, moved, push, third, second, pressed):
    """Coordinate c of it."""
    place = row + c * PACK
    rest = load(s, REST)
    v = load(velocity, place)
    if second:
        v += (v - load(before, place)) * third
        u = load(moved, place) * third * load(s, OVER) + rest * (v + load(s, FALL + c))
    else:
        u = rest * (v + load(s, FALL + c))
    u = min(max(u, -FARTHEST), FARTHEST)
    if pressed:
        u += load(s, PRESS) * load(push, place)
    return u
