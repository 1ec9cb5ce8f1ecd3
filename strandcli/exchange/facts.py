"""What `strandcli info` tells of a file: counts, sizes, faults with the option that mends each, and guesses."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from ..common.counted import counted
from . import faults
from .bounded import not_finite
from .ends import Ends, ends, head, up_axis
from .files import ReadOptions
from .moments import files_of, read_first
from .objects import Table
from .strands import Mask, Strands

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
        return {**self.data, "objects": list(self.data["objects"]), "faults": found}


def facts_of_file(path: Path, options: ReadOptions) -> Facts:
    """What is in a file, or in numbered files, at the first moment, and which moments there are. Numbers that are not
    finite are told as a fault."""
    strands, moments = read_first(path, replace(options, lenient=True))
    told = None if moments is None else moments.facts(strands)
    found = facts(replace(strands, spent=True))
    size = sum(one.stat().st_size for one in files_of(path))
    return Facts({"file": str(path), "bytes": size, **found.data, "moments": told}, found.faults)


def facts(strands: Strands) -> Facts:
    """What strands are like; shape and guesses are of those that are finite."""
    bad = faults.not_finite(strands)
    data = _data_of_all(strands)
    fine = strands.select(~bad)
    known = ends(fine)
    data |= {
        "root": known.root if known.stated else None,
        "length": _spread(fine.lengths(np.float32)), "box": _box(fine), "segment": _spread(_inner(fine)),
        "curvature": _spread(curvature(fine)), "guess": _guesses(fine, known),
    }  # fmt: skip
    found = [*_faults_of_strands(bad, fine, data["length"]), *_faults_of_groom(fine, known)]
    return Facts(data, tuple(found))


def _data_of_all(strands: Strands) -> dict[str, Any]:
    """What strands are like, be they finite or not."""
    source = strands.source
    return {
        "format": source.format, "version": source.version or None, "header": dict(source.facts),
        "strands": strands.count, "points": strands.points.shape[0], "skipped": dict(source.skipped),
        "objects": Table(strands),
        "points_a_strand": _counts(strands), "unit": source.unit, "up": source.up,
        "attributes": [_attribute(name, one) for name, one in strands.attributes.items()],
    }  # fmt: skip


def _counts(strands: Strands) -> dict[str, float] | None:
    """`_spread` of the points of each strand."""
    equal = strands.equal()
    if equal:
        return {"min": equal, "median": float(equal), "mean": float(equal), "max": equal}
    return _spread(strands.counts())


def _spread(values: npt.NDArray[Any]) -> dict[str, float] | None:
    """Least, median, mean and largest of values that are not needed in their order any more; None of none."""
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
    found, done = np.empty(strands.points.shape[0] - strands.count, np.float32), 0
    for rows, points, segments in strands.segments():
        kept = segments[_inside(strands, rows, points)]
        found[done : done + kept.size] = kept
        done += kept.size
    return found


def _inside(strands: Strands, rows: slice, points: slice) -> npt.NDArray[np.bool_]:
    """Which of some points are no tips; ``rows``: the strands that they are of."""
    found = np.ones(points.stop - points.start, np.bool_)
    tips = strands.first[rows.start + 1 : rows.stop + 1] - 1 - points.start
    found[tips[tips < found.size]] = False
    return found


def curvature(strands: Strands) -> npt.NDArray[np.float32]:
    """Of each strand the angle by which it turns in all, over its length: radians a unit; 0 without length."""

    def values(rows: slice, points: slice, segments: npt.NDArray[np.float32]) -> npt.NDArray[Any]:
        begin = max(points.start - 1, 0)
        step = np.diff(strands.points[begin : points.stop + 1].astype(np.float64), axis=0)
        across = np.linalg.norm(np.cross(step[:-1], step[1:]), axis=1)
        turns = np.zeros(segments.size)
        here = turns[begin + 1 - points.start :][: across.size]
        here[:] = np.arctan2(across, np.einsum("ij,ij->i", step[:-1], step[1:]))
        turns[~_inside(strands, rows, points)] = 0
        roots = strands.first[rows] - points.start
        turns[roots[roots >= 0]] = 0
        return np.stack([turns, segments])

    found = np.empty(strands.count, np.float32)
    for rows, (turns, lengths) in strands.sums(values):
        found[rows] = turns / np.where(lengths > 0, lengths, np.inf)
    return found


def _attribute(name: str, one: Any) -> dict[str, Any]:
    values = one.values
    finite = values.size > 0 and (values.dtype.kind != "f" or not not_finite(values)[0])
    bounds = {"min": values.min().item(), "max": values.max().item()} if finite else {"min": None, "max": None}
    return {"name": name, "domain": one.domain, "shape": list(values.shape), "type": values.dtype.name, **bounds}


def _guesses(strands: Strands, known: Ends) -> dict[str, Any]:
    up, human = up_axis(strands, known), head(strands, known)
    return {
        "root": None if known.stated else known.root or None,
        "up": None if up is None else {"axis": up[0], "hangs": up[1]},
        "head": None if human is None else human._asdict(),
    }


def _faults_of_strands(bad: Mask, fine: Strands, length: Mapping[str, float] | None) -> list[Fault]:
    """Faults of strands, of which some are ``bad`` and the others ``fine``; ``length``: `_spread` of these."""
    found = [Fault("skipped", count, f"{counted(count, 'strand')} of {why}, skipped")
             for why, count in fine.source.skipped.items()]  # fmt: skip
    least = TINY * length["median"] if length else 0.0
    still, tiny, repeats = _short(fine, least)
    for name, (count, example), words, mend in (
        ("not_finite", _counted(bad), "with numbers that are not finite", "--fix"),
        ("without_length", still, "without length", "--fix"),
        ("repeated", _counted(faults.repeated(fine)), "equal to another", "--fix"),
        ("tiny", tiny, f"shorter than {TINY:g} of the median length", f"--min-length {least:.3g}"),
        ("repeated_points", repeats, "with the same point twice in a row", "--simplify 0"),
    ):
        if count:
            found.append(Fault(name, count, f"{counted(count, 'strand')} {words} (strand {example:,} for one)", mend))
    for name, one in fine.attributes.items():
        rows = not_finite(one.values)[0] if one.values.dtype.kind == "f" else 0
        if rows:
            found.append(Fault("attribute_not_finite", rows, f"{name} is not finite in {rows:,} rows", "--fix"))
    if "stride_guessed" in fine.source.facts:
        stride = fine.source.facts["stride_guessed"]
        words = f"{stride} points a strand, by the jumps between strands"
        found.append(Fault("stride", fine.count + int(np.count_nonzero(bad)), words, f"--stride {stride}"))
    return found


def _counted(mask: Mask) -> tuple[int, int]:
    """How many strands there are in a mask, and the first of them."""
    return int(np.count_nonzero(mask)), int(np.argmax(mask)) if mask.size else 0


def _short(strands: Strands, least: float) -> list[tuple[int, int]]:
    """How many strands there are, and the first of them, without length, of a length below ``least``, and of a length
    but with a point that repeats the one before it."""

    def values(rows: slice, points: slice, segments: npt.NDArray[np.float32]) -> npt.NDArray[Any]:
        return np.stack([segments, (segments == 0) & _inside(strands, rows, points)], dtype=np.float64)

    found = [(0, 0)] * 3
    for rows, (lengths, stays) in strands.sums(values):
        masks = lengths == 0, (lengths > 0) & (lengths < least), (lengths > 0) & (stays > 0)
        for k, (count, example) in enumerate(map(_counted, masks)):
            if count:
                before, first = found[k]
                found[k] = before + count, first if before else rows.start + example
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
        who = counted(others, "strand runs", "strands run")
        found.append(Fault("other_way", others, f"{who} the opposite way to the rest", "--fix"))
    up = up_axis(strands, known)
    if up is not None and up[0] != UP and strands.source.up is None:
        text = f"up is {up[0]}, if hair hangs down ({up[1]:.0%} of it); here up is {UP}"
        found.append(Fault("up", strands.count, text, f"--up {up[0]}"))
    human = head(strands, known)
    if human is not None and human.scale != 1.0 and strands.source.unit is None:
        text = f"hair hangs from a head of radius {human.radius:.3g}: units are {human.unit}, if it is a human's"
        found.append(Fault("unit", strands.count, f"{text}; here they are metres", f"--scale {human.scale:.3g}"))
    return found
