"""Mend what can be mended, and turn strands around."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from ...counted import counted
from .. import faults
from ..bounded import not_finite
from ..change import Change
from ..ends import ends
from ..strands import Attribute, Mask, Strands


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
    counts, first = strands.counts(), strands.first
    order = np.arange(strands.points.shape[0])
    of_points = np.repeat(back, counts)
    order[of_points] = np.repeat(first[:-1] + first[1:] - 1, counts)[of_points] - order[of_points]
    attributes = {
        name: Attribute(one.domain, one.values[order]) if one.domain == "point" else one
        for name, one in strands.attributes.items()
    }
    return replace(strands, points=strands.points[order], attributes=attributes)
