"""Descent in lanes in which Newton's iterations have found no lengths: quadratic programming with a line search.

Such are strands whose ends are put elsewhere at once, or that are taut between ends that nothing moves. From edges of
unit length the step H⁻¹ρ that keeps them so to the first order, with a definite H (`rod_elimination`), is one along
which the energy falls (Nocedal & Wright 2006, §18.3), back on the unit spheres too. So it is halved until that is so,
and iterations cannot run away.

A pinned tip weighs so much that the second order of any step that counts would raise the energy. Its share of the
merit function goes on linearly from the distance at which its force is twice what the step leads to: an exact penalty
(§18.4).
"""

from __future__ import annotations

from ...jit import device, inlined
from ...simd import any_lane, broadcast, load, load3, sqrt, store, store3, where
from . import rod, rod_elimination, rod_newton, rod_start, rod_tension
from .records import ROUNDING, TOLERANCE
from .rod_scratch import (
    AXES,
    EDGE,
    EDGE_FACTOR,
    FIRST_SEGMENT,
    INDEFINITE,
    INERTIAL,
    INVERSE_LENGTH,
    INVERSE_PIVOT,
    PACK,
    PARTICLE_FACTOR,
    REST_BEND,
    ROOT_SHIFT,
    SEGMENT,
    STIFFNESS,
    TENSION,
)
from .rod_tension import firm_force, point, spare
from .vectors import add_scaled, dot, scaled, sum_of

LOST = 2e-3
"""Error of |e|² from which on iterations have found no lengths, of strands of up to `rod_newton.FINE` segments; of
longer ones in proportion, for single edges may be off there."""
WILLING = 50
"""Iterations that a scene has to allow for: one that allows for fewer is not given more of them."""
HALVINGS = 24
"""Times that a step is halved at the most."""
NOISE = 2e-6
"""Change of energy, as a share of the absolute values that it is the sum of, that is rounding."""
CERTAIN = 2.0
"""Force of the tip from which on the merit function is linear, over that which a step leads to."""
assert (EDGE, INERTIAL) == (0, 3)
assert (EDGE_FACTOR, PARTICLE_FACTOR) == (INVERSE_PIVOT + 1, INVERSE_PIVOT + 2)


@device
def mend(s, at, state, material, forcing, scheme, iterations, worst):
    """`descend` where iterations have left errors ``worst`` of |e|² beyond `LOST`, or what that is of long strands.
    Returns the errors."""
    least = LOST * max(1.0, at.segments / rod_newton.FINE)
    if iterations >= WILLING and any_lane(worst > least):
        worst = descend(s, at, state, material, forcing, scheme, iterations, worst, least)
    return worst


@device
def descend(s, at, state, material, forcing, scheme, iterations, worst, least):
    """Take the iterations of a step anew in lanes whose errors ``worst`` of |e|² are beyond the ``least``; others keep
    all that they have. Returns the errors."""
    lost = worst > least
    n, mass, joint, curled = at.segments, material.mass, material.joint, scheme.curled
    keep(s, n)
    begin(s, at, state, scheme, worst)
    found = where(lost, rod.GREATEST_ERROR, worst)
    going = lost
    for _ in range(max(iterations, 1)):
        rod_elimination.factorise_bounded(s, n, mass, joint, curled)
        rod_tension.filter_forward(s, n, mass, True, True, 4.0 * forcing.numbers[ROUNDING])
        rod_elimination.change_tension(s, n, mass, joint, curled)
        set_point(s, n)
        error, _ = rod.apply_change(s, n, None)
        found = where(going, error, found)
        advance(s, n, mass, joint, curled, going)
        going = going & (error > forcing.numbers[TOLERANCE])
        if not any_lane(going):
            break
    rod_elimination.factorise_bounded(s, n, mass, joint, curled)
    restore(s, n, lost)
    return found


@device
def advance(s, n, mass, joint, curled, going):
    """After a whole step from a point, take as much of it as lets the merit function fall, in the lanes that are
    ``going``; others stay."""
    step, fell = broadcast(s, 1.0), ~going
    tip = load3(s, FIRST_SEGMENT + (n - 1) * SEGMENT + INERTIAL, 1)
    firm = CERTAIN * mass[n - 1] * sqrt(dot(tip, tip)) + rod.TINY
    for count in range(HALVINGS):
        go_to_point(s, n)
        if count == HALVINGS - 1:
            step = where(fell, step, 0.0)
        rod.apply_change(s, n, where(going, step, 0.0))
        rod.retract(s, n, mass, joint, curled, going)
        fell = ~going | merit_falls(s, n, mass, joint, curled, firm)
        if not any_lane(~fell):
            break
        step = where(fell, step, 0.5 * step)


