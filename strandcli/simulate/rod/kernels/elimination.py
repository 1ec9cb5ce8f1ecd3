"""Factorisation of H by elimination, and the right-hand side, both swept from the tip of a strand to its root.

The change of tension that the Kalman smoother finds (`tension`) takes the same direction, and comes first at each
segment: one chain of divisions computes while another waits, and what they read comes through the caches once.
"""

from __future__ import annotations

from ....jit import device, inlined
from ....simd import any_lane, load, store, where
from . import tension

MASS_SHARE = 0.9 / 4
"""θ/4: the share of the mass that compression may use up in H."""
MARGIN = 0.5
"""H counts as definite where its pivots keep this share of the mass."""


@device
def factorise(s, n, material, stiffness, changed, touching, whole, kept):
    """Set the pivots of H and the loads for the present τ, or where ``changed``, for the τ and the forces of contact
    that `tension.filter_forward` leads to. Lanes where H is indefinite take a bounded τ in it; those where ``kept`` is
    above 0 keep the pivots that there are. Returns where H is indefinite, above 0."""
    zero = stiffness * 0.0
    lost = sweep_to_root(s, n, material, stiffness, changed, True, touching, whole, (zero, kept))
    if any_lane(lost > 0.0):
        sweep_to_root(s, n, material, stiffness, False, True, touching, whole, (lost, kept))
    return lost


@device
def update_loads(s, n, material, stiffness, changed, touching, whole):
    """Set the loads of the present edges, τ and forces with the pivots that there are, after they have ``changed`` as
    `factorise` says."""
    zero = stiffness * 0.0
    sweep_to_root(s, n, material, stiffness, changed, False, touching, whole, (zero, zero))


@device
def sweep_to_root(s, n, material, stiffness, changed, factored, touching, whole, lanes):
    """Sweep from the tip to the root: change τ and forces where ``changed``, factorise H where ``factored``, set the
    loads. ``lanes``: those where τ is bounded in H, and those that keep their pivots, above 0. Returns 1 in lanes with
    a pivot that is too small; it is raised, in a definite H without harm; else those before run away.

    Loads: the residual is ρ_j = M_j (u*_j − u_j) − f_j + f_{j+1} with f_j = τ_j e_j − F_j + b_j − b_{j+1}, b_j = κ_j
    (c_j − c̄_j), where the edge before the first is the clamped direction, and F_j = σ ê_j of curled strands."""
    zero = stiffness * 0.0
    none = zero, zero, zero
    bounded, kept = lanes
    some_kept = any_lane(kept > 0.0)
    ahead = none, none, (zero, zero)
    lost = zero
    a, b, c = none
    p, q, bend, force = none, none, none, none
    for j in range(n - 1, -1, -1):
        if changed:
            ahead = tension.smooth_backward(s, j, ahead, material.mass, touching, whole)
        t = load(s.tension, j)
        mass = material.mass[j]
        k = stiffness * material.joint[j]
        if factored:
            least = -MASS_SHARE * min(material.mass[max(j - 1, 0)], mass)
            held = where(bounded > 0.0, max(t, least), t)
            a += mass
            g = a + b
            rigid = g + b + c + held
            raised = max(MARGIN * mass - k, rigid)
            lost = where(rigid >= raised, lost, 1.0)
            i = 1.0 / (raised + k)
            f = k * i
            h = g * i
            a -= g * h
            b = k * h
            c = raised * f
            if some_kept:
                i = where(kept > 0.0, load(s.pivot, j), i)
                f = where(kept > 0.0, load(s.edge_factor, j), f)
                h = where(kept > 0.0, load(s.particle_factor, j), h)
            store(s.pivot, j, i)
            store(s.edge_factor, j, f)
            store(s.particle_factor, j, h)
        x = set_load(s, j, 0, t, mass, k, (p[0], q[0], bend[0], force[0]))
        y = set_load(s, j, 1, t, mass, k, (p[1], q[1], bend[1], force[1]))
        z = set_load(s, j, 2, t, mass, k, (p[2], q[2], bend[2], force[2]))
        p = x[0], y[0], z[0]
        q = x[1], y[1], z[1]
        bend = x[2], y[2], z[2]
        force = x[3], y[3], z[3]
    return lost


@inlined
def set_load(s, j, c, tension, mass, stiffness, after):
    """Set coordinate c of the load g of segment j. ``after``: p and q of V, b and f of the segment after it. Returns
    the same of this one."""
    p, q, bend, force = after
    edge = load(s.edge, 3 * j + c)
    b = stiffness * (edge - load(s.edge, 3 * j - 3 + c) - load(s.rest, 3 * j + c))
    f = tension * edge + (b - bend) - load(s.firm, 4 * j + c)
    p -= mass * load(s.inertial, 3 * j + c) + (force - f)
    sum = p + q
    store(s.load, 3 * j + c, load(s.pivot, j) * sum)
    return p - load(s.particle_factor, j) * sum, load(s.edge_factor, j) * sum, b, f
