"""One implicit step of inextensible rods: force-density Newton on a vector of strands, a lane each.

Unknowns. A strand has N edges e_j of unit length (lengths are scaled by the segment's rest length), whose particles
move by u_j in this step. Bending energy ½ Σ κ_j |c_j − c̄_j|² with c_j = e_j − e_{j−1}, e_{−1} = d at the clamp, and
κ_0 twice the others: with half a mass at the tip this makes the discretisation second order. The step minimises

    ½ Σ M_j |u_j − u*_j|² + ½ Σ κ_j |c_j − c̄_j|²    with |e_j| = 1,

which for given force densities τ is a linear problem, H(τ) y = ρ with H = M + Dᵀ diag(τ) D + bending, pentadiagonal and
the same for x, y and z. It is solved for a change y, from a residual ρ made of differences, so that single precision is
enough. Newton's method finds τ: S δ = r, S = (e_i·e_j) ∘ (D H⁻¹ Dᵀ), r_j = |e_j|² (|e_j| − 1), exact in one step for a
pendulum.

Elimination. The pivots of a pentadiagonal stiff H come from numbers that grow as the fourth power of the segments, of
which the masses are the last digits. So what is eliminated, from the tip on, is not y_j but the change of an edge,
z_j = y_j − y_{j−1}, given y_{j−1} and z_{j−1}: Bellman's recursion (1957) for the least energy that the strand beyond
can have, V(y, z) = ½ a y² + b y z + ½ c z² + p·y + q·z. There rigidities are only ever added, and there is one
difference, of which no more is left than of masses:

    B = a + M + b,  Q = a + M + 2 b + c + τ,  i = 1 / (Q + κ),
    a' = a + M − i B²,  b' = i κ B,  c' = i κ Q,    and then, root to tip,  z_j = i κ z_{j−1} − i B y_{j−1} − g_j.

Single precision is enough for a thousand segments.

Compression. Where a strand is pushed together faster than its inertia and its stiffness resist, H(τ) is not positive
definite and no τ that keeps it so meets the lengths: the dual has a gap. In such lanes H takes τ_j no lower than what M
alone resists, −θ/4 min(M_{j−1}, M_j) (for |y_j − y_{j−1}|² <= 2 |y_j|² + 2 |y_{j−1}|²), or M and κ together where that
is enough: it is where joints are alike, and need not be where they stiffen toward the tip. ρ keeps the true τ; edges go
back to unit length before each iteration, and r is what the step H⁻¹ρ from there would make of them. That is sequential
quadratic programming on the unit spheres with a convexified Hessian (Nocedal & Wright 2006,
§18.2-18.3): the same solution, reached linearly, for compression cannot run away.
"""

from __future__ import annotations

from ...jit import device, inlined
from ...simd import broadcast, load, load3, sqrt, store, store3, where
from .rod_scratch import (
    AXES,
    EDGE,
    EDGE_FACTOR,
    FIRST_SEGMENT,
    INERTIAL,
    INVERSE_PIVOT,
    LOAD,
    MOBILITY,
    PACK,
    PARTICLE_FACTOR,
    REST_BEND,
    SEGMENT,
    STIFFNESS,
)
from .rod_tension import firm_force

FAR = 0.3
"""Error of |e|² above which edges return to unit length before the next iteration."""
TINY = 1e-30
GREATEST_ERROR = 1e18
"""Errors of |e|² are no more than this, and never NaN."""


@device
def edge_change(s, o, x, y, z, u, v, w):
    """z_j, the change of the edge at place o, from (x, y, z) = z_{j−1} and (u, v, w) = y_{j−1}: back substitution."""
    f = load(s, o + EDGE_FACTOR)
    g = load(s, o + PARTICLE_FACTOR)
    a, b, c = load3(s, o + LOAD, 1)
    return f * x - g * u - a, f * y - g * v - b, f * z - g * w - c


@device
def apply_change(s, n, step):
    """Add y to the displacements and z to the edges, times ``step`` where that is not None. Returns the greatest
    | |e|² − 1 | of each lane and their sum."""
    worst = broadcast(s, 0.0)
    total = worst
    x, y, z = worst, worst, worst
    u, v, w = worst, worst, worst
    for j in range(n):
        o = FIRST_SEGMENT + j * SEGMENT
        x, y, z = edge_change(s, o, x, y, z, u, v, w)
        u += x
        v += y
        w += z
        dx, dy, dz = load3(s, o + INERTIAL, 1)
        ex, ey, ez = load3(s, o + EDGE, 1)
        if step is None:
            store3(s, o + INERTIAL, 1, dx - u, dy - v, dz - w)
            ex += x
            ey += y
            ez += z
        else:
            store3(s, o + INERTIAL, 1, dx - step * u, dy - step * v, dz - step * w)
            ex += step * x
            ey += step * y
            ez += step * z
        store3(s, o + EDGE, 1, ex, ey, ez)
        error = abs(ex * ex + ey * ey + ez * ez - 1.0)
        error = where(error < GREATEST_ERROR, error, GREATEST_ERROR)
        worst = max(worst, error)
        total += error
    return worst, total


