"""What `strandcli info` tells of a file: counts, sizes, faults with the option that mends each, and guesses."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from ..common.counted import counted
from .bounded import not_finite
from .edits import repeated, strands_not_finite
from .ends import WHY, Ends, ends, up_axis
from .files import ReadOptions, files_of, read_first
from .objects import table
from .strands import Mask, Strands

TINY = 1e-3
"""Of the median length: strands shorter than that are reported."""
UP = "y"
"""The up axis of strandcli's scenes, whose unit is the metre."""


Fault = dict[str, Any]
"""Something that is wrong or unusual: ``fault``, the ``count`` of strands, in a ``text``, and the option of `convert`
to ``mend`` it, "" where there is nothing to do."""


def _fault(name: str, count: int, text: str, mend: str = "") -> Fault:
    return {"fault": name, "count": count, "text": text, "mend": mend}


def facts_of_file(path: Path, options: ReadOptions) -> dict[str, Any]:
    """What is in a file, or in numbered files, at the first moment, and which moments there are. Numbers that are not
    finite are reported as a fault."""
    strands, moments = read_first(path, replace(options, lenient=True))
    size = sum(one.stat().st_size for one in files_of(path))
    known = None if moments is None else moments.facts()
    return {"file": str(path), "bytes": size, **facts(strands), "moments": known}


def facts(strands: Strands) -> dict[str, Any]:
    """What strands are like, and their faults; shape and guesses are of those that are finite."""
    bad = strands_not_finite(strands)
    data = _data_of_all(strands)
    fine = strands.select(~bad)
    known = ends(fine)
    lengths = fine.lengths(np.float32)
    data |= {"length": spread(lengths.copy()), "box": _box(fine), "guess": _guesses(fine, known)}
    return {**data, "faults": [*_faults_of_strands(bad, fine, lengths), *_faults_of_groom(fine, known)]}


def _data_of_all(strands: Strands) -> dict[str, Any]:
    """What strands are like, be they finite or not."""
    source = strands.source
    return {
        "format": source.format, "version": source.version or None, "header": dict(source.facts),
        "strands": strands.count, "points": strands.points.shape[0], "skipped": dict(source.skipped),
        "objects": table(strands),
        "points_a_strand": spread(strands.counts(np.int32)), "unit": source.unit, "up": source.up,
        "attributes": [_attribute(name, one) for name, one in strands.attributes.items()],
    }  # fmt: skip


def spread(values: npt.NDArray[Any]) -> dict[str, float] | None:
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


def _attribute(name: str, one: Any) -> dict[str, Any]:
    values = one.values
    finite = values.size > 0 and not not_finite(values)[0]
    bounds = {"min": values.min().item(), "max": values.max().item()} if finite else {"min": None, "max": None}
    return {"name": name, "domain": one.domain, "shape": list(values.shape), "type": values.dtype.name, **bounds}


def _guesses(strands: Strands, known: Ends) -> dict[str, Any]:
    up = up_axis(strands, known)
    return {
        "root": known.root or None,
        "up": None if up is None else {"axis": up[0], "hangs": up[1]},
    }


def _faults_of_strands(bad: Mask, fine: Strands, lengths: npt.NDArray[np.float32]) -> list[Fault]:
    """Faults of strands, of which some are ``bad`` and the rest ``fine``, which are so long each."""
    found = [_fault("skipped", count, f"{counted(count, 'strand')} of {why}, skipped")
             for why, count in fine.source.skipped.items()]  # fmt: skip
    least = TINY * float(np.median(lengths)) if lengths.size else 0.0
    for name, mask, words, mend in (
        ("not_finite", bad, "with numbers that are not finite", "--fix"),
        ("without_length", lengths == 0, "without length", "--fix"),
        ("repeated", repeated(fine), "equal to another", "--fix"),
        ("tiny", (lengths > 0) & (lengths < least), f"shorter than {TINY:g} of the median length",
         f"--min-length {least:.3g}"),
    ):  # fmt: skip
        count = int(np.count_nonzero(mask))
        if count:
            example = int(np.argmax(mask))
            found.append(_fault(name, count, f"{counted(count, 'strand')} {words} (strand {example:,} for one)", mend))
    for name, one in fine.attributes.items():
        rows = not_finite(one.values)[0]
        if rows:
            found.append(_fault("attribute_not_finite", rows, f"{name} is not finite in {rows:,} rows", "--fix"))
    return found


def _faults_of_groom(strands: Strands, known: Ends) -> list[Fault]:
    found = []
    source = strands.source
    if source.up not in (None, UP):
        text = f"up is {source.up}, as the file says; here up is {UP}"
        found.append(_fault("up", strands.count, text, f"--up {source.up}"))
    if source.unit not in (None, 1.0):
        text = f"a unit is {source.unit:.6g} m, as the file says; here they are metres"
        found.append(_fault("unit", strands.count, text, f"--scale {source.unit:.9g}"))
    if known.root == "last":
        found.append(_fault("tips_first", strands.count, f"roots are last: {WHY}", "--reverse"))
    up = up_axis(strands, known)
    if up is not None and up[0] != UP and strands.source.up is None:
        text = f"up is {up[0]}, if hair hangs down ({up[1]:.0%} of it); here up is {UP}"
        found.append(_fault("up", strands.count, text, f"--up {up[0]}"))
    return found
