"""Mend what can be mended, and turn strands around."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from ...common.counted import counted
from .. import faults
from ..bounded import not_finite
from ..ends import WHY, ends
from ..strands import Attribute, Strands, spans
from .moving import Change


def fixed(
    strands: Strands, turn: bool = True, otherwise: str = "with --reverse as well they run as in the file"
) -> tuple[Strands, Change]:
    """Strands without those that are not finite, have no length or repeat another; with ``turn`` all turned around
    where they clearly begin at the tip; attributes that are not finite left out. ``otherwise``: what keeps all as they
    are."""
    counts: dict[str, Any] = {}
    for name, found in (
        ("not_finite", faults.not_finite), ("without_length", faults.without_length), ("repeated", faults.repeated)
    ):  # fmt: skip
        wrong = found(strands)
        counts[name] = int(wrong.sum())
        strands = strands.select(~wrong)
    bad = [name for name, one in strands.attributes.items() if _odd(one)]
    if bad:
        kept = {name: one for name, one in strands.attributes.items() if name not in bad}
        strands = replace(strands, attributes=kept)
    counts["attributes_left_out"] = bad
    why = ""
    if turn and ends(strands).root == "last":
        strands, why = reversed_all(strands)[0], f", for roots are last: {WHY}; {otherwise}"
    counts["turned_around"] = strands.count if why else 0
    return strands, Change("fix", f"mended: {_said(counts) or 'nothing, no fault was found'}{why}", counts)


def _said(counts: dict[str, Any]) -> str:
    """What was mended, in words."""
    words = (("not_finite", "not finite"), ("without_length", "without length"), ("repeated", "equal to another"))
    parts = [f"{counted(counts[name], 'strand')} {word}, left out" for name, word in words if counts[name]]
    if counts["turned_around"]:
        parts.append(f"{counted(counts['turned_around'], 'strand')} turned around")
    if counts["attributes_left_out"]:
        parts.append(f"{', '.join(counts['attributes_left_out'])} not finite, left out")
    return "; ".join(parts)


def reversed_all(strands: Strands) -> tuple[Strands, Change]:
    """Strands from the other end, and the attributes of points with them."""
    points = _turned(strands, strands.points)
    attributes = {
        name: Attribute(one.domain, _turned(strands, one.values)) if one.domain == "point" else one
        for name, one in strands.attributes.items()
    }
    changed = replace(strands, points=points, attributes=attributes)
    return changed, Change("reverse", f"{counted(strands.count, 'strand')} turned around", {"strands": strands.count})


def _odd(one: Attribute) -> bool:
    return one.values.dtype.kind == "f" and not_finite(one.values)[0] > 0


def _turned(strands: Strands, values: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Values (P, ...) of points in the order that they have once strands are turned around."""
    found = np.empty_like(values)
    for rows, points in spans(strands.first):
        first = strands.first[rows.start : rows.stop + 1]
        if points == slice(int(first[0]), int(first[-1])):
            mirror = np.repeat(first[:-1] + first[1:] - 1, np.diff(first))
            found[points] = values[mirror - np.arange(points.start, points.stop)]
        elif points.start == first[0]:  # a strand in parts
            found[first[0] : first[1]] = values[first[0] : first[1]][::-1]
    return found
