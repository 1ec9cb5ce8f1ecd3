"""One implicit step of inextensible rods: force-density Newton on a block of strands, one strand a lane.

Unknowns. A strand has N edges e_j of unit length (lengths are scaled by the segment's rest length), whose particles
move by u_j in this step. Bending energy ½ Σ κ_j |c_j − c̄_j|² with c_j = e_{j+1} − e_j, c_0 = e_1 − d at the clamp, and
κ_0 twice the others: with half a mass at the tip this makes the discretisation second order. The step minimises

    ½ Σ M_j |u_j − u*_j|² + ½ Σ κ_j |c_j − c̄_j|²    with |e_j| = 1,

which for given force densities τ is a linear problem, H(τ) y = ρ with H = M + Dᵀ (diag(τ) + C) D pentadiagonal and the
same for x, y and z. It is solved for a change y, from a residual ρ made of differences, so that single precision is
enough. Newton's method on the dual finds τ: S δ = r, S = (e_i·e_j) ∘ (D H⁻¹ Dᵀ), r_j = |e_j|² (|e_j| − 1), exact in one
step for a pendulum. S is dense: right for up to some twenty segments, see `rod_long` beyond.

Scratch is (rows, W); `rows_for` says how many and where things lie. Lane loops do not branch.
"""

from __future__ import annotations

import numpy as np

from ...constants import W
from ...jit import function

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
TWO = np.float32(2.0)
PIVOT = np.float32(1e-6)
LEAST = np.float32(1e-3)
ENOUGH = np.float32(2e-5)
SLACK = np.float32(1e-5)
SPARE = 9
TRIES = 6


def rows_for(n: int) -> int:
    """Rows of scratch for ``n`` segments: e, u, y (3 n each), u*, c̄ (3 n each), τ, τ before, M, κ (n each), d, l, m
    (n each), δ (n), S (n (n + 1) / 2), nine spare."""
    return 23 * n + SPARE + n * (n + 1) // 2


@function
def places(n):
    """Where the parts begin: e, u, y, u*, c̄, τ, τ before, M, κ, d, l1, l2, δ, S, spare."""
    return (
        0, 3 * n, 6 * n, 9 * n, 12 * n, 15 * n, 16 * n, 17 * n, 18 * n, 19 * n, 20 * n, 21 * n, 22 * n,
        23 * n + SPARE, 23 * n,
    )  # fmt: skip


@function
def factor(s, n):
    """H = L diag(d) Lᵀ with two bands; returns whether some lane lost definiteness, which its row of `spare` marks by 1
    (its pivots are replaced by 1, so that nothing overflows)."""
    E, U, Y, A, C, T, TB, M, K, D, L1, L2, DEL, S, X = places(n)
    for k in range(W):
        s[X, k] = ZERO
    for j in range(n):
        t = T + j
        last = j == n - 1
        # P_jj = τ_j + κ_{j−1} + κ_j, where κ row j is the joint before edge j; beyond the tip there is none
        if last:
            for k in range(W):
                s[D + j, k] = s[M + j, k] + s[t, k] + s[K + j, k]
                s[L1 + j, k] = ZERO
                s[L2 + j, k] = ZERO
        else:
            after = K + j + 1
            if j + 2 < n:
                for k in range(W):
                    p = s[t + 1, k] + s[after, k] + s[after + 1, k]
                    s[D + j, k] = s[M + j, k] + s[t, k] + s[K + j, k] + s[after, k] + p + TWO * s[after, k]
                    s[L1 + j, k] = -p - s[after, k] - s[after + 1, k]
                    s[L2 + j, k] = s[after + 1, k]
            else:
                for k in range(W):
                    p = s[t + 1, k] + s[after, k]
                    s[D + j, k] = s[M + j, k] + s[t, k] + s[K + j, k] + s[after, k] + p + TWO * s[after, k]
                    s[L1 + j, k] = -p - s[after, k]
                    s[L2 + j, k] = ZERO
        if j >= 2:
            for k in range(W):
                s[D + j, k] -= s[L2 + j - 2, k] * s[L2 + j - 2, k] * s[D + j - 2, k]
        if j >= 1:
            for k in range(W):
                s[D + j, k] -= s[L1 + j - 1, k] * s[L1 + j - 1, k] * s[D + j - 1, k]
                s[L1 + j, k] -= s[L2 + j - 1, k] * s[D + j - 1, k] * s[L1 + j - 1, k]
        for k in range(W):
            d = s[D + j, k]
            good = d > LEAST * s[M + j, k]
            s[X, k] = s[X, k] if good else ONE
            d = d if good else ONE
            s[D + j, k] = d
            d = ONE / d
            s[L1 + j, k] *= d
            s[L2 + j, k] *= d
    bad = ZERO
    for k in range(W):
        bad = max(bad, s[X, k])
    return bad > ZERO


