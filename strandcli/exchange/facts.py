"""What `strandcli info` tells of a file: counts, sizes, faults with the option that mends each, and guesses."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from ..counted import counted
from . import faults
from .bounded import rows_not_finite
from .ends import Ends, ends, head, up_axis
from .files import ReadOptions
from .moments import files_of, read_first
from .objects import table
from .strands import CHUNK, Strands

TINY = 1e-3
"""Of the median length: strands shorter than that are told."""
UP = "y"
"""The up axis of strandcli's scenes, whose unit is the metre."""


@dataclass(frozen=True, slots=True)
class Fault:
    """Something that is wrong or unusual: what, how many strands, in words, and the option of `convert` that mends it
    ("" where there is nothing to do)."""

    fault: str
    count: int
    text: str
    mend: str = ""


@dataclass(frozen=True, slots=True)
class Facts:
    """Of a file: data for programs, and faults."""

    data: Mapping[str, Any]
    faults: tuple[Fault, ...]

    def as_dict(self) -> dict[str, Any]:
        """All of it as JSON has it."""
        found = [{"fault": one.fault, "count": one.count, "text": one.text, "mend": one.mend} for one in self.faults]
        return {**self.data, "faults": found}


def facts_of_file(path: Path, options: ReadOptions) -> Facts:
    """What is in a file, or in numbered files, at the first moment, and which moments there are. Numbers that are not
    finite are told as a fault."""
    strands, moments = read_first(path, replace(options, lenient=True))
    found = facts(strands)
    size = sum(one.stat().st_size for one in files_of(path))
    told = None if moments is None else moments.facts(strands)
    return Facts({"file": str(path), "bytes": size, **found.data, "moments": told}, found.faults)


def facts(strands: Strands) -> Facts:
    """What strands are like; shape and guesses are of those that are finite."""
    bad = faults.not_finite(strands)
    fine = strands.select(~bad)
    known = ends(fine)
    found = [*_faults_of_strands(strands, bad, fine), *_faults_of_groom(fine, known)]
    source = strands.source
    data: dict[str, Any] = {
        "format": source.format, "version": source.version or None, "header": dict(source.facts),
        "strands": strands.count, "points": strands.points.shape[0], "skipped": dict(source.skipped),
        "objects": table(strands),
        "points_a_strand": _spread(strands.counts()), "unit": source.unit, "up": source.up,
        "root": known.root if known.stated else None,
        "length": _spread(fine.lengths()) if fine.count else None, "box": _box(fine),
        "segment": _spread(_inner(fine)) if fine.count else None,
        "curvature": _spread(curvature(fine)) if fine.count else None,
        "attributes": [_attribute(name, one) for name, one in strands.attributes.items()],
        "guess": _guesses(fine, known),
    }  # fmt: skip
    return Facts(data, tuple(found))


def _spread(values: npt.NDArray[Any]) -> dict[str, float] | None:
    """Least, median, mean and largest of values that are not needed in their order any more."""
    if not values.size:
        return None
    middle = np.median(values, overwrite_input=True)
    mean = values.mean(dtype=np.float64)
    return {"min": values.min().item(), "median": middle.item(), "mean": mean.item(), "max": values.max().item()}


def _box(strands: Strands) -> dict[str, list[float]] | None:
    if not strands.count:
        return None
    low, high = strands.points.min(axis=0), strands.points.max(axis=0)
    size = high.astype(np.float64) - low
    return {"min": low.tolist(), "max": high.tolist(), "size": size.tolist()}


def _inner(strands: Strands) -> npt.NDArray[np.float32]:
    """Lengths of the segments."""
    inside = np.ones(strands.points.shape[0], np.bool_)
    inside[strands.first[1:] - 1] = False
    return strands.segments()[inside]


def curvature(strands: Strands) -> npt.NDArray[np.float64]:
    """Of each strand the angle by which it turns in all, over its length: radians a unit; 0 without length."""
    lengths = strands.lengths()
    turns = np.zeros(strands.points.shape[0], np.float32)
    for begin in range(0, turns.shape[0] - 2, CHUNK):
        step = np.diff(strands.points[begin : begin + CHUNK + 2].astype(np.float64), axis=0)
        across = np.linalg.norm(np.cross(step[:-1], step[1:]), axis=1)
        turns[begin + 1 : begin + step.shape[0]] = np.arctan2(across, np.einsum("ij,ij->i", step[:-1], step[1:]))
    turns[strands.first[:-1]] = 0
    turns[strands.first[1:] - 1] = 0
    return np.add.reduceat(turns, strands.first[:-1], dtype=np.float64) / np.where(lengths > 0, lengths, np.inf)


