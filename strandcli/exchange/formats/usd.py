"""`.usd`, `.usda`, `.usdc`: the BasisCurves of a stage of USD, with their points at several times."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from ...errors import UsageError, one_line
from .. import splines
from ..bounded import not_finite_words, opened
from ..files import ReadOptions
from ..parts import Part, joined, part_of
from ..splines import Basis, Fitter
from ..strands import Source, Strands, without_short
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
    encoding, fitter = _encoding(path), Fitter(path.stat().st_size)
    request = {"do": "read", "path": str(path.absolute()), "text": encoding == "text", "at": options.at}
    messages = ask(path, request)
    header = next(messages)[0]
    parts = [_part(path, message, fitter, options.lenient) for message in messages]
    facts = {"encoding": encoding, **fitter.facts(), **_facts(header)}
    source = Source(
        name, "", facts, header["unit"] or None, header["up"], times=tuple(header["times"]), rate=header["rate"],
    )  # fmt: skip
    strands, lost = joined(parts, source)
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


def _part(path: Path, message: Message, fitter: Fitter, lenient: bool) -> Part:
    """A prim as the worker tells it, which is checked; ``lenient``: NaN and infinity are let in. Raises `UsageError`
    where it is damaged."""
    header, (counts, points, *values) = message
    prim, basis = header["prim"], Basis(*header["basis"])

    def fault(words: str) -> UsageError:
        return UsageError(f"{path}: {one_line(words)}")

    known = basis.type == splines.LINEAR or (basis.type == splines.CUBIC and basis.name in splines.MATRICES)
    if not known or basis.wrap not in splines.WRAPS:
        raise fault(f"{prim}: curves of type {basis.type}, basis {basis.name}, wrap {basis.wrap} are not read")
    curves = fitter.fitted(prim, counts.astype(np.int64), points, basis, fault)
    matrix = np.array(header["matrix"], np.float64).reshape(4, 4)
    placed = None if np.array_equal(matrix, np.eye(4)) else matrix
    found = part_of(prim, curves, points, fitter, placed, _named(header["attributes"], values))
    found.unread.extend(header["unread"])
    for label, one in (("points", points), *((label, one.values) for label, one in found.attributes.items())):
        _, why = not_finite_words(f"{prim}: {label}", one)
        if why and not lenient:
            raise fault(why)
    return found


def _named(attributes: list[list[str]], values: list[npt.NDArray[Any]]) -> Iterator[tuple[str, str, npt.NDArray[Any]]]:
    """Of each attribute our name, what it belongs to, and its values, by USD's names."""
    for (theirs, interpolation), numbers in zip(attributes, values, strict=True):
        ours = NAMES.get(theirs, theirs)
        opaque = ours == "transparency" and numbers.dtype.kind == "f"
        yield ours, "varying" if interpolation == "faceVarying" else interpolation, 1 - numbers if opaque else numbers