@function
def substitute(s, n):
    """y = H⁻¹ y in place, for x, y and z."""
    E, U, Y, A, C, T, TB, M, K, D, L1, L2, DEL, S, X = places(n)
    for j in range(1, n):
        for c in range(3):
            o = Y + 3 * j + c
            for k in range(W):
                s[o, k] -= s[L1 + j - 1, k] * s[o - 3, k]
            if j >= 2:
                for k in range(W):
                    s[o, k] -= s[L2 + j - 2, k] * s[o - 6, k]
    for i in range(n):
        j = n - 1 - i
        for c in range(3):
            o = Y + 3 * j + c
            for k in range(W):
                s[o, k] /= s[D + j, k]
            if i >= 1:
                for k in range(W):
                    s[o, k] -= s[L1 + j, k] * s[o + 3, k]
            if i >= 2:
                for k in range(W):
                    s[o, k] -= s[L2 + j, k] * s[o + 6, k]


@function
def residual(s, n, clamp):
    """y := ρ_j = M_j (u*_j − u_j) − (g_j − g_{j+1}), g_j = τ_j e_j + κ_{j−1} (c_{j−1} − c̄_{j−1}) − κ_j (c_j − c̄_j).

    clamp (3 W,): the direction d before the first edge."""
    E, U, Y, A, C, T, TB, M, K, D, L1, L2, DEL, S, X = places(n)
    for j in range(n):
        for c in range(3):
            o = 3 * j + c
            e = E + o
            for k in range(W):
                s[Y + o, k] = s[M + j, k] * (s[A + o, k] - s[U + o, k]) - s[T + j, k] * s[e, k]
            if j == 0:
                for k in range(W):
                    s[Y + o, k] -= s[K, k] * (s[e, k] - clamp[c * W + k] - s[C + o, k])
            else:
                # joint j lies between edges j − 1 and j: its moment pulls on both, and so on three particles
                for k in range(W):
                    b = s[K + j, k] * (s[e, k] - s[e - 3, k] - s[C + o, k])
                    s[Y + o, k] -= b
                    s[Y + o - 3, k] += s[T + j, k] * s[e, k] + b + b
                if j >= 2:
                    for k in range(W):
                        s[Y + o - 6, k] -= s[K + j, k] * (s[e, k] - s[e - 3, k] - s[C + o, k])


@function
def move(s, n):
    """u += y, e += D y."""
    E, U, Y, A, C, T, TB, M, K, D, L1, L2, DEL, S, X = places(n)
    for o in range(3 * n):
        if o < 3:
            for k in range(W):
                s[U + o, k] += s[Y + o, k]
                s[E + o, k] += s[Y + o, k]
        else:
            for k in range(W):
                s[U + o, k] += s[Y + o, k]
                s[E + o, k] += (s[Y + o, k] - s[Y + o - 3, k])


