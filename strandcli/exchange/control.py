"""Control points of curves and their values, made points on the curves: what readers of Alembic and USD share.

Curves of knots and orders become Bezier curves: the control points of each span are values of its blossom. A span of
degree p between two knots a < b is a polynomial; its Bezier point i is its polar form at a (p - i times) and b (i
times), by de Boor's recursion with another argument at each level (Ramshaw 1989). Lower degrees are raised to 3.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ..common.counted import counted
from ..errors import UsageError
from . import splines
from .splines import Basis
from .strands import Attribute, Domain, Offsets, Points, offsets

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


INTERPOLATIONS: dict[str, Domain] = {
    "vertex": "point", "varying": "point", "uniform": "strand", "constant": "groom",
}  # fmt: skip
"""What a value belongs to, and the domain that it has here: a control point, a joint of pieces, a curve, all of it."""
SPARE = 1 << 26
"""Bytes of points that are made of a file beyond twice its size."""


class Knots(NamedTuple):
    """Orders (S,) of NURBS, and their knots, one curve's after the other's; none where they are uniform."""

    orders: npt.NDArray[Any]
    knots: npt.NDArray[Any]


@dataclass(frozen=True, slots=True, eq=False)
class ControlCurves:
    """Curves of an object: its path, control points of each (S,), what they mean, points of each piece, and how far
    segments are from the curves at most; ``spans``: of NURBS, whose Bezier points the basis is of."""

    path: str
    counts: Offsets
    basis: Basis
    each: int = 1
    off: float = 0.0
    spans: Spans | None = None

    @property
    def in_basis(self) -> Offsets:
        """Control points of each curve (S,) that the basis is of."""
        return self.counts if self.spans is None else self.spans.counts

    def point_counts(self) -> Offsets:
        """Points of each curve (S,)."""
        return splines.new_counts(self.in_basis, self.basis, self.each)

    def points(self, control: npt.NDArray[Any]) -> npt.NDArray[Any]:
        """Points (Q, 3) on the curves of control points (P, 3), or values there of those of control points."""
        if self.basis.plain:
            return control
        control = control if self.spans is None else self.spans.bezier(control)
        return splines.evaluated(self.in_basis, control, self.basis, self.each)

    def attribute(self, name: str, interpolation: str, values: npt.NDArray[Any]) -> Attribute | None:
        """Values (rows, m), single precision where they are floating-point, at points, curves or all; None where
        nothing has so many rows, and of whole numbers between which there would have to be others. What has as many
        rows decides where ``interpolation``, a key of `INTERPOLATIONS` or "", does not fit."""
        counts = self.counts
        control = int(counts.sum())
        joints = control if self.basis.plain else int(self.basis.varying(self.in_basis).sum())
        rows = {"vertex": control, "varying": joints, "uniform": counts.shape[0], "constant": 1}
        if rows.get(interpolation) != values.shape[0]:
            interpolation = next((kind for kind, count in rows.items() if count == values.shape[0]), "")
        if not interpolation:
            return None
        if values.dtype.kind == "f":
            with np.errstate(over="ignore"):
                values = values.astype(np.float32, copy=False)
        domain = INTERPOLATIONS[interpolation]
        if domain == "point" and not self.basis.plain:
            if values.dtype.kind != "f":
                return None
            if interpolation == "varying":
                values = splines.between(self.in_basis, values, self.basis, self.each)
            else:
                values = self.points(values)
            if name == "width":
                values = np.maximum(values, 0)
        return Attribute(domain, values[:, 0] if values.shape[1] == 1 else values)


class Fitter:
    """Says how finely curves of a file are followed, within the memory that a file of its size may take."""

    def __init__(self, size: int, pieces: Sequence[int] = ()) -> None:
        """``size``: bytes of the file; ``pieces``: points a piece of its objects, one after the other, if known."""
        self._known = list(pieces)
        self.pieces: list[int] = []
        """Points a piece of the objects so far, one after the other."""
        self._followed: dict[tuple[str, bool, int], float] = {}
        self.room = 2 * size + SPARE
        """Bytes that points on curves may take."""

    def fitted(
        self, path: str, counts: Offsets, control: Points, basis: Basis, fault: Callable[[str], UsageError],
        knots: Knots | None = None,
    ) -> ControlCurves:  # fmt: skip
        """Curves of control points (P, 3), or of NURBS where there are ``knots``. Raises ``fault`` of the words that
        say why where they are none."""
        if counts.size and int(counts.min()) < 0:
            raise fault(f"{path}: curve {int(np.argmin(counts)):,} has {int(counts.min()):,} points; is damaged")
        if int(counts.sum()) != control.shape[0]:
            raise fault(f"{path}: {control.shape[0]:,} points, the curves have {int(counts.sum()):,}; is damaged")
        if basis.plain:
            return self._noted(ControlCurves(path, counts, basis))
        spans = None if knots is None else spans_of(counts, *knots, lambda words: fault(f"{path}: {words}"))
        in_basis = counts if spans is None else spans.counts
        pieces = basis.pieces(in_basis)
        if (pieces < 0).any():
            worst = int(np.argmin(pieces))
            raise fault(f"{path}: curve {worst:,} has {counts[worst]:,} points, which make no whole pieces of "
                        f"{basis.text}; is damaged")  # fmt: skip
        known = self._known[len(self.pieces)] if len(self.pieces) < len(self._known) else None
        needs = 12 * max(int(pieces.sum()), 1)
        most = min(splines.MOST, self.room // needs)
        if most < 1:
            raise fault(f"{path}: declares more curves than a file of its size can have; is damaged")
        bezier = control if spans is None else spans.bezier(control)
        each, off = splines.points_a_piece(in_basis, bezier, basis, int(most))
        each = each if known is None else min(known, int(most))
        self.room -= each * needs
        return self._noted(ControlCurves(path, counts, basis, each, off, spans))

    def _noted(self, one: ControlCurves) -> ControlCurves:
        key = one.basis.text, one.basis.linear, one.each
        self._followed[key] = max(one.off, self._followed.get(key, 0.0))
        self.pieces.append(one.each)
        return one

    def facts(self) -> dict[str, Any]:
        """Of all curves so far the bases and, where there are cubic ones, how they are followed."""
        facts: dict[str, Any] = {"basis": sorted({text for text, _, _ in self._followed})}
        cubic = {each: off for (_, linear, each), off in self._followed.items() if not linear}
        if cubic:
            off = max(off for (_, linear, _), off in self._followed.items() if not linear)
            facts |= {"points_a_piece": sorted(cubic), "off_the_curves": float(f"{off:.3g}")}
        return facts


def note_of(facts: Mapping[str, Any]) -> str | None:
    """A line that says what is taken of curves that are not straight segments; None where all are."""
    bases = facts.get("basis", ())
    if all(one == splines.LINEAR for one in bases):
        return None
    text = f"curves are {' and '.join(bases)}"
    if "points_a_piece" not in facts:
        return text
    each = " or ".join(str(one) for one in facts["points_a_piece"])
    return f"{text}; points on them are taken, {each} a piece, {facts['off_the_curves']:.3g} off at most"
