"""Integration on [0, 1] by Gauss-Legendre collocation: what the references' boundary-value problems are solved with.

A problem is written as an integral equation, whose matrix is as well conditioned as the problem itself (that of a
differentiated polynomial is not), so that smooth solutions are had to nearly all digits with a few dozen nodes.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Interval:
    """Nodes of [0, 1] and what integrates functions that are given there."""

    nodes: Array
    """(n,) ascending."""
    weights: Array
    """(n,): the integral over all of [0, 1] is weights @ values."""
    below: Array
    """(n, n): (below @ values)[i] is the integral from 0 to node i."""
    above: Array
    """(n, n): the integral from node i to 1."""

    def at(self, values: Array, points: Array) -> Array:
        """The polynomial through the values (n, ...) at nodes, evaluated at points (m,) of [0, 1]: (m, ...)."""
        degrees = len(self.nodes) - 1
        return np.asarray(legendre.legvander(2 * points - 1, degrees) @ (_analysis(degrees + 1) @ values))

    def running(self, values: Array, points: Array) -> Array:
        """The integral of that polynomial from 0 to each of the points (m,): (m, ...)."""
        n = len(self.nodes)
        return np.asarray(_primitives(2 * points - 1, n) @ (_analysis(n) @ values))


@cache
def interval(n: int) -> Interval:
    """[0, 1] with n nodes: exact for polynomials of degree n − 1, and integrals over all of it up to 2 n − 1."""
    x, w = legendre.leggauss(n)
    below = _primitives(x, n) @ _analysis(n)
    return Interval((x + 1) / 2, w / 2, below, np.broadcast_to(w / 2, (n, n)) - below)


def _analysis(n: int) -> Array:
    """(n, n): Legendre coefficients of the polynomial through values at the n nodes."""
    x, w = legendre.leggauss(n)
    return np.asarray((np.arange(n) + 0.5)[:, None] * legendre.legvander(x, n - 1).T * w)


def _primitives(x: Array, n: int) -> Array:
    """(len(x), n): integrals of the Legendre polynomials P_0 … P_{n−1} from −1 to x, halved, [0, 1] being half as long:
    ∫ P_k = (P_{k+1} − P_{k−1}) / (2 k + 1)."""
    p = legendre.legvander(x, n)
    out = np.empty((len(x), n))
    out[:, 0] = x + 1
    k = np.arange(1, n)
    out[:, 1:] = (p[:, 2:] - p[:, :-2]) / (2 * k + 1)
    return out / 2