@function
def inverse(s, n):
    """The lower triangle of H⁻¹ into S, from the last column to the first (Takahashi, Fagan & Chin 1973)."""
    E, U, Y, A, C, T, TB, M, K, D, L1, L2, DEL, S, X = places(n)
    for a in range(n):
        j = n - 1 - a
        for b in range(a + 1):
            i = n - 1 - b
            o = S + i * (i + 1) // 2 + j
            if i == j:
                for k in range(W):
                    s[o, k] = ONE / s[D + j, k]
            else:
                for k in range(W):
                    s[o, k] = ZERO
            if j + 1 < n:
                p = S + i * (i + 1) // 2 + j + 1 if i >= j + 1 else S + (j + 1) * (j + 2) // 2 + i
                for k in range(W):
                    s[o, k] -= s[L1 + j, k] * s[p, k]
            if j + 2 < n:
                p = S + i * (i + 1) // 2 + j + 2 if i >= j + 2 else S + (j + 2) * (j + 3) // 2 + i
                for k in range(W):
                    s[o, k] -= s[L2 + j, k] * s[p, k]


@function
def couple(s, n):
    """S := (e_i·e_j) ∘ (D H⁻¹ Dᵀ) in place of H⁻¹, and δ := r."""
    E, U, Y, A, C, T, TB, M, K, D, L1, L2, DEL, S, X = places(n)
    for a in range(n):
        i = n - 1 - a
        ei = E + 3 * i
        for b in range(i + 1):
            j = i - b
            ej = E + 3 * j
            o = S + i * (i + 1) // 2 + j
            up = S + (i - 1) * i // 2 + j
            if i == 0:
                for k in range(W):
                    s[o, k] *= s[ei, k] * s[ej, k] + s[ei + 1, k] * s[ej + 1, k] + s[ei + 2, k] * s[ej + 2, k]
            elif j == 0:
                for k in range(W):
                    dot = s[ei, k] * s[ej, k] + s[ei + 1, k] * s[ej + 1, k] + s[ei + 2, k] * s[ej + 2, k]
                    s[o, k] = (s[o, k] - s[up, k]) * dot
            elif i == j:
                for k in range(W):
                    dot = s[ei, k] * s[ei, k] + s[ei + 1, k] * s[ei + 1, k] + s[ei + 2, k] * s[ei + 2, k]
                    s[o, k] = (s[o, k] - TWO * s[o - 1, k] + s[up - 1, k]) * dot
            else:
                for k in range(W):
                    dot = s[ei, k] * s[ej, k] + s[ei + 1, k] * s[ej + 1, k] + s[ei + 2, k] * s[ej + 2, k]
                    s[o, k] = (s[o, k] - s[up, k] - s[o - 1, k] + s[up - 1, k]) * dot
        for k in range(W):
            q = s[ei, k] * s[ei, k] + s[ei + 1, k] * s[ei + 1, k] + s[ei + 2, k] * s[ei + 2, k]
            size = np.sqrt(q)
            s[DEL + i, k] = q * (size - ONE) if size >= HALF else HALF * (q - ONE)


@function
def solve_dense(s, n):
    """δ := S⁻¹ δ by LDLᵀ without pivoting: S is positive definite by Schur's product theorem. A pivot that rounding has
    taken below a millionth of its entry is raised to that."""
    E, U, Y, A, C, T, TB, M, K, D, L1, L2, DEL, S, X = places(n)
    for j in range(n):
        diagonal = S + j * (j + 1) // 2 + j
        for k in range(W):
            s[diagonal, k] = max(s[diagonal, k], PIVOT * PIVOT * PIVOT)
            s[X, k] = ONE / s[diagonal, k]
        for i in range(j + 1, n):
            row = S + i * (i + 1) // 2
            o = row + j
            for k in range(W):
                s[X + 1, k] = s[o, k] * s[X, k]
            for p in range(j + 1, i + 1):
                other = S + p * (p + 1) // 2 + j
                if p < i:
                    # rows before i hold L already: their S_pj is L_pj d_j
                    for k in range(W):
                        s[row + p, k] -= s[o, k] * s[other, k]
                else:
                    for k in range(W):
                        s[row + p, k] -= s[o, k] * s[X + 1, k]
            for k in range(W):
                s[o, k] = s[X + 1, k]
            for k in range(W):
                s[DEL + i, k] -= s[o, k] * s[DEL + j, k]
    for a in range(n):
        i = n - 1 - a
        diagonal = S + i * (i + 1) // 2 + i
        for k in range(W):
            s[DEL + i, k] /= s[diagonal, k]
        for p in range(i + 1, n):
            o = S + p * (p + 1) // 2 + i
            for k in range(W):
                s[DEL + i, k] -= s[o, k] * s[DEL + p, k]


