"""The change of the force densities for short strands: S is formed and factored, O(N³) with the least of constants.

Scratch, after the segments: two rows an edge, and S as a square of rows and one row more, of which the lower triangle
is used.
"""

from __future__ import annotations

from ...jit import inlined, inner
from ...simd import get, get3, put, spread
from .rod import DI, FIRST, N1, N2, SEGMENT, TINY, E, R, aim, demand, rows_for

SHORT = 1 / 16
"""|e|² below which an edge has hardly a direction left: S then takes this."""
PIVOT = 1e-6


def size_for(n: int) -> int:
    """Vectors of scratch for ``n`` segments."""
    return rows_for(n) + n * (n + 3)


@inner
def couple(s, n, foreseen):
    """r, and the lower triangle of S = (e_i·e_j) ∘ P, column by column. ``foreseen``: r is what is left of it after the
    change that loads ask for, as `rod.foresee` has found it.

    P, the covariances of z where that of y is H⁻¹, follows from the process that elimination leaves, root to tip:
    z_j = i κ z_{j−1} − i B y_{j−1} + noise of variance i. a, b, c: variances of y and z and their covariance."""
    square = aim(n, n) + 2 * n
    a = spread(s, 0.0)
    b = a
    c = a
    for j in range(n):
        o = FIRST + j * SEGMENT
        f = get(s, o + N1)
        g = get(s, o + N2)
        x, y, z = get3(s, o + E, 1)
        d = f * b - g * a
        c = f * (f * c - g * b) - g * d + get(s, o + DI)
        b = d + c
        a += d + b
        q = x * x + y * y + z * z
        r = demand(q)
        if foreseen:
            r += get(s, o + R)
        put(s, o + R, r)
        put(s, square + j * n + j, c * max(q, SHORT))
        u = b
        v = c
        for i in range(j + 1, n):
            o = FIRST + i * SEGMENT
            v = get(s, o + N1) * v - get(s, o + N2) * u
            u += v
            ex, ey, ez = get3(s, o + E, 1)
            put(s, square + i * n + j, v * (x * ex + y * ey + z * ez))


@inner
def solve(s, n):
    """The first half of S⁻¹ r by S = L diag(d) Lᵀ, column by column without pivoting. S is positive
    definite by Schur's product theorem; a pivot that rounding has taken below a millionth of its entry is raised to
    that. Below the diagonal columns hold L times their pivots."""
    pivots = aim(n, n)
    line = pivots + n
    square = pivots + 2 * n
    for j in range(n):
        row = square + j * n
        d = get(s, row + j)
        least = max(PIVOT * d, TINY)
        z = get(s, FIRST + j * SEGMENT + R)
        for k in range(j):
            c = get(s, row + k)
            lower = c * get(s, pivots + k)
            put(s, line + k, lower)
            d -= c * lower
            z -= lower * get(s, FIRST + k * SEGMENT + R)
        put(s, FIRST + j * SEGMENT + R, z)
        put(s, pivots + j, 1.0 / max(d, least))
        # rows two by two, for they share what they read; there is one more than needed
        for i in range(j + 1, n, 2):
            other = square + i * n
            a = get(s, other + j)
            b = get(s, other + n + j)
            for k in range(j):
                lower = get(s, line + k)
                a -= get(s, other + k) * lower
                b -= get(s, other + n + k) * lower
            put(s, other + j, a)
            put(s, other + n + j, b)


@inlined
def substitute(s, n, j):
    """The last half of S⁻¹ r, a number at a time from the tip on: the change of a segment's τ."""
    square = aim(n, n) + 2 * n
    x = get(s, FIRST + j * SEGMENT + R)
    for i in range(n - 1, j, -1):
        x -= get(s, square + i * n + j) * get(s, FIRST + i * SEGMENT + R)
    x *= get(s, square - 2 * n + j)
    put(s, FIRST + j * SEGMENT + R, x)
    return x
