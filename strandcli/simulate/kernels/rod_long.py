"""Newton's iteration for long strands: O(N) where `rod.iterate` is O(N³).

The dense S is never formed. δ comes from the system that it is the Schur complement of,

    [ H  Gᵀ ] [  y ]   [ 0 ]
    [ G  0  ] [ −δ ] = [ r ],    (G y)_j = e_j·(y_j − y_{j−1}),

with the three coordinates of a particle and the multiplier of its edge taken together: a symmetric band of half width
8, factored as L D Lᵀ without pivoting. That is safe because H is positive definite, so that each multiplier meets a
negative pivot. For long strands H itself is badly conditioned (as N⁴): these kernels want float64.
"""

from __future__ import annotations

import numpy as np

from ...constants import W
from ...jit import function
from . import rod

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
BAND = 9
TINY = np.float32(1e-30)


def rows_for(n: int) -> int:
    """Rows of scratch for ``n`` segments: those of `rod` up to δ, the spare ones, the band and its right-hand side."""
    return 23 * n + rod.SPARE + 4 * n * (BAND + 1)


@function
def assemble(s, n, F, R):
    """Fill the band: row F + BAND i + b holds entry (i, i + b); right-hand sides in rows R + i.

    Diagonal entries of H are those before factoring, so H is put together here once more."""
    E = 0
    T = 15 * n
    M = 17 * n
    K = 18 * n
    for row in range(4 * n * BAND):
        for k in range(W):
            s[F + row, k] = ZERO
    for row in range(4 * n):
        for k in range(W):
            s[R + row, k] = ZERO
    for j in range(n):
        for c in range(3):
            row = F + BAND * (4 * j + c)
            for k in range(W):
                d = s[M + j, k] + s[T + j, k] + s[K + j, k]
                s[row, k] = d
            if j + 1 < n:
                for k in range(W):
                    p = s[T + j + 1, k] + s[K + j + 1, k]
                    s[row, k] += p + s[K + j + 1, k] * (ONE + ONE + ONE)
                    s[row + 4, k] = -p - s[K + j + 1, k]
            if j + 2 < n:
                for k in range(W):
                    s[row, k] += s[K + j + 2, k]
                    s[row + 4, k] -= s[K + j + 2, k] + s[K + j + 2, k]
                    s[row + 8, k] = s[K + j + 2, k]
            # the edge's own constraint, and that of the edge after it
            for k in range(W):
                s[row + 3 - c, k] = s[E + 3 * j + c, k]
            if j + 1 < n:
                for k in range(W):
                    s[row + 7 - c, k] = -s[E + 3 * j + 3 + c, k]
        e = E + 3 * j
        for k in range(W):
            q = s[e, k] * s[e, k] + s[e + 1, k] * s[e + 1, k] + s[e + 2, k] * s[e + 2, k]
            size = np.sqrt(q)
            s[R + 4 * j + 3, k] = q * (size - ONE) if size >= HALF else HALF * (q - ONE)


@function
def eliminate(s, n, F, R):
    """Factor the band and solve in place: rows R become y (three a particle) and −δ."""
    size = 4 * n
    for i in range(size):
        row = F + BAND * i
        reach = min(BAND - 1, size - 1 - i)
        for k in range(W):
            d = s[row, k]
            d = d if abs(d) > TINY else TINY
            s[row, k] = ONE / d
        for b in range(1, reach + 1):
            # L = A_{i, i+b} / d; the rows below lose L times this row
            for a in range(b, reach + 1):
                for k in range(W):
                    s[row + BAND * b + a - b, k] -= s[row + b, k] * s[row, k] * s[row + a, k]
            for k in range(W):
                s[R + i + b, k] -= s[row + b, k] * s[row, k] * s[R + i, k]
    for back in range(size):
        i = size - 1 - back
        row = F + BAND * i
        reach = min(BAND - 1, size - 1 - i)
        for b in range(1, reach + 1):
            for k in range(W):
                s[R + i, k] -= s[row + b, k] * s[R + i + b, k]
        for k in range(W):
            s[R + i, k] *= s[row, k]


@function
def iterate(s, n, clamp, iterations):
    """As `rod.iterate`."""
    DEL = 22 * n
    X = 23 * n
    F = 23 * n + rod.SPARE
    R = F + 4 * n * BAND
    rod.follow(s, n, clamp)
    wrong = rod.dual(s, n, clamp, X + 2)
    for _ in range(iterations):
        if not wrong:
            break
        assemble(s, n, F, R)
        eliminate(s, n, F, R)
        for j in range(n):
            for k in range(W):
                s[DEL + j, k] = -s[R + 4 * j + 3, k]
        wrong = rod.climb(s, n, clamp)
