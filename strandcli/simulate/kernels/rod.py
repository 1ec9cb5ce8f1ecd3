"""One implicit step of inextensible rods: force-density Newton on a vector of strands, a lane each.

Unknowns. A strand has N edges e_j of unit length (lengths are scaled by the segment's rest length), whose particles
move by u_j in this step. Bending energy ½ Σ κ_j |c_j − c̄_j|² with c_j = e_j − e_{j−1}, e_{−1} = d at the clamp, and
κ_0 twice the others: with half a mass at the tip this makes the discretisation second order. The step minimises

    ½ Σ M_j |u_j − u*_j|² + ½ Σ κ_j |c_j − c̄_j|²    with |e_j| = 1,

which for given force densities τ is a linear problem, H(τ) y = ρ with H = M + Dᵀ diag(τ) D + bending, pentadiagonal and
the same for x, y and z. It is solved for a change y, from a residual ρ made of differences, so that single precision is
enough. Newton's method finds τ: S δ = r, S = (e_i·e_j) ∘ (D H⁻¹ Dᵀ), r_j = |e_j|² (|e_j| − 1), exact in one step for a
pendulum.

Compression. Where a strand is pushed together faster than its inertia and its stiffness resist, H(τ) is not positive
definite and no τ that keeps it so meets the lengths: the dual has a gap. In such lanes H takes τ_j no lower than
−θ/4 min(M_{j−1}, M_j), with which M alone keeps it definite (|y_j − y_{j−1}|² <= 2 |y_j|² + 2 |y_{j−1}|²), while ρ
keeps the true τ; edges go back to unit length before each iteration, and r is what the step H⁻¹ρ from there would make
of them. That is sequential quadratic programming on the unit spheres with a convexified Hessian (Nocedal & Wright 2006,
§18.2-18.3): the same solution, reached linearly and without any search, for compression cannot run away.

Scratch is a heap of vectors, a segment's together, and small enough for the nearest cache. Two segments of zeros before
the first and after the last spare the recurrences their special cases.
"""

from __future__ import annotations

from ...jit import inner
from .simd import get, get3, put, put3, root, some, spread, where

QUARTER = 0.9 / 4
"""θ/4: the share of the mass that compression may use up in H."""
MARGIN = 0.5
"""H counts as definite where its pivots keep this share of the mass."""
FAR = 0.3
"""Error of |e|² above which edges go back to unit length before the next iteration."""
TINY = 1e-30
MOST = 1e18

# vectors of a segment: edge, displacement, change, u*, c̄ (3 each); τ, M, κ; inverse pivot of H and bands of −L; r and
# then δ; the τ that H takes
SEGMENT = 23
"""An odd number: vectors at distances of a power of two would share lines of the first-level cache."""
E, U, Y, A, C, T, M, K, DI, N1, N2, R, TH = 0, 3, 6, 9, 12, 15, 16, 17, 18, 19, 20, 21, 22
# vectors that belong to the strand, before all segments: where H lost definiteness, by how much the root moved; for the
# sweep in the end, 1 over the length of a segment, how far a particle is put off, where edges are lost and where hit,
# all forces of contact, and two places for a solid, 8 each
HARD, SHIFT, OVER, OFF, LOST, HIT, GRIP, FOUND = 0, 1, 4, 5, 8, 9, 10, 11
FIRST = 27 + 2 * SEGMENT


def rows_for(n: int) -> int:
    """Vectors of scratch that this room takes for ``n`` segments; all of it starts as zeros."""
    return FIRST + (n + 2) * SEGMENT


@inner
def factor(s, n):
    """y := L⁻¹ ρ and H = L diag(d) Lᵀ with two bands. Lanes where τ makes H indefinite take the bounded τ instead and
    are marked in row HARD; returns whether there are any."""
    residual(s, n)
    lost = eliminate(s, n, T)
    put(s, HARD, lost)
    if not some(lost > 0.0):
        return False
    for j in range(n):
        o = FIRST + j * SEGMENT
        t = get(s, o + T)
        bounded = max(t, -QUARTER * min(get(s, o - SEGMENT + M), get(s, o + M)))
        put(s, o + TH, where(lost > 0.0, bounded, t))
    residual(s, n)
    eliminate(s, n, TH)
    return True


