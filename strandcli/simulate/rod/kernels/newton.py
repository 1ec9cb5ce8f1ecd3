"""Newton's iterations of a rod's step: the force densities τ, and the forces of contact with solids
(`docs/solvers.md`).

H(τ) y = ρ is solved for a change y, from a residual ρ made of differences, so that single precision is enough. The
pivots of a pentadiagonal stiff H come from numbers that grow as the fourth power of the segments, of which the masses
are the last digits. So what is eliminated, from the tip on, is not y_j but the change of an edge, z_j = y_j − y_{j−1},
given y_{j−1} and z_{j−1}: Bellman's recursion (1957) for the least energy that the strand beyond can have, V(y, z) = ½
a y² + b y z + ½ c z² + p·y + q·z. There rigidities are only ever added, and there is one difference, of which no more
is left than of masses:

    B = a + M + b,  Q = a + M + 2 b + c + τ,  i = 1 / (Q + κ),
    a' = a + M − i B²,  b' = i κ B,  c' = i κ Q,    and then, root to tip,  z_j = i κ z_{j−1} − i B y_{j−1} − g_j.

The change of tension that the Kalman smoother finds (`tension`) takes the same direction, and comes first at each
segment: one chain of divisions computes while another waits, and what they read comes through the caches once.

Where H(τ) is not positive definite it takes τ_j no lower than what M alone resists, −θ/4 min(M_{j−1}, M_j) (for |y_j −
y_{j−1}|² <= 2 |y_j|² + 2 |y_{j−1}|²); ρ has the true τ, and edges go back to unit length before each iteration.
"""

from __future__ import annotations

from ....jit import device, inlined
from ....jit.indices import FIRST, NO, SECOND, THIRD
from ....simd import any_lane, broadcast, load, load3, sqrt, store, store3, where
from ....simd.vectors import combined, dot, less, scaled, select, sum_of
from ...contact.kernels import find
from . import rest_shape, tension

MASS_SHARE = 0.9 / 4
"""θ/4: the share of the mass that compression may use up in H."""
DEFINITE = 0.5
"""H counts as definite where its pivots keep this share of the mass."""
FAR = 0.3
"""Error of |e|² above which edges return to unit length before the next iteration."""
TINY = 1e-30
GREATEST_ERROR = 1e18
"""Errors of |e|² are no more than this, and never NaN."""
FOLLOWED = 1e-8
"""Squared change of an edge in an iteration below which curved rest shapes have followed."""
MOST = 40
"""Iterations, at most: what has not converged then goes in parts."""
PATIENCE, LATE = 4, 10
"""Iterations from which on each doubles what errors may be left, and from which on little touches anew."""
FINE = 32
"""Segments beyond which a single wrong edge, as where contact kinks a strand, counts by its share of the strand."""
EVEN = 3.0
"""Ratio of the worst edge's error to the mean, which it hardly exceeds where all edges are wrong."""


@device
def iterate(s, at, state, material, step, needs, c, contact, root):
    """Solve for τ, forces and edges by Newton's method. Returns the greatest | |e|² − 1 | of each lane, the greatest
    depth in a solid, in segments, whether solids are near some strand, and how far an edge has changed at the most.

    Begins with x(τ) for the τ and the forces of the step before. Then come one iteration and more, up to
    ``step.iterations``, until all | |e|² − 1 | are below the tolerance, solids keep everything out and none pulls; in
    strands of more than `FINE` segments some edges may be off by more, where the mean of all is not. ``root``: the
    place of the root at the end of the step."""
    n, stiffness, whole = at.segments, c.stiffness, needs.segments
    touching = needs.solids and find.begin(s, at, state, material, c, needs)
    if needs.curled:
        rest_shape.begin(s, at, state, material, step, c)
    zero = indefinite = broadcast(s.pivot, 0.0)  # lanes whose H is not definite, or has not been in this step: above 0
    lost = factorise(s, n, material, stiffness, False, touching, whole, zero)
    worst, total, change = apply_change(s, n)
    depth, near, path = worst * 0.0, False, sqrt(change)
    single_share, mean_share = min(1.0, FINE / n), EVEN / n
    most = min(max(step.iterations, 1), MOST)
    for count in range(most + 1):
        late = count - PATIENCE
        patience = 2.0 ** max(late, 0)
        moved, unsettled = False, worst < 0.0
        if needs.solids:
            touching, moved, near, depth, unsettled = find.contacts(
                s, at, state, material, c, contact, needs, root, step, (count >= LATE, patience)
            )
        off = min(worst, max(single_share * worst, mean_share * total)) > step.tolerance
        if needs.curled:
            unsettled = unsettled | (change > FOLLOWED * patience * patience)
        if count == most or (count > 0 and not any_lane(off | unsettled)):
            break
        indefinite = max(indefinite, lost)
        compressed = any_lane(indefinite > 0.0)
        far = compressed or any_lane(worst > FAR)
        if far:
            retract(s, n, (indefinite > 0.0) | (worst > FAR))
        if needs.curled:
            rest_shape.update(s, at, state, material, step, c, NO)
        if compressed:
            factorise(s, n, material, stiffness, False, touching, whole, zero)
        elif far or moved or needs.curled:
            update_loads(s, n, material, stiffness, False, touching, whole)
        tension.filter_forward(s, n, material.mass, far or moved or needs.curled, touching, whole)
        lost = factorise(s, n, material, stiffness, True, touching, whole, indefinite)
        worst, total, change = apply_change(s, n)
        path += sqrt(change)
    return worst, depth, near, path


