"""What `convert` changes, but for points along strands (`resample`): mends, turns, scale; which strands are at fault,
and which things are equal, by fingerprints.

Each edit returns the strands changed and what it did. Edits of strands that move are decided at the first moment, and
made alike at all moments.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ..common.counted import counted
from ..common.rotations import Floats, turning
from ..errors import UsageError
from .bounded import not_finite
from .ends import WHY, ends
from .parts import moved
from .strands import Attribute, Mask, Strands


@dataclass(frozen=True, slots=True)
class Change:
    """What an edit did: its name, a line for people, and the same as numbers."""

    edit: str
    text: str
    facts: dict[str, Any] = field(default_factory=dict)


Edit = Callable[[Strands], tuple[Strands, Change]]
ROW = "row of the point"
"""Attribute by which an edit that chooses among points is followed; no format has it."""


class Step(NamedTuple):
    """An edit; ``chooses``: it leaves points out or turns their order around, and moves none."""

    edit: Edit
    chooses: bool = False


def edited(
    strands: Strands, steps: Sequence[Step], again: bool = True
) -> tuple[Strands, list[Change], Callable[[npt.NDArray[Any]], npt.NDArray[Any]] | None]:
    """Strands after all edits, what each did, and the same edits where they are asked for ``again``: of points (P, 3)
    at another moment the points (Q, 3) that become of them, of numbers (P,) those of points that are chosen."""
    changes: list[Change] = []
    parts: list[Any] = []
    for step in steps:
        before = replace(strands, attributes={}) if again else None
        if again and step.chooses:
            rows = Attribute("point", np.arange(strands.points.shape[0]))
            strands = replace(strands, attributes={**strands.attributes, ROW: rows})
        strands, change = step.edit(strands)
        changes.append(change)
        if again and step.chooses:
            attributes = dict(strands.attributes)
            parts.append(attributes.pop(ROW).values)
            strands = replace(strands, attributes=attributes)
        else:
            parts.append((step.edit, before))

    def replayed(points: npt.NDArray[Any]) -> npt.NDArray[Any]:
        for part in parts:
            if isinstance(part, tuple):
                edit, before = part
                points = edit(replace(before, points=points))[0].points
            else:
                points = points[part]
        return points

    return strands, changes, replayed if again else None


def fixed(
    strands: Strands, turn: bool = True, otherwise: str = "with --reverse as well they run as in the file"
) -> tuple[Strands, Change]:
    """Strands without those that are not finite, have no length or repeat another; with ``turn`` all turned around
    where they clearly begin at the tip; attributes that are not finite left out. ``otherwise``: what keeps all as they
    are."""
    counts: dict[str, Any] = {}
    for name, found in (
        ("not_finite", strands_not_finite), ("without_length", without_length), ("repeated", repeated)
    ):  # fmt: skip
        wrong = found(strands)
        counts[name] = int(wrong.sum())
        strands = strands.select(~wrong)
    bad = [name for name, one in strands.attributes.items() if not_finite(one.values)[0]]
    if bad:
        attributes = {name: one for name, one in strands.attributes.items() if name not in bad}
        strands = replace(strands, attributes=attributes)
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


def _turned(strands: Strands, values: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Values (P, ...) of points in the order that they have once strands are turned around."""
    mirrored = np.repeat(strands.first[:-1] + strands.first[1:] - 1, strands.counts())
    mirrored -= np.arange(mirrored.size)
    return values[mirrored]


def turned(strands: Strands, up: str, to: str) -> tuple[Strands, Change]:
    """Strands whose up axis ``up`` becomes ``to``."""
    changed = replace(_apply(strands, turning(up, to)), source=replace(strands.source, up=to))
    return changed, Change("up", f"{up} turned to {to}", {"from": up, "to": to})


