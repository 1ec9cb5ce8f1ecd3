"""`.usd`, `.usda`, `.usdc`: the BasisCurves of a stage of USD, with their points at several times."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from ...errors import UsageError, one_line
from .. import splines
from ..bounded import not_finite_words, opened
from ..files import ReadOptions
from ..parts import Matrix, Part, joined, moved, moved_attribute
from ..splines import Basis, Fitter
from ..strands import Attribute, Source, Strands, without_short
from ..usd.export import NAMES
from ..usd.export import write as write
from ..usd.process import Message, ask

name = ".usd"
suffixes = (".usd", ".usda", ".usdc")
moving = staged = interpolates = True

MAGIC = {b"PXR-USDC": "binary", b"#usda ": "text", b"#sdf ": "text"}
"""How files begin."""
WHAT = ".usd file"


def sniff(head: bytes, size: int) -> bool:
    """Whether it begins as USD, binary or text."""
    return head.startswith(tuple(MAGIC))


def read(path: Path, options: ReadOptions) -> Strands:
    """The strands of a file, of all prims of BasisCurves that are visible, where their transforms put them at the first
    time, or another. Cubic curves become points on them."""
    encoding = _encoding(path)
    reader = Reader(path, options.lenient, encoding == "text")
    stage = reader.stage(options.at)
    header = stage.header
    facts = {"encoding": encoding, **reader.fitter.facts(), **_facts(header)}
    source = Source(
        name, "", facts, header["unit"] or None, header["up"], times=tuple(header["times"]), rate=header["rate"],
    )  # fmt: skip
    strands, lost = joined(stage.parts, source)
    if lost:
        facts["attributes_not_read"] = lost
    return without_short(strands)


def _encoding(path: Path) -> str:
    """ "binary" or "text". Raises `UsageError` where it is no USD."""
    with opened(path, WHAT) as file:
        head = file.take("begin", min(16, file.size))
        for magic, kind in MAGIC.items():
            if head.startswith(magic):
                return kind
        raise file.damaged("does not begin as USD does", 0)


def _facts(header: dict[str, Any]) -> dict[str, Any]:
    times = header["times"]
    facts: dict[str, Any] = {"times": max(len(times), 1)}
    if times:
        facts |= {"begin": times[0], "end": times[-1]}
    facts |= {key: header[key] for key in ("not_read", "purpose", "changing", "application") if header[key]}
    if header["not_found"]:
        facts["files_not_found"] = header["not_found"]
    return facts


@dataclass(slots=True, eq=False)
class Stage:
    """What is read of a stage: what it tells of itself, its prims, and their parts."""

    header: dict[str, Any]
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
        request = {"do": "read", "path": str(self.path.absolute()), "text": self.text, "at": at}
        messages = ask(self.path, request)
        found = Stage(next(messages)[0])
        for message in messages:
            self._add(found, message)
        return found

    def fault(self, words: str) -> UsageError:
        """An error about the file."""
        return UsageError(f"{self.path}: {one_line(words)}")

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
        on_curves, departure = one.points(points)
        self.fitter.departure = max(self.fitter.departure, departure)
        stage.parts.append(Part(prim, one.point_counts(), moved(on_curves, matrix), attributes, unread))

    def _basis(self, prim: str, named: list[str]) -> Basis:
        """What control points of a prim mean."""
        basis = Basis(*named)
        known = basis.type == splines.LINEAR or (basis.type == splines.CUBIC and basis.name in splines.MATRICES)
        if not known or basis.wrap not in splines.WRAPS:
            raise self.fault(f"{prim}: curves of type {basis.type}, basis {basis.name}, wrap {basis.wrap} are not read")
        return basis

    def _check_finite(self, name: str, values: npt.NDArray[Any]) -> None:
        _, why = not_finite_words(name, values)
        if why and not self.lenient:
            raise self.fault(why)


def _matrix(numbers: list[float]) -> Matrix | None:
    """A transform; None of one that leaves all where it is."""
    found = np.array(numbers, np.float64).reshape(4, 4)
    return None if np.array_equal(found, np.eye(4)) else found
