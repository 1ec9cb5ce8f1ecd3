"""Oval sections: the torque of a bend, and how rests are corrected by a step's first solution (`rod_curl`)."""

from __future__ import annotations

from ...jit import device, inlined
from ...simd import broadcast, load, load3, store, store3
from .records import DAMPING, SOFT, STEP
from .rod_scratch import (
    EDGE,
    EDGE_FACTOR,
    FIRST_SEGMENT,
    INNOVATION,
    INVERSE_PIVOT,
    LOAD,
    PARTICLE_FACTOR,
    REST_BEND,
    SEGMENT,
    STIFFNESS,
)
from .rod_tension import particle_gain

BEND = INNOVATION
"""Bend along the thin axis, which is in place of the particle's gain, by the edges that set the rest."""


@inlined
def torque(e, wide, thin, v, w, soft):
    """Torque about the edge before a joint by the bend of an oval section, over κ, and how it falls with ψ. v, w: the
    rest along both axes."""
    x = e[0] * wide[0] + e[1] * wide[1] + e[2] * wide[2]
    y = e[0] * thin[0] + e[1] * thin[1] + e[2] * thin[2]
    return v * y - (w + soft * (y - w)) * x, v * x + (1.0 - soft) * w * y + soft * (y * y - x * x)


@device
def correct(s, n, joint, numbers):
    """Correct rests of oval sections by the bends along the thin axes that the first solution has led to, and set the
    loads to what that changes of those of the solution, which have none left."""
    zero = broadcast(s, 0.0)
    share = numbers[SOFT] / (1 + numbers[DAMPING] / numbers[STEP])
    stiffness = load(s, STIFFNESS)
    ex, ey, ez = load3(s, FIRST_SEGMENT + (n - 1) * SEGMENT + EDGE, 1)
    after = zero, zero, zero, zero
    x, y, z = after, after, after
    for j in range(n - 1, -1, -1):
        o = FIRST_SEGMENT + j * SEGMENT
        px, py, pz = load3(s, o - SEGMENT + EDGE, 1)
        u, v, w = load3(s, particle_gain(n, j), 1)
        f = share * (u * (ex - px) + v * (ey - py) + w * (ez - pz) - load(s, o + BEND))
        u, v, w = f * u, f * v, f * w
        cx, cy, cz = load3(s, o + REST_BEND, 1)
        store3(s, o + REST_BEND, 1, cx + u, cy + v, cz + w)
        k = stiffness * joint[j]
        i, f, g = load(s, o + INVERSE_PIVOT), load(s, o + EDGE_FACTOR), load(s, o + PARTICLE_FACTOR)
        x = add_load(s, o, k * u, (i, f, g), x)
        y = add_load(s, o + 1, k * v, (i, f, g), y)
        z = add_load(s, o + 2, k * w, (i, f, g), z)
        ex, ey, ez = px, py, pz


@inlined
def add_load(s, o, less, pivot, after):
    """Set the load of a coordinate, the first one of the segment at place o, by that of which its joint's bend becomes
    ``less``. ``pivot``: i, i κ and i B; ``after``: p, q, b and f of the segment after it, as in `rod_elimination`;
    returns the same of this one."""
    p, q, bend, force = after
    i, f, g = pivot
    own = -less - bend
    p -= force - own
    sum = p + q
    store(s, o + LOAD, i * sum)
    return p - g * sum, f * sum, -less, own
