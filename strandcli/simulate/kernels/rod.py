"""One implicit step of inextensible rods: force-density Newton on a block of strands, one strand a lane.

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

Scratch is flat, in rows of W lanes; a segment's rows lie together at constant distances, by which LLVM sees that they
do not overlap. Two segments of zeros before the first and after the last spare the recurrences their special cases.
Offsets are unsigned, for signed ones may wrap around, which stops SIMD. Lane loops do not branch.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ...constants import W
from ...jit import inner

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
TWO = np.float32(2.0)
THREE = np.float32(3.0)
QUARTER = np.float32(0.9 / 4)
"""θ/4: the share of the mass that compression may use up in H."""
MARGIN = np.float32(0.5)
"""H counts as definite where its pivots keep this share of the mass."""
FAR = np.float32(0.3)
"""Error of |e|² above which edges go back to unit length before the next iteration."""
SHORT = np.float32(1 / 16)
"""|e|² below which an edge has hardly a direction left: S then takes this."""
PATIENCE = 6
"""Iterations after which no edge changes by more than `STRIDES` over the number of iterations since."""
STRIDES = np.float32(2.0)
WILD = np.float32(64.0)
"""Error of |e|² above which τ does not start from the step before."""
PULLED = np.float32(4.0)
PIVOT = np.float32(1e-6)
TINY = np.float32(1e-30)
LOWEST = np.float32(-1e38)
MOST = np.float32(1e18)


def _rows(count: int) -> np.uint64:
    return np.uint64(count * W)


LANES = np.uint64(W)
U0 = np.uint64(0)
U1 = np.uint64(1)
U2 = np.uint64(2)
U3 = np.uint64(3)
U4 = np.uint64(4)
# rows of a segment: edge, displacement, change, u*, c̄ (3 each); τ, M, κ; pivot of H, its inverse, bands of L; δ; the
# τ that H takes; whether H lost definiteness in a segment up to here; greatest error up to here; what to put right
FIELDS = 27
"""Not a multiple of 8: rows of 512 bytes at distances of 4096 would share the lines of the first-level cache."""
E, U, Y, A, C, T, M, K = (_rows(i) for i in (0, 3, 6, 9, 12, 15, 16, 17))
D, DI, L1, L2, R, TH, LOST, WORST, SHARE = (_rows(i) for i in (18, 19, 20, 21, 22, 23, 24, 25, 26))
# the same rows after the iterations: where particles are and where they were, how far they were put off, the length of
# the segment, and whether it has lost its direction; then of contact: what the force of the step before comes to as a
# displacement of a particle alone, the length of that, and how heavy all that moves with the particle is beside it
PLACE, OLD, OFF, LENGTH, NOWHERE = U, A, C, R, TH
HELD, GRIP, BULK = D, L2, K
SEGMENT = _rows(FIELDS)
# rows that belong to the strand, before all segments
NIL, SPARE, SHIFT, LOAD, HARD, TRAY, ALL = (_rows(i) for i in (0, 1, 2, 5, 8, 9, 27))
HEAD = _rows(28)
HIT = LOAD
"""After the iterations: whether a strand has run into something."""
FIRST = HEAD + U2 * SEGMENT


def size_for(n: int) -> int:
    """Numbers of scratch for ``n`` segments: 28 rows of the strand's own, n + 4 segments, and the lower triangle of S
    row by row, with a row for the right-hand side."""
    return int(FIRST) + (n + 2) * int(SEGMENT) + W * ((n + 1) * (n + 4) // 2 + 3)


def clear(scratch: Any) -> None:
    """Zeros where kernels rely on them, and ones in row ALL, once."""
    scratch[:] = 0
    scratch[int(ALL) : int(ALL) + W] = 1


@inner
def factor(s, n):
    """H = L diag(d) Lᵀ with two bands. Lanes where τ makes it indefinite take the bounded τ instead; whether there are
    any is kept in HARD."""
    last = FIRST + (n - U1) * SEGMENT
    for k in range(LANES):
        s[FIRST - SEGMENT + SHARE + k] = ZERO
    s[HARD] = ZERO
    if not eliminate(s, n, T):
        return
    s[HARD] = ONE
    for k in range(LANES):
        s[FIRST - SEGMENT + SHARE + k] = s[last + LOST + k]
    for j in range(n):
        o = FIRST + j * SEGMENT
        for v in range(LANES):
            k = o + v
            mine = s[k - SEGMENT + SHARE]
            t = s[k + T]
            bounded = max(t, -QUARTER * min(s[k - SEGMENT + M], s[k + M]))
            s[k + TH] = bounded if mine > ZERO else t
            s[k + SHARE] = mine
    eliminate(s, n, TH)


@inner
def eliminate(s, n, t):
    """LDLᵀ of H with the force densities in field t; row LOST becomes 1 in lanes with a pivot that is too small, which
    is replaced by 1. Returns whether there are any."""
    for j in range(n):
        o = FIRST + j * SEGMENT
        for v in range(LANES):
            k = o + v
            k1 = s[k + SEGMENT + K]
            k2 = s[k + U2 * SEGMENT + K]
            p = s[k + SEGMENT + t] + k1 + k2
            l1 = -p - k1 - k2
            b1 = s[k - SEGMENT + L1]
            b2 = s[k - U2 * SEGMENT + L2]
            carried = s[k - SEGMENT + D] * b1
            d = s[k + M] + s[k + t] + s[k + K] + THREE * k1 + p
            d -= b2 * b2 * s[k - U2 * SEGMENT + D] + b1 * carried
            l1 -= s[k - SEGMENT + L2] * carried
            lost = s[k - SEGMENT + LOST]
            good = d > MARGIN * s[k + M]
            s[k + LOST] = lost if good else ONE
            d = d if good else ONE
            i = ONE / d
            s[k + D] = d
            s[k + DI] = i
            s[k + L1] = l1 * i
            s[k + L2] = k2 * i
    return greatest(s, FIRST + (n - U1) * SEGMENT + LOST) > ZERO


@inner
def greatest(s, row):
    """The greatest number of a row."""
    most = s[row]
    for k in range(LANES):
        most = max(most, s[row + k])
    return most


@inner
def change(s, n):
    """y := H⁻¹ ρ, ρ_j = M_j (u*_j − u_j) − g_j + g_{j+1} with g_j = τ_j e_j + κ_j (c_j − c̄_j) − κ_{j+1} (c_{j+1} −
    c̄_{j+1}); the edge before the first is the clamped direction."""
    for j in range(n):
        for c in range(U3):
            o = FIRST + j * SEGMENT + c * LANES
            lane = c * LANES
            for v in range(LANES):
                k = o + v
                e = s[k + E]
                b = s[k - lane + K] * (e - s[k - SEGMENT + E] - s[k + C])
                b1 = s[k - lane + SEGMENT + K] * (s[k + SEGMENT + E] - e - s[k + SEGMENT + C])
                s[k + Y] = s[k - lane + T] * e + b - b1
    for j in range(n):
        for c in range(U3):
            o = FIRST + j * SEGMENT + c * LANES
            lane = c * LANES
            for v in range(LANES):
                k = o + v
                y = s[k - lane + M] * (s[k + A] - s[k + U]) - s[k + Y] + s[k + SEGMENT + Y]
                y -= s[k - lane - SEGMENT + L1] * s[k - SEGMENT + Y]
                s[k + Y] = y - s[k - lane - U2 * SEGMENT + L2] * s[k - U2 * SEGMENT + Y]
    for a in range(n):
        j = n - U1 - a
        for c in range(U3):
            o = FIRST + j * SEGMENT + c * LANES
            lane = c * LANES
            for v in range(LANES):
                k = o + v
                y = s[k - lane + DI] * s[k + Y] - s[k - lane + L1] * s[k + SEGMENT + Y]
                s[k + Y] = y - s[k - lane + L2] * s[k + U2 * SEGMENT + Y]


@inner
def move(s, n):
    """u += y, e += D y; the greatest | |e|² − 1 |, and that of each lane in row WORST of the last segment."""
    for j in range(n):
        o = FIRST + j * SEGMENT
        for v in range(LANES):
            k = o + v
            x = s[k + Y]
            y = s[k + Y + LANES]
            z = s[k + Y + U2 * LANES]
            s[k + U] += x
            s[k + U + LANES] += y
            s[k + U + U2 * LANES] += z
            x = s[k + E] + (x - s[k - SEGMENT + Y])
            y = s[k + E + LANES] + (y - s[k - SEGMENT + Y + LANES])
            z = s[k + E + U2 * LANES] + (z - s[k - SEGMENT + Y + U2 * LANES])
            s[k + E] = x
            s[k + E + LANES] = y
            s[k + E + U2 * LANES] = z
            w = abs(x * x + y * y + z * z - ONE)
            w = w if w < MOST else MOST  # neither is NaN
            s[k + WORST] = max(s[k - SEGMENT + WORST], w)
    return greatest(s, FIRST + (n - U1) * SEGMENT + WORST)


@inner
def retract(s, n):
    """Edges of lanes with bounded τ, and of lanes that are far off, go back to unit length, root to tip. Rows Y sum up
    how far particles are put off."""
    last = FIRST + (n - U1) * SEGMENT + WORST
    mine = FIRST - SEGMENT + SHARE
    for k in range(LANES):
        s[mine + k] = ONE if max(s[mine + k], s[last + k]) > FAR else ZERO
    for j in range(n):
        o = FIRST + j * SEGMENT
        for v in range(LANES):
            k = o + v
            x = s[k + E]
            y = s[k + E + LANES]
            z = s[k + E + U2 * LANES]
            share = s[k - SEGMENT + SHARE]
            f = share * (ONE / np.sqrt(max(x * x + y * y + z * z, TINY)) - ONE)
            x *= f
            y *= f
            z *= f
            s[k + SHARE] = share
            s[k + E] += x
            s[k + E + LANES] += y
            s[k + E + U2 * LANES] += z
            x += s[k - SEGMENT + Y]
            y += s[k - SEGMENT + Y + LANES]
            z += s[k - SEGMENT + Y + U2 * LANES]
            s[k + Y] = x
            s[k + Y + LANES] = y
            s[k + Y + U2 * LANES] = z
            s[k + U] += x
            s[k + U + LANES] += y
            s[k + U + U2 * LANES] += z


@inner
def shorten(s, n, most):
    """The change y is scaled lane by lane so that no edge changes by more than ``most``; rows WORST find the
    greatest."""
    for j in range(n):
        o = FIRST + j * SEGMENT
        for v in range(LANES):
            k = o + v
            x = s[k + Y] - s[k - SEGMENT + Y]
            y = s[k + Y + LANES] - s[k - SEGMENT + Y + LANES]
            z = s[k + Y + U2 * LANES] - s[k - SEGMENT + Y + U2 * LANES]
            s[k + WORST] = max(s[k - SEGMENT + WORST], x * x + y * y + z * z)
    last = FIRST + (n - U1) * SEGMENT
    for k in range(LANES):
        s[SPARE + k] = min(ONE, most / np.sqrt(max(s[last + WORST + k], TINY)))
    for j in range(n):
        for c in range(U3):
            o = FIRST + j * SEGMENT + Y + c * LANES
            for k in range(LANES):
                s[o + k] *= s[SPARE + k]


@inner
def demand(s, n):
    """δ := r, with what the change y in the scratch would add to it."""
    for j in range(n):
        o = FIRST + j * SEGMENT
        for v in range(LANES):
            k = o + v
            x = s[k + E]
            y = s[k + E + LANES]
            z = s[k + E + U2 * LANES]
            q = x * x + y * y + z * z
            r = q * (np.sqrt(q) - ONE) if q > HALF * HALF else HALF * (q - ONE)
            r += x * (s[k + Y] - s[k - SEGMENT + Y]) + y * (s[k + Y + LANES] - s[k - SEGMENT + Y + LANES])
            s[k + R] = r + z * (s[k + Y + U2 * LANES] - s[k - SEGMENT + Y + U2 * LANES])


@inner
def still(s, n):
    """y := 0."""
    for j in range(n):
        o = FIRST + j * SEGMENT + Y
        for k in range(o, o + U3 * LANES):
            s[k] = ZERO


@inner
def at(n, i, j):
    """Where entry (i, j), i >= j, of the triangle is: each row begins with a zero, and a row of two comes before."""
    return FIRST + (n + U2) * SEGMENT + (i * (i + U3) // U2 + j + U3) * LANES


@inner
def inverse(s, n):
    """The lower triangle of H⁻¹, from the last column to the first (Takahashi, Fagan & Chin 1973)."""
    for a in range(n):
        j = n - U1 - a
        o = FIRST + j * SEGMENT
        for b in range(a + U1):
            i = n - U1 - b
            start = o + DI if i == j else NIL
            one = NIL if a < U1 else at(n, max(i, j + U1), min(i, j + U1))
            two = NIL if a < U2 else at(n, max(i, j + U2), min(i, j + U2))
            here = at(n, i, j)
            for k in range(LANES):
                s[here + k] = s[start + k] - s[o + L1 + k] * s[one + k] - s[o + L2 + k] * s[two + k]


@inner
def couple(s, n):
    """S := (e_i·e_j) ∘ (D H⁻¹ Dᵀ) in place of H⁻¹, from the last entry to the first."""
    for a in range(n):
        i = n - U1 - a
        p = FIRST + i * SEGMENT
        for b in range(i + U1):
            here = at(n, i, i - b)
            # (i − 1, i) is (i, i − 1)
            up = here - LANES if b == U0 else here - (i + U1) * LANES
            scale(s, here, up, here - (i + U2) * LANES, p, FIRST + (i - b) * SEGMENT, SHORT if b == U0 else LOWEST)


@inner
def scale(s, here, up, both, p, q, least):
    """Entry (i, j) less those above it and left of it, plus that above and left, times e_i·e_j or ``least``."""
    for k in range(LANES):
        dot = s[p + k] * s[q + k] + s[p + LANES + k] * s[q + LANES + k] + s[p + U2 * LANES + k] * s[q + U2 * LANES + k]
        s[here + k] = (s[here + k] - s[here - LANES + k] - s[up + k] + s[both + k]) * max(dot, least)


@inner
def solve_dense(s, n):
    """δ := S⁻¹ δ by Cholesky's factors, row by row without pivoting, and τ += δ; the right-hand side is one more row.
    S is positive definite by Schur's product theorem; a pivot that rounding has taken below a millionth of its entry
    is raised to that. Diagonal entries become the inverse ones of the factor."""
    rhs = at(n, n, U0)
    for i in range(n):
        for k in range(LANES):
            s[rhs + i * LANES + k] = s[FIRST + i * SEGMENT + R + k]
    for i in range(n + U1):
        row = at(n, i, U0)
        for j in range(i):
            project(s, row + j * LANES, row, at(n, j, U0), j, at(n, j, j))
        if i < n:
            last = row + i * LANES
            for k in range(LANES):
                s[SPARE + k] = max(PIVOT * s[last + k], TINY)
            project(s, last, row, row, i, ALL)
            for k in range(LANES):
                s[last + k] = ONE / np.sqrt(max(s[last + k], s[SPARE + k]))
    for a in range(n):
        i = n - U1 - a
        row = at(n, i, U0)
        mine = rhs + i * LANES
        tau = FIRST + i * SEGMENT + T
        for k in range(LANES):
            s[mine + k] *= s[row + i * LANES + k]
        for k in range(LANES):
            s[tau + k] += s[mine + k]
        relieve(s, rhs, row, mine, i)


@inner
def project(s, here, row, other, count, by):
    """Row `here` loses the products of ``count`` rows from `row` on with as many from `other` on, and is multiplied
    by row `by`."""
    while count > U3:
        for k in range(LANES):
            s[here + k] -= (s[row + k] * s[other + k] + s[row + LANES + k] * s[other + LANES + k]) + (
                s[row + U2 * LANES + k] * s[other + U2 * LANES + k]
                + s[row + U3 * LANES + k] * s[other + U3 * LANES + k]
            )
        row += U4 * LANES
        other += U4 * LANES
        count -= U4
    if count == U0:
        for k in range(LANES):
            s[here + k] *= s[by + k]
    elif count == U1:
        for k in range(LANES):
            s[here + k] = (s[here + k] - s[row + k] * s[other + k]) * s[by + k]
    elif count == U2:
        for k in range(LANES):
            sum = s[row + k] * s[other + k] + s[row + LANES + k] * s[other + LANES + k]
            s[here + k] = (s[here + k] - sum) * s[by + k]
    else:
        for k in range(LANES):
            sum = s[row + k] * s[other + k] + s[row + LANES + k] * s[other + LANES + k]
            sum += s[row + U2 * LANES + k] * s[other + U2 * LANES + k]
            s[here + k] = (s[here + k] - sum) * s[by + k]


@inner
def relieve(s, rhs, row, mine, count):
    """``count`` rows from `rhs` on lose their multiples, in rows from `row` on, of row `mine`."""
    for j in range(count):
        for k in range(LANES):
            s[rhs + j * LANES + k] -= s[row + j * LANES + k] * s[mine + k]


@inner
def pull(s, n):
    """τ at least what would carry the load if all of it pulled one way, less a few units of mass: rows LOAD sum it up
    from the tip, row SPARE the mass."""
    for k in range(U3 * LANES):
        s[LOAD + k] = ZERO
    for k in range(LANES):
        s[SPARE + k] = ZERO
    for a in range(n):
        o = FIRST + (n - U1 - a) * SEGMENT
        for c in range(U3):
            for k in range(LANES):
                s[LOAD + c * LANES + k] += s[o + M + k] * s[o + A + c * LANES + k]
        for k in range(LANES):
            s[SPARE + k] += s[o + M + k]
        for k in range(LANES):
            x = s[LOAD + k]
            y = s[LOAD + LANES + k]
            z = s[LOAD + U2 * LANES + k]
            load = np.sqrt(x * x + y * y + z * z) - PULLED * s[SPARE + k]
            t = s[o + T + k]
            s[o + T + k] = max(t, load) if load > ZERO else t


@inner
def iterate(s, n, iterations, enough):
    """Newton's iterations: one, and on until all | |e|² − 1 | are below ``enough``, but no more than ``iterations``;
    returns what they are in the end. Begins with x(τ) for the τ of the step before, or, where loads turn out to be far
    greater than that knows of, for more."""
    worst = ZERO
    for count in range(-1, iterations + 1):
        if count > 1 and worst <= enough:
            break
        if count == 0:
            if not worst > WILD:
                continue
            pull(s, n)
        if count > 0:
            if worst > FAR or s[HARD] > ZERO:
                retract(s, n)
                change(s, n)
            else:
                still(s, n)
            demand(s, n)
            inverse(s, n)
            couple(s, n)
            solve_dense(s, n)
        factor(s, n)
        change(s, n)
        if count > PATIENCE:
            shorten(s, n, STRIDES / np.float32(count - PATIENCE))
        worst = move(s, n)
    return worst
