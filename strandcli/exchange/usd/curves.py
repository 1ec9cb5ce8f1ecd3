"""Prims of curves as the worker tells them, made strands."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from ...errors import UsageError, one_line
from .. import splines
from ..bounded import not_finite
from ..parts import Matrix, Part, moved, moved_attribute
from ..splines import Basis, ControlCurves, Fitter
from ..strands import Attribute
from .messages import Message
from .process import ask

NAMES = {
    "widths": "width", "normals": "normal", "displayColor": "colour", "displayOpacity": "transparency", "st": "uv",
    "groom_root_uv": "root_uv", "groom_color": "colour", "groom_width": "width",
}  # fmt: skip
"""Names of attributes: USD's own, those of Unreal's grooms, and ours."""


@dataclass(slots=True, eq=False)
class Stage:
    """What is read of a stage: what it tells of itself, its prims, and their parts."""

    header: dict[str, Any]
    curves: list[ControlCurves] = field(default_factory=list)
    parts: list[Part] = field(default_factory=list)


class Reader:
    """Reads a file, and checks what the worker says of it."""

    def __init__(self, path: Path, lenient: bool, text: bool) -> None:
        """``lenient``: NaN and infinity are let in; ``text``: it is a file of text."""
        self.path, self.lenient, self.text = path, lenient, text
        self.fitter = Fitter(path.stat().st_size)

    def stage(self, at: float | None = None) -> Stage:
        """All that is read, at the first time or ``at`` so many seconds. Raises `UsageError` for a file that is
        damaged."""
        messages = self._ask("read", at=at)
        found = Stage(next(messages)[0])
        for message in messages:
            self._add(found, message)
        return found

    def fault(self, words: str) -> UsageError:
        """An error about the file."""
        return UsageError(f"{self.path}: {one_line(words)}")

    def _ask(self, what: str, **more: Any) -> Iterator[Message]:
        return ask(self.path, {"do": what, "path": str(self.path.absolute()), "text": self.text, **more})

    def _add(self, stage: Stage, message: Message) -> None:
        header, (counts, points, *values) = message
        prim = header["prim"]
        basis = self._basis(prim, header["basis"])
        one = self.fitter.fitted(prim, counts.astype(np.int64), points, basis, self.fault)
        self._check_finite(f"{prim}: points", points)
        matrix = _matrix(header["matrix"])
        attributes: dict[str, Attribute] = {}
        unread = list(header["unread"])
        for (name, interpolation), numbers in zip(header["attributes"], values, strict=True):
            ours = NAMES.get(name, name)
            theirs = "varying" if interpolation == "faceVarying" else interpolation
            found = None if ours in attributes else one.attribute(ours, theirs, numbers)
            if found is None:
                unread.append(name)
                continue
            if ours == "transparency" and found.values.dtype == np.float32:
                found = Attribute(found.domain, 1 - found.values)
            self._check_finite(f"{prim}: {name}", found.values)
            attributes[ours] = found if matrix is None else moved_attribute(ours, found, matrix)
        stage.curves.append(one)
        stage.parts.append(Part(prim, one.point_counts(), moved(one.points(points), matrix), attributes, unread))

    def _basis(self, prim: str, named: list[str]) -> Basis:
        """What control points of a prim mean."""
        basis = Basis(*named)
        known = basis.type == splines.LINEAR or (basis.type == splines.CUBIC and basis.name in splines.MATRICES)
        if not known or basis.wrap not in splines.WRAPS:
            raise self.fault(f"{prim}: curves of type {basis.type}, basis {basis.name}, wrap {basis.wrap} are not read")
        return basis

    def _check_finite(self, name: str, values: npt.NDArray[Any]) -> None:
        if self.lenient or values.dtype.kind != "f":
            return
        count, row = not_finite(values)
        if count:
            more = f", and {count - 1:,} more" if count > 1 else ""
            raise self.fault(f"{name}: number {row:,} is not finite{more}; 'convert --fix' mends it")


def _matrix(numbers: list[float]) -> Matrix | None:
    """A transform; None of one that leaves all where it is."""
    found = np.array(numbers, np.float64).reshape(4, 4)
    return None if np.array_equal(found, np.eye(4)) else found
