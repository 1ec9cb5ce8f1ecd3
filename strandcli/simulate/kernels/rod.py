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

Scratch is a heap of vectors, a segment's together, and for short strands small enough for the nearest cache. Two
segments of zeros before the first and after the last spare the recurrences their special cases.
"""

from __future__ import annotations

from ...jit import device, inlined
from ...simd import broadcast, load, load3, sqrt, store, store3, where

FAR = 0.3
"""Error of |e|² above which edges go back to unit length before the next iteration."""
TINY = 1e-30
MOST = 1e18

PACK = 16
"""Strands whose state lies together, a cache line of each number in single precision, one after the other as a step
needs them: processors fetch ahead what is read in a row."""
AXES = 3 * PACK
"""Numbers of a row of three coordinates, of all strands of a pack."""

# vectors of a segment: edge, what is left of u* − u, c̄, its change g by loads alone (3 each); τ; the inverse pivot i,
# i κ and i B; r and then δ
SEGMENT = 17
"""An odd number: vectors at distances of a power of two would share lines of the first-level cache."""
E, D, C, G, T, DI, N1, N2, R = 0, 3, 6, 9, 12, 13, 14, 15, 16
# vectors that belong to the strand, before all segments: where H lost definiteness, by how much the root moved, κ where
# joints have a rigidity of 1, 1 over the length of a segment; what u* takes: the velocity that loads add, and how far a
# velocity and an acceleration lead, in segments; for the sweep in the end, how far a particle is put off, where edges
# are lost and where hit, all forces of contact, and two places for a solid, 8 each
HARD, SHIFT, STIFF, OVER, FALL, REST, PRESS, OFF, LOST, HIT, GRIP, FOUND = 0, 1, 4, 5, 6, 9, 10, 11, 14, 15, 16, 17
FIRST = 33 + 2 * SEGMENT


def rows_for(n: int) -> int:
    """Vectors of scratch that this room takes for ``n`` segments; all of it starts as zeros."""
    return FIRST + (n + 2) * SEGMENT


@device
def ahead(s, o, x, y, z, u, v, w):
    """The change of an edge, from that of the one before it and of the particle in between."""
    f = load(s, o + N1)
    g = load(s, o + N2)
    a, b, c = load3(s, o + G, 1)
    return f * x - g * u - a, f * y - g * v - b, f * z - g * w - c


@device
def move(s, n, share):
    """u += y, e += z, or a ``share`` of each where that is not None; the greatest | |e|² − 1 | of each lane, and their
    sum."""
    worst = broadcast(s, 0.0)
    total = worst
    x, y, z = worst, worst, worst
    u, v, w = worst, worst, worst
    for j in range(n):
        o = FIRST + j * SEGMENT
        x, y, z = ahead(s, o, x, y, z, u, v, w)
        u += x
        v += y
        w += z
        dx, dy, dz = load3(s, o + D, 1)
        ex, ey, ez = load3(s, o + E, 1)
        if share is None:
            store3(s, o + D, 1, dx - u, dy - v, dz - w)
            ex += x
            ey += y
            ez += z
        else:
            store3(s, o + D, 1, dx - share * u, dy - share * v, dz - share * w)
            ex += share * x
            ey += share * y
            ez += share * z
        store3(s, o + E, 1, ex, ey, ez)
        off = abs(ex * ex + ey * ey + ez * ez - 1.0)
        off = where(off < MOST, off, MOST)  # never NaN
        worst = max(worst, off)
        total += off
    return worst, total


@device
def retract(s, n, mass, joint, mine):
    """Edges of some lanes go back to unit length, root to tip; one that is lost takes the direction of the one before
    it. Returns the energy of each lane, twice."""
    stiff = load(s, STIFF)
    x0 = broadcast(s, 0.0)
    y0, z0 = x0, x0
    energy = x0
    for j in range(n):
        o = FIRST + j * SEGMENT
        x, y, z = load3(s, o + E, 1)
        px, py, pz = load3(s, o - SEGMENT + E, 1)
        q = x * x + y * y + z * z
        f = 1.0 / sqrt(max(q, TINY)) - 1.0
        lost = q < TINY
        dx = where(mine, where(lost, px, x * f), 0.0)
        dy = where(mine, where(lost, py, y * f), 0.0)
        dz = where(mine, where(lost, pz, z * f), 0.0)
        x += dx
        y += dy
        z += dz
        store3(s, o + E, 1, x, y, z)
        x0 += dx
        y0 += dy
        z0 += dz
        cx, cy, cz = load3(s, o + C, 1)
        x -= px + cx
        y -= py + cy
        z -= pz + cz
        energy += stiff * joint[j] * (x * x + y * y + z * z)
        x, y, z = load3(s, o + D, 1)
        x -= x0
        y -= y0
        z -= z0
        store3(s, o + D, 1, x, y, z)
        energy += mass[j] * (x * x + y * y + z * z)
    return energy


@device
def longest(s, n):
    """The greatest change of an edge that loads ask for, squared."""
    worst = broadcast(s, TINY)
    x = broadcast(s, 0.0)
    y, z = x, x
    u, v, w = x, x, x
    for j in range(n):
        x, y, z = ahead(s, FIRST + j * SEGMENT, x, y, z, u, v, w)
        u += x
        v += y
        w += z
        worst = max(worst, x * x + y * y + z * z)
    return worst


@device
def shorten(s, n, share):
    """Take only a share of the change that loads ask for."""
    for j in range(n):
        for c in range(3):
            o = FIRST + j * SEGMENT + G + c
            store(s, o, load(s, o) * share)


@device
def yield_to(s, n, edge, mass, push):
    """Begin H⁻¹ M χ with the factors that there are, from the tip to the root: how far forces of contact move
    particles, as a share of how far they would move each alone, with χ = 1 where there are some. R takes what
    `yielding` ends it with."""
    p = broadcast(s, 0.0)
    q = p
    for j in range(n - 1, -1, -1):
        o = FIRST + j * SEGMENT
        x, y, z = load3(push, edge + j * AXES, PACK)
        p -= where(abs(x) + abs(y) + abs(z) > 0.0, broadcast(s, mass[j]), 0.0)
        sum = p + q
        store(s, o + R, load(s, o + DI) * sum)
        p -= load(s, o + N2) * sum
        q = load(s, o + N1) * sum


@inlined
def yielding(s, o, y, z):
    """From the root to the tip, the same of a segment's particle and edge, given those of the one before: R ends as
    that of the particle."""
    z = load(s, o + N1) * z - load(s, o + N2) * y - load(s, o + R)
    y += z
    store(s, o + R, y)
    return y, z