@inner
def residual(s, n):
    """y := ρ, ρ_j = M_j (u*_j − u_j) − g_j + g_{j+1} with g_j = τ_j e_j + b_j − b_{j+1}, b_j = κ_j (c_j − c̄_j); the
    edge before the first is the clamped direction."""
    for c in range(3):
        o = FIRST + c
        edge = get(s, o + E)
        next = get(s, o + SEGMENT + E)
        b1 = get(s, FIRST + SEGMENT + K) * (next - edge - get(s, o + SEGMENT + C))
        g = get(s, FIRST + K) * (edge - get(s, o - SEGMENT + E) - get(s, o + C)) - b1 + get(s, FIRST + T) * edge
        edge = next
        for j in range(n):
            row = FIRST + j * SEGMENT
            o = row + c
            next = get(s, o + 2 * SEGMENT + E)
            b2 = get(s, row + 2 * SEGMENT + K) * (next - edge - get(s, o + 2 * SEGMENT + C))
            g1 = get(s, row + SEGMENT + T) * edge + b1 - b2
            put(s, o + Y, get(s, row + M) * (get(s, o + A) - get(s, o + U)) - g + g1)
            edge = next
            b1 = b2
            g = g1


@inner
def eliminate(s, n, t):
    """LDLᵀ of H with the force densities in field t, and y := L⁻¹ y on the way; returns 1 in lanes with a pivot that is
    too small, which is replaced by 1."""
    zero = spread(s, 0.0)
    lost = zero
    n1 = zero  # −L of the row before, first band, and times its pivot
    w1 = zero
    n2 = zero  # second band, one and two rows before
    m2 = zero
    k0 = get(s, FIRST + K)
    k1 = get(s, FIRST + SEGMENT + K)
    t0 = get(s, FIRST + t)
    for j in range(n):
        o = FIRST + j * SEGMENT
        k2 = get(s, o + 2 * SEGMENT + K)
        t1 = get(s, o + SEGMENT + t)
        mass = get(s, o + M)
        p = t1 + k1 + k2
        d = mass + t0 + k0 + 3.0 * k1 + p + m2 * k0 - n1 * w1
        for c in range(3):
            y = o + Y + c
            put(s, y, get(s, y) + m2 * get(s, y - 2 * SEGMENT) + n1 * get(s, y - SEGMENT))
        good = d > MARGIN * mass
        lost = where(good, lost, 1.0)
        i = 1.0 / where(good, d, 1.0)
        w1 = p + k1 + k2 + n2 * w1
        n1 = w1 * i
        m2 = n2
        n2 = -k2 * i
        put(s, o + DI, i)
        put(s, o + N1, n1)
        put(s, o + N2, n2)
        k0 = k1
        k1 = k2
        t0 = t1
    return lost


@inner
def forward(s, n):
    """y := L⁻¹ y with the factors that there are."""
    for j in range(n):
        o = FIRST + j * SEGMENT
        m2 = get(s, o - 2 * SEGMENT + N2)
        n1 = get(s, o - SEGMENT + N1)
        for c in range(3):
            y = o + Y + c
            put(s, y, get(s, y) + m2 * get(s, y - 2 * SEGMENT) + n1 * get(s, y - SEGMENT))


@inner
def backward(s, n):
    """y := L⁻ᵀ diag(d)⁻¹ y."""
    for j in range(n - 1, -1, -1):
        o = FIRST + j * SEGMENT
        i = get(s, o + DI)
        n1 = get(s, o + N1)
        n2 = get(s, o + N2)
        for c in range(3):
            y = o + Y + c
            put(s, y, i * get(s, y) + n2 * get(s, y + 2 * SEGMENT) + n1 * get(s, y + SEGMENT))