@device
def retract(s, n, mass, joint, curled, chosen):
    """Bring the edges of the ``chosen`` lanes back to unit length, root to tip; one without a length takes the
    direction of the edge before it. Returns twice the energy of each lane, the sum that a step minimises."""
    stiffness = load(s, STIFFNESS)
    # by how much the particle has moved: all that edges up to it have changed
    sx = broadcast(s, 0.0)
    sy, sz = sx, sx
    energy = sx
    for j in range(n):
        o = FIRST_SEGMENT + j * SEGMENT
        x, y, z = load3(s, o + EDGE, 1)
        px, py, pz = load3(s, o - SEGMENT + EDGE, 1)
        square = x * x + y * y + z * z
        f = 1.0 / sqrt(max(square, TINY)) - 1.0
        lost = square < TINY
        dx = where(chosen, where(lost, px, x * f), 0.0)
        dy = where(chosen, where(lost, py, y * f), 0.0)
        dz = where(chosen, where(lost, pz, z * f), 0.0)
        x += dx
        y += dy
        z += dz
        store3(s, o + EDGE, 1, x, y, z)
        sx += dx
        sy += dy
        sz += dz
        cx, cy, cz = load3(s, o + REST_BEND, 1)
        x -= px + cx
        y -= py + cy
        z -= pz + cz
        energy += stiffness * joint[j] * (x * x + y * y + z * z)
        x, y, z = load3(s, o + INERTIAL, 1)
        x -= sx
        y -= sy
        z -= sz
        store3(s, o + INERTIAL, 1, x, y, z)
        energy += mass[j] * (x * x + y * y + z * z)
        if curled:
            x, y, z = load3(s, o + EDGE, 1)
            fx, fy, fz = load3(s, firm_force(n, j), 1)
            energy += 2.0 * (sqrt(fx * fx + fy * fy + fz * fz) - (fx * x + fy * y + fz * z))
    return energy


@device
def greatest_change_squared(s, n):
    """The greatest |z_j|² of each lane."""
    worst = broadcast(s, TINY)
    x = broadcast(s, 0.0)
    y, z = x, x
    u, v, w = x, x, x
    for j in range(n):
        x, y, z = edge_change(s, FIRST_SEGMENT + j * SEGMENT, x, y, z, u, v, w)
        u += x
        v += y
        w += z
        worst = max(worst, x * x + y * y + z * z)
    return worst


@device
def scale_loads(s, n, factor):
    """Multiply all loads g_j, and with them the change that they lead to."""
    for j in range(n):
        for c in range(3):
            o = FIRST_SEGMENT + j * SEGMENT + LOAD + c
            store(s, o, load(s, o) * factor)


@device
def begin_mobility(s, n, edge, mass, push):
    """Begin H⁻¹ M χ by a sweep from the tip to the root, which `finish_mobility` ends; χ is 1 for particles with a
    force of contact. H⁻¹ M χ is how far such forces move a particle, as a share of how far they would move each
    alone."""
    p = broadcast(s, 0.0)
    q = p
    for j in range(n - 1, -1, -1):
        o = FIRST_SEGMENT + j * SEGMENT
        x, y, z = load3(push, edge + j * AXES, PACK)
        p -= where(abs(x) + abs(y) + abs(z) > 0.0, broadcast(s, mass[j]), 0.0)
        sum = p + q
        store(s, o + MOBILITY, load(s, o + INVERSE_PIVOT) * sum)
        p -= load(s, o + PARTICLE_FACTOR) * sum
        q = load(s, o + EDGE_FACTOR) * sum


@inlined
def finish_mobility(s, o, y, z):
    """Set `MOBILITY` of the segment at place o to H⁻¹ M χ of its particle, and return that and the same of its edge,
    given both of the segment before, y and z."""
    z = load(s, o + EDGE_FACTOR) * z - load(s, o + PARTICLE_FACTOR) * y - load(s, o + MOBILITY)
    y += z
    store(s, o + MOBILITY, y)
    return y, z
