"""Prims of curves as the worker tells them, made strands."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from ...errors import UsageError, one_line
from ..bounded import rows_not_finite
from ..parts import Part
from ..placing import Matrix, moved, moved_attribute
from ..strands import SHORTEST, Attribute, Domain, Offsets, Points, TimeSample
from . import cubic
from .cubic import Basis
from .messages import Message
from .process import SPARE, ask

NAMES = {
    "widths": "width", "normals": "normal", "displayColor": "colour", "displayOpacity": "transparency", "st": "uv",
    "groom_root_uv": "root_uv", "groom_color": "colour", "groom_width": "width",
}  # fmt: skip
"""Names of attributes: USD's own, those of Unreal's grooms, and ours."""
INTERPOLATIONS: dict[str, Domain] = {
    "constant": "groom", "uniform": "strand", "varying": "point", "vertex": "point", "faceVarying": "point",
}  # fmt: skip


@dataclass(slots=True, eq=False)
class Curves:
    """A prim of curves: its path, control points of each curve (S,), what they mean, and points of each piece; ``off``:
    how far segments are from the curves at most."""

    prim: str
    counts: Offsets
    basis: Basis
    each: int = 1
    off: float = 0.0

    def points(self, held: Points) -> Points:
        """Points on the curves of control points (P, 3)."""
        return held if self.basis.plain else cubic.evaluated(self.counts, held, self.basis, self.each)


@dataclass(slots=True, eq=False)
class Stage:
    """What is read of a stage: what it tells of itself, its prims, and their parts."""

    told: dict[str, Any]
    curves: list[Curves] = field(default_factory=list)
    parts: list[Part] = field(default_factory=list)


class Reader:
    """Reads a file, and checks what the worker says of it."""

    def __init__(self, path: Path, lenient: bool, text: bool) -> None:
        """``lenient``: NaN and infinity are let in; ``text``: it is a file of text."""
        self.path, self.lenient, self.text = path, lenient, text
        self.size = path.stat().st_size
        self.room = 2 * self.size + SPARE
        """Bytes that points on cubic curves may take."""

    def stage(self) -> Stage:
        """All that is read. Raises `UsageError` for a file that is damaged."""
        messages = self._ask("read")
        found = Stage(next(messages)[0])
        for message in messages:
            self._add(found, message)
        return found

    def moments(self, curves: list[Curves]) -> Iterator[TimeSample]:
        """The points of curves at each time, without those of strands that are too short."""
        counts = np.concatenate([cubic.new_counts(one.counts, one.basis, one.each) for one in curves])
        keep = np.repeat(counts >= SHORTEST, counts)
        for told, arrays in self._ask("moments"):
            parts = []
            for one, held, numbers in zip(curves, arrays, told["matrices"], strict=True):
                if held.shape[0] != int(one.counts.sum()):
                    raise self.fault(
                        f"{one.prim}: {held.shape[0]:,} points at {told['seconds']:g} s, the curves have "
                        f"{int(one.counts.sum()):,}"
                    )
                self._check_finite(f"{one.prim}: points", held)
                parts.append(one.points(moved(held, _matrix(numbers))))
            points = parts[0] if len(parts) == 1 else np.concatenate(parts)
            yield TimeSample(told["seconds"], points if keep.all() else points[keep])

    def fault(self, words: str) -> UsageError:
        """An error about the file."""
        return UsageError(f"{self.path}: {one_line(words)}")

    def _ask(self, what: str) -> Iterator[Message]:
        return ask(self.path, {"do": what, "path": str(self.path.absolute()), "text": self.text})

    def _add(self, stage: Stage, message: Message) -> None:
        told, (counts, points, *values) = message
        prim = told["prim"]
        one = self._curves(prim, counts, points, Basis(*told["basis"]))
        self._check_finite(f"{prim}: points", points)
        matrix = _matrix(told["matrix"])
        attributes: dict[str, Attribute] = {}
        unread = list(told["unread"])
        for (name, interpolation), numbers in zip(told["attributes"], values, strict=True):
            ours = NAMES.get(name, name)
            found = None if ours in attributes else _attribute(one, ours, interpolation, numbers)
            if found is None:
                unread.append(name)
                continue
            self._check_finite(f"{prim}: {name}", found.values)
            attributes[ours] = found if matrix is None else moved_attribute(ours, found, matrix)
        made = cubic.new_counts(one.counts, one.basis, one.each)
        stage.curves.append(one)
        stage.parts.append(Part(made, one.points(moved(points, matrix)), attributes, unread, one.basis.text))

    def _curves(self, prim: str, counts: npt.NDArray[Any], points: Points, basis: Basis) -> Curves:
        """A prim, checked, and how finely its curves are followed."""
        if basis.type not in (cubic.LINEAR, "cubic") or basis.wrap not in cubic.WRAPS or (
            not basis.linear and basis.name not in cubic.MATRICES
        ):  # fmt: skip
            raise self.fault(f"{prim}: curves of type {basis.type}, basis {basis.name}, wrap {basis.wrap} are not read")
        counts = counts.astype(np.int64)
        if counts.size and int(counts.min()) < 0:
            raise self.fault(f"{prim}: curve {int(np.argmin(counts)):,} has {int(counts.min()):,} points; is damaged")
        if int(counts.sum()) != points.shape[0]:
            raise self.fault(f"{prim}: {points.shape[0]:,} points, the curves have {int(counts.sum()):,}; is damaged")
        pieces = basis.pieces(counts)
        if (pieces < 0).any():
            worst = int(np.argmin(pieces))
            raise self.fault(f"{prim}: curve {worst:,} has {counts[worst]:,} points, which make no whole pieces of "
                             f"{basis.text}; is damaged")  # fmt: skip
        if basis.plain:
            return Curves(prim, counts, basis)
        needs = 12 * max(int(pieces.sum()), 1)
        most = min(cubic.MOST, self.room // needs)
        if most < 1:
            raise self.fault(f"{prim}: holds more curves than is believed of a file of its size; is damaged")
        each, off = cubic.points_a_piece(counts, points, basis, int(most))
        self.room -= each * needs
        return Curves(prim, counts, basis, each, off)

    def _check_finite(self, name: str, values: npt.NDArray[Any]) -> None:
        if self.lenient or values.dtype.kind != "f":
            return
        rows = rows_not_finite(values)
        if rows.size:
            more = f", and {rows.size - 1:,} more" if rows.size > 1 else ""
            raise self.fault(f"{name}: number {int(rows[0]):,} is not finite{more}; 'convert --fix' mends it")


def _matrix(numbers: list[float]) -> Matrix | None:
    """A transform; None of one that leaves all where it is."""
    found = np.array(numbers, np.float64).reshape(4, 4)
    return None if np.array_equal(found, np.eye(4)) else found


def _attribute(one: Curves, name: str, interpolation: str, values: npt.NDArray[Any]) -> Attribute | None:
    """Values (rows, m) as an attribute; None where nothing has so many rows."""
    counts = one.counts
    rows = {"constant": 1, "uniform": counts.shape[0], "varying": int(one.basis.varying(counts).sum()),
            "vertex": int(counts.sum())}  # fmt: skip
    told = "varying" if interpolation == "faceVarying" else interpolation
    if rows.get(told) != values.shape[0]:
        fits = [kind for kind in ("vertex", "uniform", "constant") if rows[kind] == values.shape[0]]
        if not fits:
            return None
        told = fits[0]
    if values.dtype.kind == "f":
        with np.errstate(over="ignore"):
            values = values.astype(np.float32, copy=False)
    if told in ("varying", "vertex") and not one.basis.plain:
        if values.dtype.kind != "f":
            return None
        make = cubic.between if told == "varying" else cubic.evaluated
        values = make(counts, values, one.basis, one.each)
        if name == "width":
            values = np.maximum(values, 0)
    if name == "transparency" and values.dtype == np.float32:
        values = 1 - values
    return Attribute(INTERPOLATIONS[told], values[:, 0] if values.shape[1] == 1 else values)
