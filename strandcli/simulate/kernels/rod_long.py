"""The change of the force densities for long strands: O(N) where `rod_dense` is O(N³).

The dense S is never formed. δ comes from the system that it is the Schur complement of,

    [ H  Gᵀ ] [  y ]   [ 0 ]
    [ G  0  ] [ −δ ] = [ r ],    (G y)_j = e_j·(y_j − y_{j−1}),

with the three coordinates of a particle and the multiplier of its edge taken together: a symmetric band of half width
8, factored as L D Lᵀ without pivoting, each segment right after it has been put together. That is safe because H is
positive definite, so that each multiplier meets a negative pivot. For long strands H itself is badly conditioned (as
N⁴): these kernels want float64.
"""

from __future__ import annotations

from ...constants import V
from ...jit import inner
from .rod import FIRST, SEGMENT, TINY, E, K, M, R, T, rows_for
from .rod_dense import SHORT
from .simd import get, get3, put, where

BAND = 9
ROW = 10 * V
"""A row of the band, diagonal first, and its right-hand side."""
RHS = 9 * V


def size_for(n: int) -> int:
    """Numbers of scratch for ``n`` segments."""
    return rows_for(n) + (n + 2) * 4 * ROW


@inner
def newton(s, n, t):
    """τ += δ; t: the field of force densities in H."""
    for j in range(n + 2):
        if j < n:
            assemble(s, n, j, t)
        if j >= 2:
            for c in range(4):
                eliminate(s, n, (j - 2) * 4 + c)
    substitute(s, n)


@inner
def assemble(s, n, j, t):
    """The four rows of segment j, entries (i, i + b) in row b of each."""
    o = FIRST + j * SEGMENT
    here = FIRST + (n + 2) * SEGMENT + j * 4 * ROW
    for i in range(40):
        put(s, here + i * V, 0.0)
    k1 = get(s, o + SEGMENT + K)
    k2 = get(s, o + 2 * SEGMENT + K)
    p = get(s, o + SEGMENT + t) + k1 + k2
    mass = get(s, o + M)
    d = mass + get(s, o + t) + get(s, o + K) + 3.0 * k1 + p
    l1 = -p - k1 - k2
    for c in range(3):
        row = here + c * ROW
        put(s, row, d)
        put(s, row + 4 * V, l1)
        put(s, row + 8 * V, k2)
        # the edge's own constraint, and that of the edge after it: beyond the tip edges are zero
        put(s, row + (3 - c) * V, get(s, o + E + c * V))
        put(s, row + (7 - c) * V, -get(s, o + SEGMENT + E + c * V))
    x, y, z = get3(s, o + E, V)
    put(s, here + 3 * ROW, -max(SHORT - (x * x + y * y + z * z), 0.0) / mass)
    put(s, here + 3 * ROW + RHS, get(s, o + R))


@inner
def eliminate(s, n, i):
    """Row i: those below it lose their multiples of it."""
    row = FIRST + (n + 2) * SEGMENT + i * ROW
    d = get(s, row)
    d = 1.0 / where(abs(d) > TINY, d, TINY)
    put(s, row, d)
    reach = min(BAND - 1, n * 4 - 1 - i)
    rhs = get(s, row + RHS)
    for b in range(1, reach + 1):
        below = row + b * ROW
        f = get(s, row + b * V) * d
        for a in range(b, reach + 1):
            o = below + (a - b) * V
            put(s, o, get(s, o) - get(s, row + a * V) * f)
        put(s, below + RHS, get(s, below + RHS) - rhs * f)


@inner
def substitute(s, n):
    """Backward through the band; τ += δ."""
    base = FIRST + (n + 2) * SEGMENT
    size = n * 4
    for back in range(size):
        row = base + (size - 1 - back) * ROW
        x = get(s, row + RHS)
        for b in range(1, min(BAND - 1, back) + 1):
            x -= get(s, row + b * V) * get(s, row + b * ROW + RHS)
        put(s, row + RHS, x * get(s, row))
    for j in range(n):
        o = FIRST + j * SEGMENT + T
        put(s, o, get(s, o) - get(s, base + (j * 4 + 3) * ROW + RHS))
