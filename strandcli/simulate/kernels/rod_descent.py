"""What goes from the tip of a strand to its root: the change of tension, the pivots of H, and loads.

Each of the three is a chain in which a segment waits for the one after it, for a division, too. The first two go
together, and in long strands all three, so that what they need comes through the caches once. In short ones, which the
nearest cache holds, loads go by themselves, a coordinate at a time: all that is carried along is then in registers.
"""

from __future__ import annotations

from ...jit import inlined, inner
from ...simd import get, put, root, some, spread, where
from . import rod_dense, rod_long
from .rod import DI, FIRST, HARD, N1, N2, SEGMENT, A, C, E, G, K, M, T, U

QUARTER = 0.9 / 4
"""θ/4: the share of the mass that compression may use up in H."""
BEAM = 0.7
"""The share of √(M κ) that it may: what buckles a beam with a free end on an elastic foundation (Hetényi 1946), the
same all along."""
BRIEF = 40
"""Segments up to which strands count as short here: the nearest cache has room for half as many."""
MARGIN = 0.5
"""H counts as definite where its pivots keep this share of the mass."""


@inner
def settle(s, n, long, changed):
    """The pivots of H and the loads G of a τ that is ``changed`` before, where that is not None, by what `rod_dense` or
    `rod_long` has prepared. Lanes where τ makes H indefinite take the bounded τ instead; returns whether there are
    any."""
    put(s, HARD, 0.0)
    lost = bring(s, n, long, changed, False)
    hard = some(lost > 0.0)
    if hard:
        bound(s, n, lost)
        bring(s, n, long, None, None)
    return hard


@inner
def factor(s, n):
    """The pivots of H alone; returns whether τ had to be bounded in any lane."""
    put(s, HARD, 0.0)
    lost = descend(s, n, None, None, False, None)
    hard = some(lost > 0.0)
    if hard:
        bound(s, n, lost)
    return hard


@inner
def bring(s, n, long, changed, factored):
    """`descend` with loads, in one pass or two."""
    if long is None:
        lost = descend(s, n, long, changed, factored, None)
        load(s, n)
    elif n > BRIEF:
        lost = descend(s, n, long, changed, factored, True)
    else:
        lost = descend(s, n, long, changed, factored, None)
        load(s, n)
    return lost


@inner
def load(s, n):
    """G alone, coordinate by coordinate, with the pivots that there are."""
    for c in range(3):
        p = spread(s, 0.0)
        q, bend, force = p, p, p
        for j in range(n - 1, -1, -1):
            o = FIRST + j * SEGMENT
            p, q, bend, force = bear(s, o, c, get(s, o + T), p, q, bend, force)


@inner
def bound(s, n, lost):
    """The pivots of H again, with bounded τ where they were lost. Row HARD marks such lanes, by 2 where the bound is
    what masses alone resist."""
    put(s, HARD, lost)
    still = descend(s, n, None, None, True, None)
    if some(still > 0.0):
        put(s, HARD, lost + still)
        descend(s, n, None, None, True, None)


@inner
def descend(s, n, long, changed, factored, loaded):
    """From the tip to the root: τ, then i, i κ and i B, and then G; each of the last three arguments is None for a pass
    without.

    Elimination: ``factored`` tells whether τ is bounded in lanes that row HARD marks. Returns 1 in lanes with a pivot
    that is too small, which is raised. Of a definite H that does no harm; of another, what lies before it has pivots
    that run away to −∞.

    Loads: the residual is ρ_j = M_j (u*_j − u_j) − f_j + f_{j+1} with f_j = τ_j e_j + b_j − b_{j+1} and
    b_j = κ_j (c_j − c̄_j), where the edge before the first is the clamped direction.
    """
    zero = spread(s, 0.0)
    none = zero, zero, zero
    mean = none, none
    lost = zero
    a, b, c = none
    p, q, bend, force = none, none, none, none
    for j in range(n - 1, -1, -1):
        o = FIRST + j * SEGMENT
        if changed is not None:
            if long is None:
                change = rod_dense.substitute(s, n, j)
            else:
                change, mean = rod_long.recall(s, n, j, mean)
            put(s, o + T, get(s, o + T) + change)
        t = get(s, o + T)
        if factored is not None:
            mass = get(s, o + M)
            k = get(s, o + K)
            held = t
            if factored:
                held = bounded(s, o, t, mass, k)
            a += mass
            g = a + b
            stiff = g + b + c + held
            raised = max(MARGIN * mass - k, stiff)
            lost = where(stiff >= raised, lost, 1.0)
            i = 1.0 / (raised + k)
            f = k * i
            h = g * i
            put(s, o + DI, i)
            put(s, o + N1, f)
            put(s, o + N2, h)
            a -= g * h
            b = k * h
            c = raised * f
        if loaded is not None:
            x = bear(s, o, 0, t, p[0], q[0], bend[0], force[0])
            y = bear(s, o, 1, t, p[1], q[1], bend[1], force[1])
            z = bear(s, o, 2, t, p[2], q[2], bend[2], force[2])
            p = x[0], y[0], z[0]
            q = x[1], y[1], z[1]
            bend = x[2], y[2], z[2]
            force = x[3], y[3], z[3]
    return lost


@inlined
def bounded(s, o, t, mass, k):
    """τ, and in marked lanes no less than H can bear."""
    given = get(s, HARD)
    light = min(get(s, o - SEGMENT + M), mass)
    least = -QUARTER * light
    beam = min(least, -BEAM * root(light * k))
    return where(given > 0.0, max(t, where(given > 1.0, least, beam)), t)


@inlined
def bear(s, o, c, t, p, q, bend, force):
    """Coordinate c of a segment's load, from what the segments after it leave: p and q of V, b and f of the next."""
    edge = get(s, o + E + c)
    b = get(s, o + K) * (edge - get(s, o - SEGMENT + E + c) - get(s, o + C + c))
    f = t * edge + (b - bend)
    p -= get(s, o + M) * (get(s, o + A + c) - get(s, o + U + c)) + (force - f)
    sum = p + q
    put(s, o + G + c, get(s, o + DI) * sum)
    return p - get(s, o + N2) * sum, get(s, o + N1) * sum, b, f
