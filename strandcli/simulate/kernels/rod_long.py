"""Newton's iteration for long strands: O(N) where `rod.iterate` is O(N³).

The dense S is never formed. δ comes from the system that it is the Schur complement of,

    [ H  Gᵀ ] [  y ]   [ 0 ]
    [ G  0  ] [ −δ ] = [ r ],    (G y)_j = e_j·(y_j − y_{j−1}),

with the three coordinates of a particle and the multiplier of its edge taken together: a symmetric band of half width
8, factored as L D Lᵀ without pivoting, each segment right after it has been put together. That is safe because H is
positive definite, so that each multiplier meets a negative pivot. For long strands H itself is badly conditioned (as
N⁴): these kernels want float64.
"""

from __future__ import annotations

import numpy as np

from ...constants import W
from ...jit import inner
from . import rod
from .rod import FIRST, LANES, ONE, SEGMENT, SHORT, TH, THREE, TINY, U1, U2, U3, U4, ZERO, E, K, M, R, T

BAND = np.uint64(9)
ROW = np.uint64(10 * W)
"""A row of the band, diagonal first, and its right-hand side."""
RHS = np.uint64(9 * W)


def size_for(n: int) -> int:
    """As `rod.size_for`, with the band in place of S."""
    return int(FIRST) + (n + 2) * int(SEGMENT) + (n + 2) * 4 * int(ROW)


@inner
def assemble(s, n, j, t):
    """The four rows of segment j, entries (i, i + b) in row b of each; t: the field of force densities in H."""
    o = FIRST + j * SEGMENT
    here = FIRST + (n + U2) * SEGMENT + j * U4 * ROW
    for k in range(U4 * ROW):
        s[here + k] = ZERO
    for c in range(U3):
        row = here + c * ROW
        e = o + E + c * LANES
        # the edge's own constraint, and that of the edge after it: beyond the tip edges are zero
        mine = row + (U3 - c) * LANES
        next = row + (U4 + U3 - c) * LANES
        for k in range(LANES):
            k1 = s[o + SEGMENT + K + k]
            k2 = s[o + U2 * SEGMENT + K + k]
            p = s[o + SEGMENT + t + k] + k1 + k2
            s[row + k] = s[o + M + k] + s[o + t + k] + s[o + K + k] + THREE * k1 + p
            s[row + U4 * LANES + k] = -p - k1 - k2
            s[row + U4 * U2 * LANES + k] = k2
        for k in range(LANES):
            s[mine + k] = s[e + k]
        for k in range(LANES):
            s[next + k] = -s[e + SEGMENT + k]
    row = here + U3 * ROW
    for k in range(LANES):
        x = s[o + E + k]
        y = s[o + E + LANES + k]
        z = s[o + E + U2 * LANES + k]
        s[row + k] = -max(SHORT - (x * x + y * y + z * z), ZERO) / s[o + M + k]
        s[row + RHS + k] = s[o + R + k]


@inner
def eliminate(s, n, i):
    """Row i: those below it lose their multiples of it."""
    row = FIRST + (n + U2) * SEGMENT + i * ROW
    for k in range(LANES):
        d = s[row + k]
        s[row + k] = ONE / (d if abs(d) > TINY else TINY)
    reach = min(BAND - U1, n * U4 - U1 - i)
    for b in range(U1, reach + U1):
        below = row + b * ROW
        mine = row + b * LANES
        for k in range(LANES):
            s[rod.SPARE + k] = s[mine + k] * s[row + k]
        for a in range(b, reach + U1):
            take(s, below + (a - b) * LANES, row + a * LANES)
        take(s, below + RHS, row + RHS)


@inner
def take(s, target, source):
    """A row loses the product of another and row SPARE."""
    for k in range(LANES):
        s[target + k] -= s[source + k] * s[rod.SPARE + k]


@inner
def substitute(s, n):
    """Backward through the band; τ += δ."""
    base = FIRST + (n + U2) * SEGMENT
    size = n * U4
    for back in range(size):
        i = size - U1 - back
        row = base + i * ROW
        reach = min(BAND - U1, back)
        for b in range(U1, reach + U1):
            a = row + b * LANES
            x = row + b * ROW + RHS
            for k in range(LANES):
                s[row + RHS + k] -= s[a + k] * s[x + k]
        for k in range(LANES):
            s[row + RHS + k] *= s[row + k]
    for j in range(n):
        o = FIRST + j * SEGMENT + T
        x = base + (j * U4 + U3) * ROW + RHS
        for k in range(LANES):
            s[o + k] -= s[x + k]


@inner
def iterate(s, n, iterations, enough):
    """As `rod.iterate`."""
    worst = ZERO
    for count in range(-1, iterations + 1):
        if count > 1 and worst <= enough:
            break
        if count == 0:
            if not worst > rod.WILD:
                continue
            rod.pull(s, n)
        if count > 0:
            t = TH if s[rod.HARD] > ZERO else T
            if worst > rod.FAR or t == TH:
                rod.retract(s, n)
                rod.change(s, n)
            else:
                rod.still(s, n)
            rod.demand(s, n)
            for j in range(n + U2):
                if j < n:
                    assemble(s, n, j, t)
                if j >= U2:
                    for c in range(U4):
                        eliminate(s, n, (j - U2) * U4 + c)
            substitute(s, n)
        rod.factor(s, n)
        rod.change(s, n)
        if count > rod.PATIENCE:
            rod.shorten(s, n, rod.STRIDES / np.float32(count - rod.PATIENCE))
        worst = rod.move(s, n)
    return worst
