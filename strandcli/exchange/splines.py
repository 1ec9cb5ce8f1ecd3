"""Points on the curves that files of Alembic and USD describe by control points.

Weights are those of Bezier curves, uniform cubic B-splines and Catmull-Rom splines as UsdGeomBasisCurves and AbcGeom
have them, both after RenderMan's RiCurves; a piece is a cubic polynomial between two values of its parameter, 0 and 1.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from ..errors import UsageError
from .strands import Attribute, Domain, Offsets, Points, offsets

LINEAR, CUBIC = "linear", "cubic"
BEZIER, BSPLINE, CATMULL_ROM = "bezier", "bspline", "catmullRom"
MATRICES = {
    BEZIER: np.array([[1, 0, 0, 0], [-3, 3, 0, 0], [3, -6, 3, 0], [-1, 3, -3, 1]], np.float64),
    BSPLINE: np.array([[1, 4, 1, 0], [-3, 0, 3, 0], [3, -6, 3, 0], [-1, 3, -3, 1]], np.float64) / 6,
    CATMULL_ROM: np.array([[0, 2, 0, 0], [-1, 0, 1, 0], [2, -5, 4, -1], [-1, 3, -3, 1]], np.float64) / 2,
}
"""(4, 4) of each basis: row i has what each of the four control points gives to the power i of the parameter."""
NURBS, STRAIGHT = "NURBS", "joined straight"
WRAPS = ("nonperiodic", "periodic", "pinned")
EACH = 4
"""Points of a piece; fewer where they would take more memory than a file of its size may."""
SLICE = 1 << 16
"""Pieces that are evaluated at once."""
SPARE = 1 << 26
"""Bytes of points that are made of a file beyond twice its size."""
INTERPOLATIONS: dict[str, Domain] = {
    "vertex": "point", "varying": "point", "uniform": "strand", "constant": "groom",
}  # fmt: skip
"""What a value belongs to, and the domain that it has here: a control point, a joint of pieces, a curve, all of it."""


@dataclass(frozen=True, slots=True)
class Basis:
    """What control points mean: ``type`` is "linear" or "cubic", ``name`` a key of `MATRICES`, ``wrap`` one of
    `WRAPS`; ``label``: what the file says they are, where it is something else."""

    type: str
    name: str = BEZIER
    wrap: str = "nonperiodic"
    label: str = ""

    @property
    def text(self) -> str:
        """In words."""
        kind = self.label or (LINEAR if self.type == LINEAR else f"{CUBIC} {self.name}")
        return kind if self.label or self.wrap == "nonperiodic" else f"{kind}, {self.wrap}"

    @property
    def plain(self) -> bool:
        """Whether control points are the points."""
        return self.type == LINEAR and self.wrap != "periodic"

    @property
    def size(self) -> int:
        """Control points of a piece."""
        return 2 if self.type == LINEAR else 4

    @property
    def step(self) -> int:
        """Control points from a piece to the next one."""
        return 3 if self.type == CUBIC and self.name == BEZIER else 1

    @property
    def extended(self) -> bool:
        """Whether a control point is added at each end, so that curves reach those that there are."""
        return self.wrap == "pinned" and self.type == CUBIC and self.step == 1

    def pieces(self, counts: Offsets) -> Offsets:
        """Pieces of curves of so many control points each (S,): 0 where they are too few, -1 where they do not divide
        into pieces."""
        if self.wrap == "periodic":
            whole = np.where(counts >= 3, counts, 0)
        else:
            whole = np.maximum(counts - self.size + self.step + 2 * self.extended * (counts >= 2), 0)
        return np.where(whole < self.step, 0, np.where(whole % self.step, -1, whole // self.step))

    def joints(self, counts: Offsets) -> Offsets:
        """Values of each curve (S,) that belong to where pieces begin and end."""
        pieces = self.pieces(counts)
        return np.where(pieces > 0, pieces + (self.wrap != "periodic"), counts if self.plain else 0)

    def weights(self, each: int) -> npt.NDArray[np.float64]:
        """(each + 1, 4) or (each + 1, 2): what control points give at parameters 0, 1 / each … 1."""
        t = np.arange(each + 1) / each
        if self.type == LINEAR:
            return np.stack([1 - t, t], axis=1)
        return np.asarray(np.stack([t**0, t, t * t, t**3], axis=1) @ MATRICES[self.name])

    def bends(self) -> npt.NDArray[np.float64]:
        """(2, 4) or (2, 2): what control points give to the second derivative where a piece begins and ends."""
        if self.type == LINEAR:
            return np.zeros((2, 2))
        square, cube = MATRICES[self.name][2:]
        return np.stack([2 * square, 2 * square + 6 * cube])


def of_nurbs(orders: npt.NDArray[Any], knots: npt.NDArray[Any], wrap: str = "nonperiodic") -> Basis:
    """What control points of NURBS mean. Those of order 4 are taken as uniform B-splines, which reach their ends where
    the first knots are the same; the rest are joined straight."""
    if not orders.size or (orders != 4).any():
        return Basis(LINEAR, wrap=wrap, label=f"{NURBS} of other orders than 4, {STRAIGHT}")
    return Basis(CUBIC, BSPLINE, "pinned" if knots.size > 2 and knots[0] == knots[2] else wrap, NURBS)


@dataclass(frozen=True, slots=True, eq=False)
class ControlCurves:
    """Curves of an object: its path, control points of each (S,), what they mean, and points of each piece."""

    path: str
    counts: Offsets
    basis: Basis
    each: int = 1

    def point_counts(self) -> Offsets:
        """Points of each curve (S,); 0 of those without a piece."""
        if self.basis.plain:
            return self.counts
        pieces = self.basis.pieces(self.counts)
        return np.where(pieces > 0, pieces * self.each + 1, 0)

    def points(self, control: npt.NDArray[Any]) -> tuple[npt.NDArray[Any], float]:
        """Points (Q, 3) on the curves of control points (P, 3), or values there of those of control points; and how far
        the curves are at most from the segments between these."""
        if self.basis.plain:
            return control, 0.0
        counts = self.counts
        if self.basis.extended:
            control, counts = _extended(control, counts)
        return self._evaluated(control, counts, self.basis)

    def between(self, values: npt.NDArray[Any]) -> npt.NDArray[Any]:
        """Values (Q, m) at the points, linear between those where pieces begin and end (V, m)."""
        return self._evaluated(values, self.basis.joints(self.counts), Basis(LINEAR, wrap=self.basis.wrap))[0]

    def _evaluated(
        self, values: npt.NDArray[Any], counts: Offsets, basis: Basis
    ) -> tuple[npt.NDArray[np.float32], float]:
        """Values (Q, m) along curves, whose control points in a basis have values, so many of each (S,), and how far
        those between are at most from linear ones."""
        pieces = np.maximum(self.basis.pieces(self.counts), 0)
        curve = np.repeat(np.arange(counts.size), pieces)
        number = np.arange(curve.size) - offsets(pieces)[curve]
        first, after = offsets(counts), offsets(self.point_counts())
        out = np.empty((int(after[-1]), values.shape[1]), np.float32)
        weights, place = basis.weights(self.each), np.arange(basis.size)
        bends, bent = basis.bends(), 0.0
        with np.errstate(over="ignore", invalid="ignore"):
            for begin in range(0, curve.size, SLICE):
                of, at = curve[begin : begin + SLICE, None], number[begin : begin + SLICE, None]
                rows = basis.step * at + place
                rows = first[of] + (rows % np.maximum(counts[of], 1) if basis.wrap == "periodic" else rows)
                near = values[rows].astype(np.float64)
                made = np.einsum("tw,nwm->ntm", weights, near)
                out[after[of] + self.each * at + np.arange(self.each + 1)] = made
                bent = max(bent, float((np.einsum("tw,nwm->ntm", bends, near) ** 2).sum(2).max(initial=0.0)))
        # an eighth of the second derivative, which is linear along a piece, times the squared length of a segment
        return out, float(np.sqrt(bent)) / (8 * self.each**2)

    def attribute(self, name: str, interpolation: str, values: npt.NDArray[Any]) -> Attribute | None:
        """Values (rows, m), single precision where they are floating-point, at points, curves or all; None where
        nothing has so many rows, and of whole numbers between which there would have to be more. What has as many
        rows decides where ``interpolation``, a key of `INTERPOLATIONS` or "", does not fit."""
        joints = int(self.basis.joints(self.counts).sum())
        rows = {"vertex": int(self.counts.sum()), "varying": joints, "uniform": self.counts.size, "constant": 1}
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
            values = self.between(values) if interpolation == "varying" else self.points(values)[0]
            if name == "width":
                values = np.maximum(values, 0)
        return Attribute(domain, values[:, 0] if values.shape[1] == 1 else values)


def _extended(values: npt.NDArray[Any], counts: Offsets) -> tuple[npt.NDArray[Any], Offsets]:
    """Values of control points (P, m) with one more before and behind those of each curve, on the line through its
    first two and its last two, and how many each has then."""
    first = offsets(counts)
    more = np.where(counts >= 2, counts + 2, counts)
    begins, has = offsets(more)[:-1], counts >= 2
    found = np.empty((int(more.sum()), values.shape[1]))
    found[np.arange(len(values)) + np.repeat(begins + has - first[:-1], counts)] = values
    low, high = begins[has], begins[has] + more[has] - 1
    with np.errstate(over="ignore", invalid="ignore"):
        found[low] = 2 * found[low + 1] - found[low + 2]
        found[high] = 2 * found[high - 1] - found[high - 2]
    return found, more


class Fitter:
    """Says how many points curves of a file get, within the memory that a file of its size may take."""

    def __init__(self, size: int) -> None:
        """``size``: bytes of the file."""
        self._followed: set[tuple[str, int]] = set()
        self.departure = 0.0
        """How far curves are at most from the segments between the points that are taken of them."""
        self.room = 2 * size + SPARE
        """Bytes that points on curves may take."""

    def fitted(
        self, path: str, counts: Offsets, control: Points, basis: Basis, fault: Callable[[str], UsageError]
    ) -> ControlCurves:
        """Curves of control points (P, 3). Raises ``fault`` of the words that say why where they are none."""
        if counts.size and int(counts.min()) < 0:
            raise fault(f"{path}: curve {int(np.argmin(counts)):,} has {int(counts.min()):,} points; is damaged")
        if int(counts.sum()) != control.shape[0]:
            raise fault(f"{path}: {control.shape[0]:,} points, the curves have {int(counts.sum()):,}; is damaged")
        each = 1
        if not basis.plain:
            pieces = basis.pieces(counts)
            if (pieces < 0).any():
                worst = int(np.argmin(pieces))
                raise fault(f"{path}: curve {worst:,} has {counts[worst]:,} points, which make no whole pieces of "
                            f"{basis.text}; is damaged")  # fmt: skip
            needs = 12 * max(int(pieces.sum()), 1)
            each = min(EACH if basis.type == CUBIC else 1, self.room // needs)
            if each < 1:
                raise fault(f"{path}: declares more curves than a file of its size can have; is damaged")
            self.room -= each * needs
        self._followed.add((basis.text, each if basis.type == CUBIC else 0))
        return ControlCurves(path, counts, basis, each)

    def facts(self) -> dict[str, Any]:
        """Of all curves so far the bases and, where there are cubic ones, the points of a piece, and how far off their
        segments are at most, in units of the file before it places its objects."""
        facts: dict[str, Any] = {"basis": sorted({text for text, _ in self._followed})}
        cubic = sorted({each for _, each in self._followed if each})
        return {**facts, **({"points_a_piece": cubic, "off_curves": float(f"{self.departure:.2g}")} if cubic else {})}


def note_of(facts: Mapping[str, Any]) -> str | None:
    """A line that says what is taken of curves that are not straight segments; None where all are."""
    bases = facts.get("basis", ())
    if all(one == LINEAR for one in bases):
        return None
    text = f"curves are {' and '.join(bases)}"
    if "points_a_piece" not in facts:
        return text
    each = " or ".join(str(one) for one in facts["points_a_piece"])
    return f"{text}; {each} points a piece are taken, whose segments leave them by {facts['off_curves']:g} at most"
