"""Mend what can be mended, and turn strands around."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from ...common.counted import counted
from .. import faults
from ..bounded import not_finite
from ..ends import ends
from ..strands import CHUNK, Attribute, Mask, Strands, spans
from .moving import Change


def fixed(
    strands: Strands, turn: bool = True, otherwise: str = "with --reverse as well they run as in the file"
) -> tuple[Strands, Change]:
    """Strands without those that are not finite, have no length or repeat another; with ``turn`` the ones that clearly
    begin at the tip turned around; attributes that are not finite left out. ``otherwise``: what keeps all as they
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
    back, why = np.zeros(strands.count, np.bool_), ""
    if turn:
        known = ends(strands)
        back = ~known.others if known.root == "last" else known.others
        why = f", for roots are last: {known.why}; {otherwise}" if known.root == "last" else ""
    strands = turned_around(strands, back)
    counts["turned_around"] = int(back.sum())
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
    """Strands from the other end."""
    changed = turned_around(strands, np.ones(strands.count, np.bool_))
    return changed, Change("reverse", f"{counted(strands.count, 'strand')} turned around", {"strands": strands.count})


def _odd(one: Attribute) -> bool:
    return one.values.dtype.kind == "f" and not_finite(one.values)[0] > 0


def turned_around(strands: Strands, back: Mask) -> Strands:
    """Strands of which some (S,) run from last point to first, and their points' attributes with them."""
    if not back.any():
        return strands
    points = _turned(strands, strands.points, back)
    attributes = {
        name: Attribute(one.domain, _turned(strands, one.values, back)) if one.domain == "point" else one
        for name, one in strands.attributes.items()
    }
    return replace(strands, points=points, attributes=attributes)


def _turned(strands: Strands, values: npt.NDArray[Any], back: Mask) -> npt.NDArray[Any]:
    """Values (P, ...) of points in the order that they have once some strands (S,) are turned around."""
    found = strands.room(values)
    for rows, points in spans(strands.first):
        first = strands.first[rows.start : rows.stop + 1]
        if points == slice(int(first[0]), int(first[-1])):
            counts = np.diff(first)
            order = np.arange(points.start, points.stop)
            other = np.repeat(first[:-1] + first[1:] - 1, counts) - order
            found[points] = values[np.where(np.repeat(back[rows], counts), other, order)]
        elif not back[rows.start]:
            found[points] = values[points]
        elif points.start == first[0]:
            _turn(found, values, int(first[0]), int(first[1]))
    return found


def _turn(found: npt.NDArray[Any], values: npt.NDArray[Any], begin: int, end: int) -> None:
    """Write the values of a long strand from last to first: its beginning and its end change places, some points at
    once, as ``found`` may be the values themselves."""
    middle = (begin + end + 1) // 2
    for low in range(begin, middle, CHUNK):
        ahead = slice(low, min(low + CHUNK, middle))
        behind = slice(begin + end - ahead.stop, begin + end - ahead.start)
        held = values[ahead][::-1].copy()
        found[ahead] = values[behind][::-1].copy()
        found[behind] = held