@function
def tense(s, n):
    """τ += δ, the τ before kept."""
    E, U, Y, A, C, T, TB, M, K, D, L1, L2, DEL, S, X = places(n)
    for j in range(n):
        for k in range(W):
            s[TB + j, k] = s[T + j, k]
            s[T + j, k] += s[DEL + j, k]


@function
def retreat(s, n, last):
    """In the lanes that are marked in `spare`, go back half of the way to the τ before; at `last`, all of it."""
    E, U, Y, A, C, T, TB, M, K, D, L1, L2, DEL, S, X = places(n)
    share = ONE if last else HALF
    for j in range(n):
        for k in range(W):
            back = share * (s[TB + j, k] - s[T + j, k])
            s[T + j, k] += back if s[X, k] > ZERO else ZERO


@function
def dual(s, n, clamp, o):
    """Row o of the scratch: the Lagrangian at x(τ), the concave function of τ that Newton's method climbs; and whether
    a length is still wrong by more than `ENOUGH` in some lane."""
    E, U, Y, A, C, T, TB, M, K, D, L1, L2, DEL, S, X = places(n)
    worst = ZERO
    for k in range(W):
        s[o, k] = ZERO
    for j in range(n):
        e = E + 3 * j
        u = U + 3 * j
        a = A + 3 * j
        for k in range(W):
            q = s[e, k] * s[e, k] + s[e + 1, k] * s[e + 1, k] + s[e + 2, k] * s[e + 2, k] - ONE
            worst = max(worst, abs(q))
            x = s[u, k] - s[a, k]
            y = s[u + 1, k] - s[a + 1, k]
            z = s[u + 2, k] - s[a + 2, k]
            s[o, k] += s[T + j, k] * q + s[M + j, k] * (x * x + y * y + z * z)
        for c in range(3):
            if j == 0:
                for k in range(W):
                    bend = s[e + c, k] - clamp[c * W + k] - s[C + c, k]
                    s[o, k] += s[K, k] * bend * bend
            else:
                for k in range(W):
                    bend = s[e + c, k] - s[e + c - 3, k] - s[C + 3 * j + c, k]
                    s[o, k] += s[K + j, k] * bend * bend
    return worst > ENOUGH


@function
def compare(s, n, new, old):
    """Mark in `spare` the lanes whose dual value fell; whether there are any."""
    X = places(n)[14]
    bad = ZERO
    for k in range(W):
        fell = s[new, k] < s[old, k] - SLACK * (abs(s[old, k]) + SLACK)
        s[X, k] = ONE if fell else ZERO
        bad = max(bad, s[X, k])
    return bad > ZERO


@function
def follow(s, n, clamp):
    """x := x(τ), exactly: the problem is linear. False where H is not definite in some lane, which is then marked."""
    if factor(s, n):
        return False
    residual(s, n, clamp)
    substitute(s, n)
    move(s, n)
    return True


@function
def climb(s, n, clamp):
    """Take the step δ, or as much of it as keeps H definite and the dual from falling. Returns whether lengths are
    still wrong."""
    X = places(n)[14]
    old = X + 2
    new = X + 3
    tense(s, n)
    wrong = True
    for attempt in range(TRIES + 1):
        if follow(s, n, clamp):
            wrong = dual(s, n, clamp, new)
            if attempt == TRIES or not compare(s, n, new, old):
                break
        retreat(s, n, attempt == TRIES - 1)
    for k in range(W):
        s[old, k] = s[new, k]
    return wrong


@function
def iterate(s, n, clamp, iterations):
    """Newton's iterations, at most so many, until the lengths of all lanes are right to `ENOUGH`. Begins with tension
    alone, with which H is definite."""
    X = places(n)[14]
    follow(s, n, clamp)
    wrong = dual(s, n, clamp, X + 2)
    for _ in range(iterations):
        if not wrong:
            break
        inverse(s, n)
        couple(s, n)
        solve_dense(s, n)
        wrong = climb(s, n, clamp)
