"""Oval sections: the torque of a bend, and how rests are corrected by a step's first solution (`rod_curl`)."""

from __future__ import annotations

from ...jit import device, inlined
from ...simd import any_lane, broadcast, load, load3, sqrt, store, store3, where
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
from .rod_tension import TINY, particle_gain

BEND = INNOVATION
"""Bend along the thin axis, which is in place of the particle's gain, by the edges that set the rest; then by how much
that of the first solution is more."""
FAR = 0.3
"""Error of |e|² above which an edge of the first solution counts as one of unit length."""
SLIGHT = 1e-4
"""Greatest change of a strand's bends along the thin axes, over the greatest of these, that is left out."""


@inlined
def torque(x, y, v, w, soft):
    """Torque about the edge before a joint by its bend, over κ, and how fast it may fall with ψ at the most. x, y: the
    edge along the wide and the thin axis; v, w: its rest; ``soft``: σ, None of round sections.

    At an angle φ from balance the energy of a round section is −ρ cos φ. Of all parabolas that touch it there and are
    nowhere below it, the flattest has the second derivative ρ sin φ / φ and is lowest at φ = 0 (de Leeuw & Lange 2009,
    "Sharp quadratic majorization in one dimension"); sin φ / φ is at most (2 + cos φ) / 3 (Cusa and Huygens). What σ
    adds, −σ y² / 2, is a cosine of twice the angle, of which √(V''² + 4 V'²) is the greatest V''.
    """
    if soft is None:
        f, g = v * y - w * x, v * x + w * y
        return f, (2.0 * sqrt(f * f + g * g) + g) * (1.0 / 3.0)
    f = v * y - (w + soft * (y - w)) * x
    g = v * x + (1.0 - soft) * (w * y) + soft * (y * y - x * x)
    return f, sqrt(g * g + 4.0 * (f * f))


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
        x, y, z = of_unit_length(load3(s, o + EDGE, 1))
        u, v, w = load3(s, particle_gain(n, j), 1)
        bend = load(s, o + BEND)
        change = u * (x - px) + v * (y - py) + w * (z - pz) - bend
        store(s, o + BEND, change)
        most = max(most, abs(bend))
        changed = max(changed, abs(change))
        px, py, pz = x, y, z
    return changed > SLIGHT * most + rounding


@inlined
def of_unit_length(edge):
    """An edge of the first solution, which of a strand that is flung about may be a million times too long: what it
    says of bends then is its direction."""
    x, y, z = edge
    q = x * x + y * y + z * z
    far = abs(q - 1.0) > FAR
    if any_lane(far):
        f = where(far, 1.0 / sqrt(max(q, TINY)), 1.0)
        x, y, z = f * x, f * y, f * z
    return x, y, z


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
