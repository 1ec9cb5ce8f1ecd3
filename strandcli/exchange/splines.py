"""Points on the curves that files of Alembic and USD describe by control points.

Weights are those of Bezier and Hermite curves, uniform cubic B-splines and Catmull-Rom splines as the schemas
UsdGeomBasisCurves and AbcGeom's ICurves have them, both after RenderMan's RiCurves; a piece is a cubic polynomial
between two values of its parameter, 0 and 1.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from .strands import Offsets, offsets

LINEAR, CUBIC = "linear", "cubic"
BEZIER, BSPLINE, CATMULL_ROM, HERMITE = "bezier", "bspline", "catmullRom", "hermite"
MATRICES = {
    BEZIER: np.array([[1, 0, 0, 0], [-3, 3, 0, 0], [3, -6, 3, 0], [-1, 3, -3, 1]], np.float64),
    BSPLINE: np.array([[1, 4, 1, 0], [-3, 0, 3, 0], [3, -6, 3, 0], [-1, 3, -3, 1]], np.float64) / 6,
    CATMULL_ROM: np.array([[0, 2, 0, 0], [-1, 0, 1, 0], [2, -5, 4, -1], [-1, 3, -3, 1]], np.float64) / 2,
    HERMITE: np.array([[1, 0, 0, 0], [0, 1, 0, 0], [-3, -2, 3, -1], [2, 1, -2, 1]], np.float64),
}
"""(4, 4) of each basis: row i has what each of the four control points gives to the power i of the parameter. Those of
Hermite curves are in turn a point and the tangent there."""
STEPS = {BEZIER: 3, HERMITE: 2}
"""Control points from a piece to the next one, where they are not 1."""
WRAPS = ("nonperiodic", "periodic", "pinned")
FINE = 1e-3
"""Distance of a strand's segments from its curve, over the median length of the control polygons, that is aimed at."""
MOST = 16
"""Points of a piece, at most."""
MOST_OUTLIERS = 0.01
"""Share of the strands that may be off by more than `FINE`."""
SLICE = 1 << 18
"""Points that are made at once."""

