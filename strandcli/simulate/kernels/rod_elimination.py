"""Factorisation of H by elimination, and the right-hand side, both swept from the tip of a strand to its root.

The change of tension that the Kalman smoother finds (`rod_tension`) takes the same direction. Each of the three is a
chain in which a segment waits for a division of the one after it. One sweep does all three, so that one chain computes
while another waits, and what they read comes through the caches once.
"""

from __future__ import annotations

from ...jit import device, inlined
from ...simd import any_lane, broadcast, load, load3, sqrt, store, where
from . import rod_tension
from .rod_scratch import (
    EDGE,
    EDGE_FACTOR,
    FIRST_SEGMENT,
    INDEFINITE,
    INERTIAL,
    INVERSE_PIVOT,
    LOAD,
    PARTICLE_FACTOR,
    REST_BEND,
    SEGMENT,
    STIFFNESS,
    TENSION,
)

MASS_SHARE = 0.9 / 4
"""θ/4: the share of the mass that compression may use up in H."""
BEAM_SHARE = 0.7
"""The share of √(M κ) that it may: what buckles a beam with a free end on an elastic foundation (Hetényi 1946), where
joints and masses are the same all along."""
MARGIN = 0.5
"""H counts as definite where its pivots keep this share of the mass."""


@device
def factorise(s, n, mass, joint, curled, changed):
    """Set the pivots of H and the loads for the present τ, or where ``changed`` is not None for the τ that
    `rod_tension.filter_forward` leads to. Lanes where H is indefinite take the bounded τ instead; returns whether there
    are any."""
    store(s, INDEFINITE, 0.0)
    lost = sweep_to_root(s, n, mass, joint, curled, changed, False, None)
    indefinite = any_lane(lost > 0.0)
    if indefinite:
        store(s, INDEFINITE, lost)
        factorise_bounded(s, n, mass, joint, curled)
    return indefinite


@device
def factorise_bounded(s, n, mass, joint, curled):
    """Set pivots and loads with bounded τ in `INDEFINITE` lanes; lanes that are indefinite even so are marked by 2, and
    get the stricter bound of masses alone."""
    still = sweep_to_root(s, n, mass, joint, curled, None, True, None)
    if any_lane(still > 0.0):
        store(s, INDEFINITE, load(s, INDEFINITE) + still)
        sweep_to_root(s, n, mass, joint, curled, None, True, None)


@device
def change_tension(s, n, mass, joint, curled):
    """Change τ as `rod_tension.filter_forward` leads to, and set the loads with the pivots that there are. Marks lanes
    in `INDEFINITE` where the new τ makes H indefinite; returns whether there are any."""
    lost = sweep_to_root(s, n, mass, joint, curled, True, None, True)
    store(s, INDEFINITE, lost)
    return any_lane(lost > 0.0)


@device
def set_loads(s, n, mass, joint, curled):
    """Set the loads of the present edges and τ with the pivots that there are."""
    sweep_to_root(s, n, mass, joint, curled, None, None, None)


@device
def sweep_to_root(s, n, mass, joint, curled, changed, bounded, judged):
    """Sweep from the tip to the root: change τ where ``changed``, factorise H where ``bounded`` is not None, and set
    the loads. Returns 1 in lanes with a pivot that is too small.

    What is None is compiled out. ``bounded``: whether τ is bounded in `INDEFINITE` lanes. ``judged``: pivots are judged
    and not stored. A pivot that is too small is raised: in a definite H without harm; else those before run away.

    Loads. The residual is ρ_j = M_j (u*_j − u_j) − f_j + f_{j+1} with f_j = τ_j e_j − F_j + b_j − b_{j+1}, b_j = κ_j
    (c_j − c̄_j), where the edge before the first is the clamped direction, and F_j what keeps edges where they are led.
    """
    zero = broadcast(s, 0.0)
    none = zero, zero, zero
    ahead = none, none, (zero, zero)
    lost = zero
    a, b, c = none
    p, q, bend, force = none, none, none, none
    stiffness = load(s, STIFFNESS)
    for j in range(n - 1, -1, -1):
        o = FIRST_SEGMENT + j * SEGMENT
        if changed is not None:
            change, ahead = rod_tension.smooth_backward(s, n, j, ahead)
            store(s, o + TENSION, load(s, o + TENSION) + change)
        t = load(s, o + TENSION)
        k = stiffness * joint[j]
        if bounded is not None or judged is not None:
            held = t
            if bounded is not None and bounded:
                held = bounded_tension(s, t, min(mass[max(j - 1, 0)], mass[j]), k)
            a += mass[j]
            g = a + b
            rigid = g + b + c + held
            raised = max(MARGIN * mass[j] - k, rigid)
            lost = where(rigid >= raised, lost, 1.0)
            i = 1.0 / (raised + k)
            f = k * i
            h = g * i
            if bounded is not None:
                store(s, o + INVERSE_PIVOT, i)
                store(s, o + EDGE_FACTOR, f)
                store(s, o + PARTICLE_FACTOR, h)
            a -= g * h
            b = k * h
            c = raised * f
        fx, fy, fz = firm_force_at(s, n, j, curled)
        x = set_load(s, o, 0, t, mass[j], k, (p[0], q[0], bend[0], force[0]), fx)
        y = set_load(s, o, 1, t, mass[j], k, (p[1], q[1], bend[1], force[1]), fy)
        z = set_load(s, o, 2, t, mass[j], k, (p[2], q[2], bend[2], force[2]), fz)
        p = x[0], y[0], z[0]
        q = x[1], y[1], z[1]
        bend = x[2], y[2], z[2]
        force = x[3], y[3], z[3]
    return lost


@inlined
def firm_force_at(s, n, j, curled):
    """The force that keeps edge j where motion leads it; none on strands that are not curled."""
    zero = broadcast(s, 0.0)
    x, y, z = zero, zero, zero
    if curled:
        x, y, z = load3(s, rod_tension.firm_force(n, j), 1)
    return x, y, z


@inlined
def bounded_tension(s, tension, light, stiffness):
    """τ, raised in `INDEFINITE` lanes to what H bears between particles of which the lighter has the mass ``light``."""
    given = load(s, INDEFINITE)
    by_mass = broadcast(s, -MASS_SHARE * light)
    by_beam = min(by_mass, -BEAM_SHARE * sqrt(light * stiffness))
    return where(given > 0.0, max(tension, where(given > 1.0, by_mass, by_beam)), tension)


@inlined
def set_load(s, o, c, tension, mass, stiffness, after, firm):
    """Set coordinate c of the load g of the segment at place o. ``after``: p and q of V, b and f of the segment after
    it; ``firm``: what keeps the edge where it is led. Returns the same of this one."""
    p, q, bend, force = after
    edge = load(s, o + EDGE + c)
    b = stiffness * (edge - load(s, o - SEGMENT + EDGE + c) - load(s, o + REST_BEND + c))
    f = tension * edge + (b - bend) - firm  # as of straight strands to the bit where firm is 0
    p -= mass * load(s, o + INERTIAL + c) + (force - f)
    sum = p + q
    store(s, o + LOAD + c, load(s, o + INVERSE_PIVOT) * sum)
    return p - load(s, o + PARTICLE_FACTOR) * sum, load(s, o + EDGE_FACTOR) * sum, b, f
