"""What goes from the tip of a strand to its root: the change of tension, the pivots of H, and loads.

Each of the three is a chain in which a segment waits for the one after it, for a division, too. They go together, so
that one has something to do while another waits, and what they need comes through the caches once.
"""

from __future__ import annotations

from ...jit import device, inlined
from ...simd import any_lane, broadcast, load, sqrt, store, where
from . import rod_tension
from .rod import DI, FIRST, HARD, N1, N2, SEGMENT, STIFF, C, D, E, G, T

QUARTER = 0.9 / 4
"""θ/4: the share of the mass that compression may use up in H."""
BEAM = 0.7
"""The share of √(M κ) that it may: what buckles a beam with a free end on an elastic foundation (Hetényi 1946), the
same all along."""
MARGIN = 0.5
"""H counts as definite where its pivots keep this share of the mass."""


@device
def settle(s, n, mass, joint, changed):
    """The pivots of H and the loads G of a τ that is ``changed`` before, where that is not None, by what
    `rod_tension` has prepared. Lanes where τ makes H indefinite take the bounded τ instead; returns whether there are
    any."""
    store(s, HARD, 0.0)
    lost = descend(s, n, mass, joint, changed, False, None)
    hard = any_lane(lost > 0.0)
    if hard:
        store(s, HARD, lost)
        bound(s, n, mass, joint)
    return hard


@device
def bound(s, n, mass, joint):
    """Pivots and loads with bounded τ in the lanes that row HARD marks, by 2 where the bound is what masses alone
    resist."""
    still = descend(s, n, mass, joint, None, True, None)
    if any_lane(still > 0.0):
        store(s, HARD, load(s, HARD) + still)
        descend(s, n, mass, joint, None, True, None)


@device
def foretell(s, n, mass, joint):
    """The loads of a changed τ with the pivots that there are; row HARD marks lanes where H will be indefinite with
    that τ. Returns whether there are any."""
    lost = descend(s, n, mass, joint, True, None, True)
    store(s, HARD, lost)
    return any_lane(lost > 0.0)


@device
def descend(s, n, mass, joint, changed, factored, judged):
    """From the tip to the root: τ, then i, i κ and i B, and then G; ``changed`` and ``factored`` are None for a pass
    without that.

    Elimination: ``factored`` tells whether τ is bounded in lanes that row HARD marks. Returns 1 in lanes with a pivot
    that is too small, which is raised. Of a definite H that does no harm; of another, what lies before it has pivots
    that run away to −∞. Where ``judged`` is not None that is all that comes of it, and loads are for the pivots that
    there are.

    Loads: the residual is ρ_j = M_j (u*_j − u_j) − f_j + f_{j+1} with f_j = τ_j e_j + b_j − b_{j+1} and
    b_j = κ_j (c_j − c̄_j), where the edge before the first is the clamped direction.
    """
    zero = broadcast(s, 0.0)
    none = zero, zero, zero
    ahead = none, none, (zero, zero)
    lost = zero
    a, b, c = none
    p, q, bend, force = none, none, none, none
    stiff = load(s, STIFF)
    for j in range(n - 1, -1, -1):
        o = FIRST + j * SEGMENT
        if changed is not None:
            change, ahead = rod_tension.recall(s, n, j, ahead)
            store(s, o + T, load(s, o + T) + change)
        t = load(s, o + T)
        k = stiff * joint[j]
        if factored is not None or judged is not None:
            held = t
            if factored is not None and factored:
                held = bounded(s, t, min(mass[max(j - 1, 0)], mass[j]), k)
            a += mass[j]
            g = a + b
            rigid = g + b + c + held
            raised = max(MARGIN * mass[j] - k, rigid)
            lost = where(rigid >= raised, lost, 1.0)
            i = 1.0 / (raised + k)
            f = k * i
            h = g * i
            if factored is not None:
                store(s, o + DI, i)
                store(s, o + N1, f)
                store(s, o + N2, h)
            a -= g * h
            b = k * h
            c = raised * f
        x = bear(s, o, 0, t, mass[j], k, p[0], q[0], bend[0], force[0])
        y = bear(s, o, 1, t, mass[j], k, p[1], q[1], bend[1], force[1])
        z = bear(s, o, 2, t, mass[j], k, p[2], q[2], bend[2], force[2])
        p = x[0], y[0], z[0]
        q = x[1], y[1], z[1]
        bend = x[2], y[2], z[2]
        force = x[3], y[3], z[3]
    return lost


@inlined
def bounded(s, t, light, k):
    """τ, and in marked lanes no less than H can bear between particles of which the lighter one is that ``light``."""
    given = load(s, HARD)
    least = broadcast(s, -QUARTER * light)
    beam = min(least, -BEAM * sqrt(light * k))
    return where(given > 0.0, max(t, where(given > 1.0, least, beam)), t)


@inlined
def bear(s, o, c, t, mass, k, p, q, bend, force):
    """Coordinate c of a segment's load, from what the segments after it leave: p and q of V, b and f of the next."""
    edge = load(s, o + E + c)
    b = k * (edge - load(s, o - SEGMENT + E + c) - load(s, o + C + c))
    f = t * edge + (b - bend)
    p -= mass * load(s, o + D + c) + (force - f)
    sum = p + q
    store(s, o + G + c, load(s, o + DI) * sum)
    return p - load(s, o + N2) * sum, load(s, o + N1) * sum, b, f
