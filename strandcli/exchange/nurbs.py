"""Curves of knots and orders as Bezier curves: the control points of each span, which are values of its blossom.

A span of degree p between two knots a < b is a polynomial; its Bezier point i is its polar form at a (p - i times) and
b (i times), by de Boor's recursion with another argument at each level (Ramshaw 1989). Lower degrees are raised to 3.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from ..common.counted import counted
from ..errors import UsageError
from .strands import Offsets, offsets

ORDERS = (2, 3, 4)
"""One more than the degrees that are read."""
RAISED = {
    2: np.array([[3, 0], [2, 1], [1, 2], [0, 3]]) / 3,
    3: np.array([[3, 0, 0], [1, 2, 0], [0, 2, 1], [0, 0, 3]]) / 3,
    4: np.eye(4),
}
"""(4, order): cubic Bezier points of those of lower degree (Farin 2002, 5.1)."""
SLICE = 1 << 15
"""Spans that are converted at once."""


@dataclass(frozen=True, slots=True, eq=False)
class Spans:
    """Spans between knots that differ, N in all: ``counts`` (S,) Bezier points of each curve, 3 a span and one more;
    of each span its order, the knot where it begins, its first control point, and its first Bezier point."""

    knots: npt.NDArray[np.float64]
    counts: Offsets
    orders: Offsets
    begins: Offsets
    rows: Offsets
    places: Offsets

    def bezier(self, values: npt.NDArray[Any]) -> npt.NDArray[np.float64]:
        """Values (Q, m) of the Bezier points, of those of control points (P, m)."""
        out = np.empty((int(self.counts.sum()), values.shape[1]))
        with np.errstate(over="ignore", invalid="ignore"):  # of values that are not finite
            for order in ORDERS:
                chosen = np.flatnonzero(self.orders == order)
                for begin in range(0, chosen.size, SLICE):
                    some = chosen[begin : begin + SLICE]
                    weights = RAISED[order] @ blossoms(self.knots, self.begins[some], order)
                    control = values[self.rows[some][:, None] + np.arange(order)].astype(np.float64)
                    out[self.places[some][:, None] + np.arange(4)] = np.einsum("nbc,ncm->nbm", weights, control)
        return out


def blossoms(knots: npt.NDArray[np.float64], begins: Offsets, order: int) -> npt.NDArray[np.float64]:
    """(n, order, order): what control points give to Bezier points of spans that begin at knots of these numbers."""
    degree = order - 1
    near = knots[begins[:, None] + np.arange(1 - degree, degree + 1)]
    found = np.empty((begins.size, order, order))
    for point in range(order):
        part = np.broadcast_to(np.eye(order), (begins.size, order, order))
        for level in range(1, order):
            at = near[:, degree if level <= point else degree - 1]
            low, high = near[:, level - 1 : degree], near[:, degree : 2 * degree - level + 1]
            share = ((at[:, None] - low) / (high - low))[:, :, None]
            part = (1 - share) * part[:, :-1] + share * part[:, 1:]
        found[:, point] = part[:, 0]
    return found


def spans_of(
    counts: Offsets, orders: npt.NDArray[Any], knots: npt.NDArray[Any], fault: Callable[[str], UsageError]
) -> Spans:
    """The spans of curves of so many control points and of these orders (S,), whose knots (K,) follow one another, as
    many of each as points and order; uniform ones where there are none. Raises ``fault`` where they make no curves."""
    if orders.shape != counts.shape:
        raise fault(f"NURBS have {counted(orders.size, 'order')} for {counted(counts.size, 'curve')}; is damaged")
    if not np.isin(orders, ORDERS).all():
        raise fault(f"NURBS are read of order 2, 3 and 4; there are some of {orders[~np.isin(orders, ORDERS)][0]}")
    orders = orders.astype(np.int64)
    first = offsets(counts + orders)
    if not knots.size:
        knots = np.arange(int(first[-1]))
    if knots.size != first[-1]:
        raise fault(f"NURBS have {knots.size:,} knots, {int(first[-1]):,} are needed: points and order of each curve")
    knots = knots.astype(np.float64)
    curve = np.repeat(np.arange(counts.size), counts + orders)
    place = np.arange(knots.size) - first[curve]
    step = np.diff(knots, append=np.inf)
    inner = place < (counts + orders)[curve] - 1
    if not (step[inner] >= 0).all() or not np.isfinite(knots).all():
        raise fault("knots of NURBS do not rise")
    begins = np.flatnonzero((place >= orders[curve] - 1) & (place < counts[curve]) & inner & (step > 0))
    curve = curve[begins]
    pieces = np.bincount(curve, minlength=counts.size)
    bezier = np.where(pieces > 0, 3 * pieces + 1, 0)
    number = np.arange(begins.size) - offsets(pieces)[curve]
    rows = offsets(counts)[curve] + begins - first[curve] - orders[curve] + 1
    return Spans(knots, bezier, orders[curve], begins, rows, offsets(bezier)[curve] + 3 * number)