@device
def merit_falls(s, n, mass, joint, curled, firm):
    """In which lanes the merit function is no more than at the point, but for rounding. Twice the energies are compared
    by their changes, for free displacements may be many orders greater than strands are long. ``firm``: force from
    which on the tip's share is linear."""
    zero = broadcast(s, 0.0)
    stiffness = load(s, STIFFNESS)
    moved, change, before = (zero, zero, zero), (zero, zero, zero), load3(s, FIRST_SEGMENT - SEGMENT + EDGE, 1)
    before_then = before
    total, size = zero, zero
    for j in range(n):
        o = FIRST_SEGMENT + j * SEGMENT
        edge, then, rest = load3(s, o + EDGE, 1), load3(s, point(n, j) + EDGE, 1), load3(s, o + REST_BEND, 1)
        past, change = change, add_scaled(edge, -1.0, then)
        bends = sum_of(sum_of(edge, then), scaled(-1.0, sum_of(sum_of(before, before_then), scaled(2.0, rest))))
        of_joint = stiffness * joint[j] * dot(add_scaled(change, -1.0, past), bends)
        before, before_then = edge, then
        moved = sum_of(moved, change)
        was, now = load3(s, point(n, j) + INERTIAL, 1), load3(s, o + INERTIAL, 1)
        square = -dot(moved, sum_of(was, now))
        of_mass = mass[j] * square
        if j == n - 1:
            of_mass = of_tip(mass[j], square, sqrt(dot(was, was)), sqrt(dot(now, now)), firm)
        total += of_joint + of_mass
        size += abs(of_joint) + abs(of_mass)
        if curled:
            pulled = -2.0 * dot(load3(s, firm_force(n, j), 1), change)
            total += pulled
            size += abs(pulled)
    return total <= NOISE * size


@inlined
def of_tip(mass, square, was, now, firm):
    """Change of the tip's share of the merit function, from that of the ``square`` of its distance from where it would
    be free, which ``was`` and is ``now``."""
    edge = firm * (1.0 / mass)
    one, other = min(was, edge), min(now, edge)
    linear = 2.0 * firm * square / max(was + now, rod.TINY)
    mixed = mass * (other * other - one * one) + 2.0 * firm * (max(now - edge, 0.0) - max(was - edge, 0.0))
    far, near = (was > edge) & (now > edge), (was <= edge) & (now <= edge)
    return where(far, linear, where(near, mass * square, mixed))


@device
def begin(s, at, state, scheme, worst):
    """Begin with edges of unit length, those before the step where errors are ``worst`` than `rod.FAR`, and without
    tension."""
    near = worst < rod.FAR
    moved = scaled(load(s, INVERSE_LENGTH), load3(s, ROOT_SHIFT, 1))
    store(s, INDEFINITE, 0.0)
    for j in range(at.segments):
        o, row = FIRST_SEGMENT + j * SEGMENT, at.edge + j * AXES
        old, e = load3(state.edges, row, PACK), load3(s, o + EDGE, 1)
        f = 1.0 / sqrt(max(dot(e, e), rod.TINY))
        x, y, z = where(near, f * e[0], old[0]), where(near, f * e[1], old[1]), where(near, f * e[2], old[2])
        store3(s, o + EDGE, 1, x, y, z)
        moved = sum_of(moved, (x - old[0], y - old[1], z - old[2]))
        x, y, z = rod_start.predict(s, row, state, scheme)
        store3(s, o + INERTIAL, 1, x - moved[0], y - moved[1], z - moved[2])
        store(s, o + TENSION, 0.0)


@device
def keep(s, n):
    """Keep what the lanes have."""
    store(s, spare(n, n), load(s, INDEFINITE))
    for j in range(n):
        o, place = FIRST_SEGMENT + j * SEGMENT, spare(n, j)
        for c in range(6):
            store(s, place + c, load(s, o + c))
        store(s, place + 6, load(s, o + TENSION))
        for c in range(3):
            store(s, place + 7 + c, load(s, o + INVERSE_PIVOT + c))


@device
def restore(s, n, lost):
    """Give all lanes but the ``lost`` ones what `keep` has kept."""
    store(s, INDEFINITE, where(lost, load(s, INDEFINITE), load(s, spare(n, n))))
    for j in range(n):
        o, place = FIRST_SEGMENT + j * SEGMENT, spare(n, j)
        for c in range(6):
            store(s, o + c, where(lost, load(s, o + c), load(s, place + c)))
        store(s, o + TENSION, where(lost, load(s, o + TENSION), load(s, place + 6)))
        for c in range(3):
            store(s, o + INVERSE_PIVOT + c, where(lost, load(s, o + INVERSE_PIVOT + c), load(s, place + 7 + c)))


@device
def set_point(s, n):
    """Keep edges and inertial residuals as the point that a line search starts from."""
    for j in range(n):
        for c in range(6):
            store(s, point(n, j) + c, load(s, FIRST_SEGMENT + j * SEGMENT + c))


@device
def go_to_point(s, n):
    """Go back to the point."""
    for j in range(n):
        for c in range(6):
            store(s, FIRST_SEGMENT + j * SEGMENT + c, load(s, point(n, j) + c))