@inner
def move(s, n):
    """u += y, e += D y; the greatest | |e|² − 1 | of each lane."""
    worst = spread(s, 0.0)
    x0 = worst
    y0 = worst
    z0 = worst
    for j in range(n):
        o = FIRST + j * SEGMENT
        x, y, z = get3(s, o + Y, 1)
        ux, uy, uz = get3(s, o + U, 1)
        put3(s, o + U, 1, ux + x, uy + y, uz + z)
        ex, ey, ez = get3(s, o + E, 1)
        ex += x - x0
        ey += y - y0
        ez += z - z0
        put3(s, o + E, 1, ex, ey, ez)
        w = abs(ex * ex + ey * ey + ez * ez - 1.0)
        worst = max(worst, where(w < MOST, w, MOST))  # never NaN
        x0 = x
        y0 = y
        z0 = z
    return worst


@inner
def retract(s, n, worst):
    """Edges of lanes with bounded τ, and of lanes whose greatest error is far off, go back to unit length, root to tip.
    Rows Y sum up how far particles are put off."""
    mine = max(get(s, HARD), worst) > FAR
    x0 = spread(s, 0.0)
    y0 = x0
    z0 = x0
    for j in range(n):
        o = FIRST + j * SEGMENT
        x, y, z = get3(s, o + E, 1)
        f = where(mine, 1.0 / root(max(x * x + y * y + z * z, TINY)) - 1.0, 0.0)
        dx = x * f
        dy = y * f
        dz = z * f
        put3(s, o + E, 1, x + dx, y + dy, z + dz)
        x0 += dx
        y0 += dy
        z0 += dz
        ux, uy, uz = get3(s, o + U, 1)
        put3(s, o + U, 1, ux + x0, uy + y0, uz + z0)


@inner
def shorten(s, n, most):
    """The change y is scaled lane by lane so that no edge changes by more than ``most``."""
    worst = spread(s, TINY)
    x0 = spread(s, 0.0)
    y0 = x0
    z0 = x0
    for j in range(n):
        x, y, z = get3(s, FIRST + j * SEGMENT + Y, 1)
        dx = x - x0
        dy = y - y0
        dz = z - z0
        worst = max(worst, dx * dx + dy * dy + dz * dz)
        x0 = x
        y0 = y
        z0 = z
    f = min(1.0, most / root(worst))
    for j in range(n):
        for c in range(3):
            o = FIRST + j * SEGMENT + Y + c
            put(s, o, get(s, o) * f)


@inner
def demand(s, n, ahead):
    """r, where ``ahead`` with what the change y in the scratch would add to it."""
    for j in range(n):
        o = FIRST + j * SEGMENT
        x, y, z = get3(s, o + E, 1)
        q = x * x + y * y + z * z
        r = where(q > 0.25, q * (root(q) - 1.0), 0.5 * (q - 1.0))
        if ahead:
            r += x * (get(s, o + Y) - get(s, o - SEGMENT + Y))
            r += y * (get(s, o + Y + 1) - get(s, o - SEGMENT + Y + 1))
            r += z * (get(s, o + Y + 2) - get(s, o - SEGMENT + Y + 2))
        put(s, o + R, r)


@inner
def respond(s, n):
    """R := H⁻¹ R with the factors that there are, of one number a particle."""
    for j in range(n):
        o = FIRST + j * SEGMENT
        r = get(s, o + R) + get(s, o - 2 * SEGMENT + N2) * get(s, o - 2 * SEGMENT + R)
        put(s, o + R, r + get(s, o - SEGMENT + N1) * get(s, o - SEGMENT + R))
    for j in range(n - 1, -1, -1):
        o = FIRST + j * SEGMENT
        r = get(s, o + DI) * get(s, o + R) + get(s, o + N2) * get(s, o + 2 * SEGMENT + R)
        put(s, o + R, r + get(s, o + N1) * get(s, o + SEGMENT + R))
