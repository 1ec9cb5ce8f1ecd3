"""How a strand gives way to a change of the forces of contact on it, and how much more of that change it needs.

The mobility by which `contact_forces` scales depths knows of no lengths. Of a strand that stands on its tip it says
that the tip rises as soon as it is pushed, though all of the strand has to bow for that. So where particles stay deep
the strand is asked: the response u to a change a of accelerations, with edges that keep their lengths, is one step of
Newton's method from forces alone. What is wanted are displacements w, and

    α = Σ M a·w / Σ M a·u

times the change is the steepest descent of the dual problem with its exact line search (Nocedal & Wright 2006, §3.3).
Where that has gone too far, as where a straight strand buckles, the work Σ M a·w has become negative, and its zero is
bracketed along the change in the rounds that follow. Only pressures are searched for; friction follows them, and would
be lost where one of them is too small for a round.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from ...jit import device, inlined
from ...simd import broadcast, load, load3, sqrt, store, store3, where
from . import rod, rod_tension
from .contact_spots import lengthen_spot, spot_of
from .rod_scratch import (
    ACCELERATION_SCALE,
    AXES,
    BEYOND,
    CONTACT_WORK,
    EDGE,
    EDGE_FACTOR,
    FIRST_SEGMENT,
    FIRST_WORK,
    INVERSE_LENGTH,
    INVERSE_PIVOT,
    LOAD,
    PARTICLE_FACTOR,
    REACHED,
    SEGMENT,
    WIDTH,
)
from .rod_tension import force_change, particle_gain
from .vectors import add_scaled, dot, scaled, sum_of

MOST = 16.0
"""Greatest α: strands that are taut hardly respond."""
BOW = 0.5
"""Greatest change of an edge, in lengths of it, that a response may predict: of what is linear, no more holds."""
FAIR = 0.5
"""Share of the work at which a search along a change ends."""
LOST = 1e-3
"""Error of |e|² with which iterations have not found lengths."""
NARROW = 0.05
"""Width of a bracket, as a share of the first, at which its search ends: what strands do may jump."""
LEAST = 0.1
"""Least share of the way to the end of a bracket that a secant may name; it is averaged with the middle."""


class Along(NamedTuple):
    """A search along the last change of pressures, in some lanes."""

    going: Any
    """In which lanes."""
    move: Any
    """By what share of the change to go on, or back if below 0; 0 in other lanes."""
    kept: Any
    """What share of the change lies between the ends of the bracket, and is the change from now on."""


@inlined
def nowhere(s):
    """A search in no lane."""
    zero = broadcast(s, 0.0)
    return Along(zero < zero, zero, zero)


@device
def begin(s):
    """Begin a step: no change has gone too far."""
    store(s, CONTACT_WORK, 0.0)
    store(s, BEYOND, 0.0)


@device
def bracket(s, n, mass, worst):
    """Return where, and how, to search along the last change (`Along`), from what it has left of the work. ``worst``:
    error of |e|² after it; a change for which iterations find no lengths has gone too far."""
    begun, beyond, left = load(s, CONTACT_WORK), load(s, BEYOND), broadcast(s, 0.0)
    for j in range(n):
        left += mass[j] * dot(load3(s, force_change(n, j), 1), load3(s, particle_gain(n, j), 1))
    left = where(worst > LOST, -begun, load(s, INVERSE_LENGTH) * left)
    bracketed = (beyond < 0.0) & (load(s, WIDTH) > NARROW)
    reached = where(bracketed, load(s, REACHED), 1.0)
    width = where(bracketed, load(s, WIDTH), 1.0)
    fair = FAIR * where(bracketed, load(s, FIRST_WORK), begun)
    over = (begun > 0.0) & (left < -fair)
    under = bracketed & (left > fair)
    going = over | under
    kept = where(over, reached, where(under, 1.0 - reached, 1.0))
    store(s, FIRST_WORK, kept / FAIR * fair)
    store(s, WIDTH, kept * width)
    begun = kept * where(under, left, begun)
    beyond = kept * where(over, left, beyond)
    secant = min(max(begun / max(begun - beyond, rod.TINY), LEAST), 1.0)
    share = 0.5 * (secant + 0.5)
    store(s, CONTACT_WORK, begun)
    store(s, BEYOND, where(going, beyond, 0.0))
    store(s, REACHED, share)
    return Along(going, where(over, share - 1.0, where(under, share, 0.0)), kept)


@device
def lengthen(s, at, state, mass, along):
    """Take the change of pressures of this round α times, but in lanes that go ``along`` the one before. Pressures do
    not become negative."""
    n, work = at.segments, load(s, CONTACT_WORK)
    respond(s, n, mass)
    given = responded(s, n, mass)
    most = min(BOW / sqrt(rod.greatest_change_squared(s, n)), MOST)
    able = ~along.going & (work > 0.0) & (given > 0.0)
    more = where(able, max(min(work / max(given, rod.TINY), most), 1.0) - 1.0, 0.0)
    store(s, CONTACT_WORK, (1.0 + more) * work)
    for j in range(n):
        lengthen_spot(s, spot_of(n, j, at.edge + j * AXES), state.push, more)


@device
def respond(s, n, mass):
    """Set loads so that back substitution gives the response to the last change of pressures."""
    zero = broadcast(s, 0.0)
    none = zero, zero, zero
    p, q = none, none
    for j in range(n - 1, -1, -1):
        p = add_scaled(p, -mass[j], pushed(s, n, j))
        p, q = set_load(s, FIRST_SEGMENT + j * SEGMENT, p, q)
    rod_tension.filter_forward(s, n, mass, True, None, None)
    p, q, force = none, none, none
    ahead = none, none, (zero, zero)
    for j in range(n - 1, -1, -1):
        o = FIRST_SEGMENT + j * SEGMENT
        change, ahead = rod_tension.smooth_backward(s, n, j, ahead)
        pull = scaled(change, load3(s, o + EDGE, 1))
        p = add_scaled(add_scaled(sum_of(p, pull), -1.0, force), -mass[j], pushed(s, n, j))
        p, q = set_load(s, o, p, q)
        force = pull


@inlined
def pushed(s, n, j):
    """The displacement by which the change of pressure would move the particle of segment j if it were free."""
    return scaled(load(s, ACCELERATION_SCALE), load3(s, force_change(n, j), 1))


@inlined
def set_load(s, o, p, q):
    """Set the load of the segment at place o; returns p and q of V before it (`rod`)."""
    sum = sum_of(p, q)
    x, y, z = scaled(load(s, o + INVERSE_PIVOT), sum)
    store3(s, o + LOAD, 1, x, y, z)
    return add_scaled(p, -load(s, o + PARTICLE_FACTOR), sum), scaled(load(s, o + EDGE_FACTOR), sum)


@device
def responded(s, n, mass):
    """Σ M a·u of each lane, by back substitution."""
    zero = broadcast(s, 0.0)
    x, y, z = zero, zero, zero
    u, v, w = zero, zero, zero
    total = zero
    for j in range(n):
        x, y, z = rod.edge_change(s, FIRST_SEGMENT + j * SEGMENT, x, y, z, u, v, w)
        u, v, w = u + x, v + y, w + z
        total += mass[j] * dot((u, v, w), load3(s, force_change(n, j), 1))
    return total