@device
def apply_change(s, n):
    """Add y to the displacements and z to the edges. Returns the greatest | |e|² − 1 | of each lane, their sum, and the
    greatest |z|²."""
    worst = broadcast(s.pivot, 0.0)
    total = most = worst
    y = z = worst, worst, worst
    for j in range(n):
        # back substitution by z_{j−1} and y_{j−1}
        z = less(combined(load(s.edge_factor, j), z, load(s.particle_factor, j), y), load3(s.load, 3 * j, 1))
        y = sum_of(y, z)
        most = max(most, dot(z, z))
        left = less(load3(s.inertial, 3 * j, 1), y)
        store3(s.inertial, 3 * j, 1, left[0], left[1], left[2])
        edge = sum_of(load3(s.edge, 3 * j, 1), z)
        store3(s.edge, 3 * j, 1, edge[0], edge[1], edge[2])
        error = abs(dot(edge, edge) - 1.0)
        error = where(error < GREATEST_ERROR, error, GREATEST_ERROR)
        worst = max(worst, error)
        total += error
    return worst, total, most


@device
def retract(s, n, chosen):
    """Bring the edges of the ``chosen`` lanes back to unit length, root to tip; one without a length takes the
    direction of the edge before it."""
    zero = broadcast(s.pivot, 0.0)
    none = shift = zero, zero, zero  # by how much the particle has moved
    for j in range(n):
        edge = load3(s.edge, 3 * j, 1)
        square = dot(edge, edge)
        back = scaled(1.0 / sqrt(max(square, TINY)) - 1.0, edge)
        by = select(chosen, select(square < TINY, load3(s.edge, 3 * j - 3, 1), back), none)
        edge, shift = sum_of(edge, by), sum_of(shift, by)
        store3(s.edge, 3 * j, 1, edge[0], edge[1], edge[2])
        left = less(load3(s.inertial, 3 * j, 1), shift)
        store3(s.inertial, 3 * j, 1, left[0], left[1], left[2])


@device
def factorise(s, n, material, stiffness, changed, touching, whole, retained):
    """Set the pivots of H and the loads for the present τ, or where ``changed``, for the τ and the forces of contact
    that `tension.filter_forward` leads to. Lanes where H is indefinite take a bounded τ in it; those where ``retained``
    is above 0 keep the pivots that there are. Returns where H is indefinite, above 0."""
    zero = stiffness * 0.0
    lost = sweep_to_root(s, n, material, stiffness, changed, True, touching, whole, (zero, retained))
    if any_lane(lost > 0.0):
        sweep_to_root(s, n, material, stiffness, False, True, touching, whole, (lost, retained))
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
    bounded, retained = lanes
    some_retained = any_lane(retained > 0.0)
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
            bounded_tension = where(bounded > 0.0, max(t, least), t)
            a += mass
            g = a + b
            rigid = g + b + c + bounded_tension
            raised = max(DEFINITE * mass - k, rigid)
            lost = where(rigid >= raised, lost, 1.0)
            i = 1.0 / (raised + k)
            f = k * i
            h = g * i
            a -= g * h
            b = k * h
            c = raised * f
            if some_retained:
                i = where(retained > 0.0, load(s.pivot, j), i)
                f = where(retained > 0.0, load(s.edge_factor, j), f)
                h = where(retained > 0.0, load(s.particle_factor, j), h)
            store(s.pivot, j, i)
            store(s.edge_factor, j, f)
            store(s.particle_factor, j, h)
        x = set_load(s, j, FIRST, t, mass, k, (p[0], q[0], bend[0], force[0]))
        y = set_load(s, j, SECOND, t, mass, k, (p[1], q[1], bend[1], force[1]))
        z = set_load(s, j, THIRD, t, mass, k, (p[2], q[2], bend[2], force[2]))
        p, q, bend, force = (x[0], y[0], z[0]), (x[1], y[1], z[1]), (x[2], y[2], z[2]), (x[3], y[3], z[3])
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