Floats = npt.NDArray[np.float64]


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
        if self.label:
            return self.label
        kind = LINEAR if self.linear else f"{CUBIC} {self.name}"
        return kind if self.wrap == "nonperiodic" else f"{kind}, {self.wrap}"

    @property
    def linear(self) -> bool:
        """Whether control points are joined by straight segments."""
        return self.type == LINEAR

    @property
    def periodic(self) -> bool:
        """Whether curves end where they begin."""
        return self.wrap == "periodic"

    @property
    def plain(self) -> bool:
        """Whether control points are the points."""
        return self.linear and not self.periodic

    @property
    def step(self) -> int:
        """Control points from a piece to the next one."""
        return 1 if self.linear else STEPS.get(self.name, 1)

    @property
    def shared(self) -> int:
        """Control points that a piece has in common with the next one."""
        return 4 - self.step

    def pieces(self, counts: Offsets) -> Offsets:
        """Pieces of curves of so many control points each (S,): 0 where they are too few, -1 where they do not
        divide into pieces."""
        if self.linear:
            found = counts if self.periodic else counts - 1
            return np.where(counts >= 2, found, 0)
        if self.step > 1:
            left = counts if self.periodic else counts - self.shared
            return np.where(left < self.step, 0, np.where(left % self.step, -1, left // self.step))
        if self.wrap == "pinned":
            return np.where(counts >= 2, counts - 1, 0)
        return np.where(counts >= 3, counts, 0) if self.periodic else np.maximum(counts - 3, 0)

    def varying(self, counts: Offsets) -> Offsets:
        """Values of each curve (S,) that belong to where pieces begin and end."""
        pieces = self.pieces(counts)
        return np.where(pieces > 0, pieces + (not self.periodic), np.maximum(counts, 0) if self.plain else 0)


def extended(values: Floats, basis: Basis) -> Floats:
    """Values of control points (k, n, m), with those that the wrap adds before and behind them."""
    if basis.periodic:
        more = 1 if basis.linear else basis.shared
        return np.concatenate([values, values[:, :more]], axis=1)
    if basis.wrap == "pinned" and not basis.linear and basis.step == 1:
        before, behind = 2 * values[:, :1] - values[:, 1:2], 2 * values[:, -1:] - values[:, -2:-1]
        return np.concatenate([before, values, behind], axis=1)
    return values


def windows(values: Floats, basis: Basis) -> Floats:
    """The control points (k, pieces, m, 4) of each piece, of those of curves (k, n, m)."""
    every = np.lib.stride_tricks.sliding_window_view(extended(values, basis), 4, axis=1)
    return every[:, :: basis.step]


def weights(basis: Basis, each: int) -> Floats:
    """(each + 1, 4): what control points give at parameters 0, 1 / each … 1."""
    t = np.arange(each + 1) / each
    return np.asarray(np.stack([t**0, t, t * t, t**3], axis=1) @ MATRICES[basis.name])


def on_curves(values: Floats, basis: Basis, each: int) -> Floats:
    """Values (k, pieces each + 1, m) along curves whose control points have values (k, n, m)."""
    if basis.linear:
        return at_joints(extended(values, basis), each)
    control, weight = windows(values, basis), weights(basis, each)
    inner = np.einsum("kpmw,tw->kptm", control, weight[:-1])
    last = np.einsum("kmw,w->km", control[:, -1], weight[-1])[:, None]
    return np.concatenate([inner.reshape(inner.shape[0], -1, inner.shape[-1]), last], axis=1)


def at_joints(values: Floats, each: int) -> Floats:
    """Values (k, pieces each + 1, m) between those where pieces begin and end (k, pieces + 1, m)."""
    t = (np.arange(each) / each)[:, None]
    inner = values[:, :-1, None] * (1 - t) + values[:, 1:, None] * t
    return np.concatenate([inner.reshape(inner.shape[0], -1, inner.shape[-1]), values[:, -1:]], axis=1)


def points_a_piece(counts: Offsets, points: npt.NDArray[Any], basis: Basis, most: int = MOST) -> tuple[int, float]:
    """How many points each piece gets, and how far the curves are from the segments between them, at most.

    A cubic is off its chord by no more than an eighth of the largest second derivative, which is at one of its ends.
    """
    if basis.linear:
        return 1, 0.0
    off, long = np.zeros(counts.shape[0]), np.zeros(counts.shape[0])
    second = np.stack([[0, 0, 2, 0], [0, 0, 2, 6]]) @ MATRICES[basis.name]
    with np.errstate(over="ignore", invalid="ignore"):  # of points that are not finite
        for rows, values in _alike(counts, points, basis):
            bends = np.einsum("kpmw,tw->kptm", windows(values, basis), second)
            off[rows] = np.sqrt(np.einsum("kptm,kptm->kpt", bends, bends).max(axis=(1, 2))) / 8
            through = extended(values, basis)[:, :: 2 if basis.name == HERMITE else 1]
            long[rows] = np.sqrt((np.diff(through, axis=1) ** 2).sum(axis=2)).sum(axis=1)
    drawn = np.isfinite(off) & np.isfinite(long) & (basis.pieces(counts) > 0)
    if not drawn.any():
        return 1, 0.0
    aim = max(FINE * float(np.median(long[drawn])), 1e-300)
    worst = float(np.quantile(off[drawn], 1 - MOST_OUTLIERS))
    each = min(max(math.ceil(math.sqrt(min(worst / aim, 1e9))), 1), most)
    return each, float(off[drawn].max()) / each**2


def evaluated(counts: Offsets, values: npt.NDArray[Any], basis: Basis, each: int) -> npt.NDArray[np.float32]:
    """Values (Q, m) at the points of curves, of those of their control points (P, m)."""
    return _made(counts, counts, values, basis, each)


def between(counts: Offsets, values: npt.NDArray[Any], basis: Basis, each: int) -> npt.NDArray[np.float32]:
    """Values (Q, m) at the points of curves, of those where their pieces begin and end (V, m)."""
    return _made(counts, basis.varying(counts), values, basis, each, joints=True)


def new_counts(counts: Offsets, basis: Basis, each: int) -> Offsets:
    """Points of each curve (S,); 0 of those without a piece."""
    if basis.plain and each == 1:
        return counts
    pieces = basis.pieces(counts)
    return np.where(pieces > 0, pieces * each + 1, 0)


def _made(
    counts: Offsets, rows_of: Offsets, values: npt.NDArray[Any], basis: Basis, each: int, joints: bool = False
) -> npt.NDArray[np.float32]:
    after = offsets(new_counts(counts, basis, each))
    out = np.empty((int(after[-1]), values.shape[1]), np.float32)
    first = offsets(rows_of)
    with np.errstate(over="ignore", invalid="ignore"):
        for rows, count in _groups(counts, basis, each):
            some = values[first[rows][:, None] + np.arange(int(rows_of[rows[0]]))].astype(np.float64)
            if joints and basis.periodic:
                some = np.concatenate([some, some[:, :1]], axis=1)
            made = at_joints(some, each) if joints else on_curves(some, basis, each)
            out[after[rows][:, None] + np.arange(count)] = made
    return out


def _groups(counts: Offsets, basis: Basis, each: int) -> Any:
    """Curves of as many control points, some at once: their rows (k,), and their points."""
    pieces = basis.pieces(counts)
    order = np.argsort(counts, kind="stable")
    order = order[pieces[order] > 0]
    ends = np.flatnonzero(np.diff(counts[order], append=-1)) + 1
    begin = 0
    for end in ends:
        count = int(pieces[order[begin]]) * each + 1
        some = max(1, SLICE // (4 * count))
        for at in range(begin, int(end), some):
            yield order[at : min(at + some, int(end))], count
        begin = int(end)


def _alike(counts: Offsets, points: npt.NDArray[Any], basis: Basis) -> Any:
    """Curves of as many control points, some at once: their rows (k,), and control points (k, n, 3)."""
    first = offsets(counts)
    for rows, _ in _groups(counts, basis, 1):
        yield rows, points[first[rows][:, None] + np.arange(int(counts[rows[0]]))].astype(np.float64)
