"""Strands of several objects of curves, one after the other."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from .strands import OBJECT, Attribute, Domain, Offsets, Points, Source, Strands, offsets

RANK: dict[Domain, int] = {"groom": 0, "strand": 1, "point": 2}
"""Domains, from few values to many."""


@dataclass(frozen=True, slots=True, eq=False)
class Part:
    """What an object of curves holds: its name in full, points of each curve (S,), points (P, 3), attributes by our
    names, names of those that are none here."""

    name: str

    counts: Offsets
    points: Points
    attributes: dict[str, Attribute] = field(default_factory=dict)
    unread: list[str] = field(default_factory=list)


def joined(parts: list[Part], source: Source) -> tuple[Strands, list[str]]:
    """The strands of all parts, and the names of attributes that not all of them have alike."""
    counts = np.concatenate([one.counts for one in parts])
    points = parts[0].points if len(parts) == 1 else np.concatenate([one.points for one in parts])
    attributes: dict[str, Attribute] = {}
    lost = {name: None for one in parts for name in one.unread}
    for name in {name: None for one in parts for name in one.attributes}:
        found = _attribute([one.attributes.get(name) for one in parts], parts)
        if found is None:
            lost[name] = None
        else:
            attributes[name] = found
    if len(parts) > 1:
        if OBJECT in attributes:
            lost[OBJECT] = None
        numbers = np.repeat(np.arange(len(parts), dtype=np.int32), [one.counts.size for one in parts])
        attributes[OBJECT] = Attribute("strand", numbers)
    names = tuple(one.name for one in parts)
    return Strands(offsets(counts), points, attributes, source, names), sorted(lost)


def _attribute(found: list[Attribute | None], parts: list[Part]) -> Attribute | None:
    """An attribute of all parts, in the domain that has a value for each of theirs; None where they differ in type."""
    there = [one for one in found if one is not None]
    if len(there) != len(parts) or len({(one.values.dtype, one.values.shape[1:]) for one in there}) > 1:
        return None
    if len(there) == 1:
        return there[0]
    domain = max((one.domain for one in there), key=lambda one: max(RANK[one], RANK["strand"]))
    target: Literal["point", "strand"] = "point" if domain == "point" else "strand"
    return Attribute(target, np.concatenate([_values(*pair, target) for pair in zip(there, parts, strict=True)]))


def _values(one: Attribute, part: Part, domain: Domain) -> npt.NDArray[Any]:
    """Values for each strand or point."""
    values = one.values
    if one.domain == "groom":
        values = np.repeat(values, part.counts.shape[0], axis=0)
    if domain == "point" and one.domain != "point":
        values = np.repeat(values, part.counts, axis=0)
    return values
