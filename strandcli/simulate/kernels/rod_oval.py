"""Oval sections: the torque of a bend, and how rests are corrected by a step's first solution (`rod_curl`)."""

from __future__ import annotations

from ...jit import device, inlined
from ...simd import any_lane, broadcast, load, load3, store, store3
from .records import DAMPING, ROUNDING, SOFT, STEP
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
"""Bend along the thin axis, which is in place of the particle's gain, by the edges that set the rest; then by how much
that of the first solution is more."""
SLIGHT = 1e-4
"""Greatest change of a strand's bends along the thin axes, over the greatest of these, that is left out."""


@inlined
def torque(e, wide, thin, v, w, soft, slope):
    """Torque about the edge before a joint by the bend of an oval section, over κ, and how it falls with ψ. v, w: the
    rest along both axes; ``slope``: `WIDE_SLOPE`, −1, or 1 where nothing but bends tells ψ, as of straight strands on
    hinges: Newton's method would overshoot there and energy grow, and the bound of the fall, σ (x² + y²), is taken."""
    x = e[0] * wide[0] + e[1] * wide[1] + e[2] * wide[2]
    y = e[0] * thin[0] + e[1] * thin[1] + e[2] * thin[2]
    return v * y - (w + soft * (y - w)) * x, v * x + (1.0 - soft) * w * y + soft * (y * y + slope * (x * x))


@device
def correct(s, n, joint, numbers):
    """Correct rests of oval sections by the bends along the thin axes that the first solution has led to, and set the
    loads to what that changes of those of the solution, which have none left. Returns False where it is left out, as
    the changes are `SLIGHT` in all lanes."""
    if not any_lane(change_bends(s, n, numbers[ROUNDING])):
        return False
    zero = broadcast(s, 0.0)
    share = numbers[SOFT] / (1 + numbers[DAMPING] / numbers[STEP])
    stiffness = load(s, STIFFNESS)
    after = zero, zero, zero, zero
    x, y, z = after, after, after
    for j in range(n - 1, -1, -1):
        o = FIRST_SEGMENT + j * SEGMENT
        u, v, w = load3(s, particle_gain(n, j), 1)
        f = share * load(s, o + BEND)
        u, v, w = f * u, f * v, f * w
        cx, cy, cz = load3(s, o + REST_BEND, 1)
        store3(s, o + REST_BEND, 1, cx + u, cy + v, cz + w)
        k = stiffness * joint[j]
        i, f, g = load(s, o + INVERSE_PIVOT), load(s, o + EDGE_FACTOR), load(s, o + PARTICLE_FACTOR)
        x = add_load(s, o, k * u, (i, f, g), x)
        y = add_load(s, o + 1, k * v, (i, f, g), y)
        z = add_load(s, o + 2, k * w, (i, f, g), z)
    return True


@inlined
def change_bends(s, n, rounding):
    """Set each `BEND` to its change, and return the lanes in which these count."""
    most = broadcast(s, 0.0)
    changed = most
    px, py, pz = load3(s, FIRST_SEGMENT - SEGMENT + EDGE, 1)
    for j in range(n):
        o = FIRST_SEGMENT + j * SEGMENT
        x, y, z = load3(s, o + EDGE, 1)
        u, v, w = load3(s, particle_gain(n, j), 1)
        bend = load(s, o + BEND)
        change = u * (x - px) + v * (y - py) + w * (z - pz) - bend
        store(s, o + BEND, change)
        most = max(most, abs(bend))
        changed = max(changed, abs(change))
        px, py, pz = x, y, z
    return changed > SLIGHT * most + rounding


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
