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
    """The strands of all parts, which are let go, and the names of attributes that not all of them have alike."""
    names = tuple(one.name for one in parts)
    every = [one.attributes for one in parts]
    lost = {name: None for one in parts for name in one.unread}
    counts, held = [one.counts for one in parts], [one.points for one in parts]
    parts.clear()
    points = concatenated(held)
    attributes: dict[str, Attribute] = {}
    for name in {name: None for one in every for name in one}:
        found = _attribute([one.pop(name, None) for one in every], counts)
        if found is None:
            lost[name] = None
        else:
            attributes[name] = found
    if len(names) > 1:
        if OBJECT in attributes:
            lost[OBJECT] = None
        numbers = np.repeat(np.arange(len(names), dtype=np.int32), [one.size for one in counts])
        attributes[OBJECT] = Attribute("strand", numbers)
    return Strands(offsets(concatenated(counts)), points, attributes, source, names), sorted(lost)


def concatenated(arrays: list[npt.NDArray[Any]]) -> npt.NDArray[Any]:
    """Arrays one after the other; each is let go as soon as it was copied."""
    if len(arrays) == 1:
        return arrays.pop()
    kind = np.result_type(*{one.dtype for one in arrays})
    found = np.empty((sum(map(len, arrays)), *arrays[0].shape[1:]), kind)
    end = len(found)
    while arrays:
        one = arrays.pop()
        found[end - len(one) : end] = one
        end -= len(one)
    return found


def _attribute(found: list[Attribute | None], counts: list[Offsets]) -> Attribute | None:
    """An attribute of all parts, in the domain that has a value for each of theirs; None where they differ in type."""
    there = [one for one in found if one is not None]
    found.clear()
    if len(there) != len(counts) or len({(one.values.dtype, one.values.shape[1:]) for one in there}) > 1:
        return None
    if len(there) == 1:
        return there[0]
    domain = max((one.domain for one in there), key=lambda one: max(RANK[one], RANK["strand"]))
    target: Literal["point", "strand"] = "point" if domain == "point" else "strand"
    there.reverse()
    return Attribute(target, concatenated([_values(there.pop(), each, target) for each in counts]))


def _values(one: Attribute, counts: Offsets, domain: Domain) -> npt.NDArray[Any]:
    """Values for each strand or point of strands of so many points (S,)."""
    values = one.values
    if one.domain == "groom":
        values = np.repeat(values, counts.shape[0], axis=0)
    if domain == "point" and one.domain != "point":
        values = np.repeat(values, counts, axis=0)
    return values