def scaled(strands: Strands, factor: float) -> tuple[Strands, Change]:
    """Strands times a factor, about the origin."""
    unit = strands.source.unit
    source = replace(strands.source, unit=None if unit is None else unit / factor)
    changed = replace(_apply(strands, np.eye(3), factor), source=source)
    return changed, Change("scale", f"scaled by {factor:g}", {"factor": factor})


def _apply(strands: Strands, turn: Floats, factor: float = 1.0) -> Strands:
    """Strands under a turn (3, 3) and then a factor."""
    found = {}
    for name, one in strands.attributes.items():
        values: npt.NDArray[Any] = one.values
        if name == "width" and factor != 1:
            values = np.multiply(values, factor, dtype=np.float64).astype(values.dtype)
        elif name.endswith("normal") and values.shape[-1:] == (3,):
            values = (values @ turn.T).astype(values.dtype)
        found[name] = Attribute(one.domain, values)
    matrix = np.eye(4)
    matrix[:3, :3] = factor * turn.T
    points = moved(strands.points, matrix)
    if not_finite(points)[0]:
        raise UsageError("points are too far out for single precision after --scale")
    return replace(strands, points=points, attributes=found)


AT_ONCE = 1 << 14
"""Things that are compared at once."""
GOLDEN = 0x9E3779B97F4A7C15
Keys = npt.NDArray[np.uint64]
Numbers = npt.NDArray[np.int64]


def mixed(z: Keys) -> Keys:
    """The bits of numbers mixed up, the last step of SplitMix64 (Steele et al., 2014); numbers overflow on purpose."""
    z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return z ^ (z >> np.uint64(31))


def prints_of(words: Keys) -> Keys:
    """A number for each row of words (n, k): equal rows have equal ones, different ones hardly ever."""
    found = np.zeros(words.shape[0], np.uint64)
    with np.errstate(over="ignore"):
        for column in range(words.shape[1]):
            found = mixed(found + words[:, column] + np.uint64(GOLDEN))
    return found


def repeats(prints: Keys, equal: Callable[[Numbers, Numbers], Mask]) -> tuple[Numbers, Numbers]:
    """Things that are equal to one of a lower number: the lowest such of each, and their own. ``prints`` (n,): their
    fingerprints; ``equal``: whether things with some numbers are equal to some."""
    order = np.argsort(prints, kind="stable")
    own = prints[order]
    again = np.flatnonzero(own[1:] == own[:-1]) + 1
    del own
    new = np.diff(again, prepend=-1) != 1
    one, other = order[again[new] - 1][np.cumsum(new) - 1], order[again]
    parts = [slice(begin, begin + AT_ONCE) for begin in range(0, one.size, AT_ONCE)]
    same = np.concatenate([np.zeros(0, np.bool_), *(equal(one[part], other[part]) for part in parts)])
    return one[same], other[same]


def strands_not_finite(strands: Strands) -> Mask:
    """Strands (S,) of which a point is NaN or infinite."""
    return np.logical_or.reduceat(~np.isfinite(strands.points).all(axis=1), strands.first[:-1])


def without_length(strands: Strands) -> Mask:
    """Strands (S,) whose points are all in one place."""
    found: Mask = (strands.roots() == strands.tips()).all(axis=1)
    if found.any():  # the rest have a length for sure
        found[found] = strands.select(found).lengths() == 0
    return found


def repeated(strands: Strands) -> Mask:
    """Strands (S,) that have the points of an earlier one, in every bit."""

    def bits(number: int) -> bytes:
        return strands.points[strands.first[number] : strands.first[number + 1]].tobytes()

    def equal(one: Numbers, other: Numbers) -> Mask:
        return np.array([bits(a) == bits(b) for a, b in zip(one.tolist(), other.tolist(), strict=True)], np.bool_)

    found = np.zeros(strands.count, np.bool_)
    prints = np.fromiter((hash(bits(number)) for number in range(strands.count)), np.int64, strands.count)
    found[repeats(prints.view(np.uint64), equal)[1]] = True
    return found