def _attribute(name: str, one: Any) -> dict[str, Any]:
    values = one.values
    finite = values.size > 0 and (values.dtype.kind != "f" or not rows_not_finite(values).size)
    bounds = {"min": values.min().item(), "max": values.max().item()} if finite else {"min": None, "max": None}
    return {"name": name, "domain": one.domain, "shape": list(values.shape), "type": values.dtype.name, **bounds}


def _guesses(strands: Strands, known: Ends) -> dict[str, Any]:
    up, human = up_axis(strands, known), head(strands, known)
    return {
        "root": None if known.stated else known.root or None,
        "up": None if up is None else {"axis": up[0], "hangs": up[1]},
        "head": None if human is None else human._asdict(),
    }


def _faults_of_strands(strands: Strands, bad: npt.NDArray[np.bool_], fine: Strands) -> list[Fault]:
    found = [Fault("skipped", count, f"{counted(count, 'strand')} of {why}, skipped")
             for why, count in strands.source.skipped.items()]  # fmt: skip
    lengths = fine.lengths()
    tiny = (lengths > 0) & (lengths < TINY * np.median(lengths)) if fine.count else lengths > 0
    still = np.add.reduceat((_still(fine)), fine.first[:-1]) > 0 if fine.count else bad[:0]
    for name, wrong, words, mend in (
        ("not_finite", bad, "with numbers that are not finite", "--fix"),
        ("without_length", lengths == 0, "without length", "--fix"),
        ("repeated", faults.repeated(fine), "equal to another", "--fix"),
        ("tiny", tiny, f"shorter than {TINY:g} of the median length", f"--min-length {_least(lengths):.3g}"),
        ("repeated_points", still & (lengths > 0), "with the same point twice in a row", "--simplify 0"),
    ):
        count = int(np.count_nonzero(wrong))
        if count:
            example = int(np.argmax(wrong))
            found.append(Fault(name, count, f"{counted(count, 'strand')} {words} (strand {example:,} for one)", mend))
    for name, one in fine.attributes.items():
        rows = rows_not_finite(one.values).size if one.values.dtype.kind == "f" else 0
        if rows:
            found.append(Fault("attribute_not_finite", rows, f"{name} is not finite in {rows:,} rows", "--fix"))
    if "stride_guessed" in strands.source.facts:
        stride = strands.source.facts["stride_guessed"]
        words = f"{stride} points a strand, as the jumps tell"
        found.append(Fault("stride", strands.count, words, f"--stride {stride}"))
    return found


def _least(lengths: npt.NDArray[np.float64]) -> float:
    return TINY * float(np.median(lengths)) if lengths.size else 0.0


def _still(strands: Strands) -> npt.NDArray[np.int64]:
    """1 at each point (P,) that the next one of its strand repeats."""
    found = (strands.segments() == 0).astype(np.int64)
    found[strands.first[1:] - 1] = 0
    return found


def _faults_of_groom(strands: Strands, known: Ends) -> list[Fault]:
    found = []
    source = strands.source
    if source.up not in (None, UP):
        text = f"up is {source.up}, as the file says; here up is {UP}"
        found.append(Fault("up", strands.count, text, f"--up {source.up}"))
    if source.unit not in (None, 1.0):
        text = f"a unit is {source.unit:.6g} m, as the file says; here they are metres"
        found.append(Fault("unit", strands.count, text, f"--scale {source.unit:.9g}"))
    if known.root == "last":
        found.append(Fault("tips_first", strands.count, f"roots are last: {known.why}", "--reverse"))
    others = int(np.count_nonzero(known.others))
    if others:
        found.append(
            Fault("other_way", others, f"{counted(others, 'strand')} run the other way than the rest", "--fix")
        )
    up = up_axis(strands, known)
    if up is not None and up[0] != UP and strands.source.up is None:
        text = f"up is {up[0]}, if hair hangs down ({up[1]:.0%} of it); here up is {UP}"
        found.append(Fault("up", strands.count, text, f"--up {up[0]}"))
    human = head(strands, known)
    if human is not None and human.scale != 1.0 and strands.source.unit is None:
        text = f"hair hangs from a head of radius {human.radius:.3g}: units are {human.unit}, if it is a human's"
        found.append(Fault("unit", strands.count, f"{text}; here they are metres", f"--scale {human.scale:.3g}"))
    return found
