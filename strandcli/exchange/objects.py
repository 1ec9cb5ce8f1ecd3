"""Objects of a file that strands come from: their names, strands of some of them, and each by itself.

Names are those of the file, in full, such as ``/head/brows``; they are text that a stranger wrote, and no paths of
files. People see and say the last part of a name where no other object has the same.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from difflib import get_close_matches
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ..errors import UsageError
from .strands import OBJECT, Attribute, Mask, Offsets, Points, Strands, offsets

UNNAMED = "strands"
"""Name of an object that has none."""
SHAPE = "Shape"
"""What programs append to the name of a transform for that of the curves in it."""
LONGEST = 255
"""Letters of a name that is written."""
MOST_LISTED = 10
"""Names that a message lists."""


class Pieces(NamedTuple):
    """Objects one by one: the name that each is written with, its strands, which of the points (P, 3) are its own, in
    an ``order`` (P,) of all that has those of each together, None where they are."""

    names: list[str]
    strands: list[Strands]
    rows: list[slice]
    order: Offsets | None

    def of(self, points: Points) -> list[Points]:
        """Each object's own of the points of all."""
        points = points if self.order is None else points[self.order]
        return [points[rows] for rows in self.rows]


def numbers(strands: Strands) -> npt.NDArray[Any]:
    """The number of the object (S,) that each strand is of."""
    one = strands.attributes.get(OBJECT)
    if len(strands.objects) < 2 or one is None:
        return np.broadcast_to(np.int32(0), strands.count)
    return one.values


def short_names(names: Sequence[str]) -> list[str]:
    """The last parts of names, and in full those whose last part more have."""
    found = [_last(one) for one in names]
    once: set[str] = set()
    twice: set[str] = set()
    for one in found:
        (twice if one in once else once).add(one)
    del once
    return [name if not short or short in twice else short for short, name in zip(found, names, strict=True)]


def _last(name: str) -> str:
    """The last part of a name, without what programs append to it."""
    parts = name.strip("/").rsplit("/", 2)
    return parts[-2] if len(parts) > 1 and parts[-1] == parts[-2] + SHAPE else parts[-1]


def chosen(strands: Strands, wanted: Iterable[str], path: Path) -> Mask:
    """Whether strands (S,) are of an object of these names, in full or short. Raises `UsageError` for a name that no
    object of the file at ``path`` has."""
    known: dict[str, set[int]] = {}
    for place, names in enumerate(zip(strands.objects, short_names(strands.objects), strict=True)):
        for name in names:
            known.setdefault(name.strip("/"), set()).add(place)
    found: set[int] = set()
    for name in wanted:
        if name.strip("/") not in known:
            raise UsageError(f"{path}: {_no_such(name, strands)}")
        found |= known[name.strip("/")]
    keep = np.zeros(max(len(strands.objects), 1), np.bool_)
    keep[list(found)] = True
    return np.asarray(keep[numbers(strands)])


def _no_such(name: str, strands: Strands) -> str:
    if not strands.objects:
        return f"has no object '{shown(name)}': its format names none"
    short = short_names(strands.objects)
    close = get_close_matches(name, short, 1) or get_close_matches(name.lower(), short, 1)
    hint = f"; did you mean '{shown(close[0])}'?" if close else ";"
    listed = ", ".join(shown(one) for one in short[:MOST_LISTED])
    more = f" and {len(short) - MOST_LISTED:,} more" if len(short) > MOST_LISTED else ""
    return f"has no object '{shown(name)}'{hint} there are {listed}{more}"


def shown(name: str, most: int = 80) -> str:
    """A name, without its middle where it is long."""
    return name if len(name) <= most else f"{name[: most // 2]} … {name[-most // 2 :]}"


def only(strands: Strands, wanted: Sequence[str], path: Path) -> Strands:
    """The strands, just read, of objects of these names, all of them where there are none; as `chosen`."""
    if not wanted:
        return strands
    keep = chosen(strands, wanted, path)
    there = np.unique(numbers(strands)[keep])
    strands = strands.select(keep)
    attributes = {name: one for name, one in strands.attributes.items() if name != OBJECT}
    if there.size > 1:
        attributes[OBJECT] = Attribute("strand", np.searchsorted(there, numbers(strands)).astype(np.int32))
    return replace(strands, attributes=attributes, objects=tuple(strands.objects[place] for place in there))


def table(strands: Strands) -> list[dict[str, Any]]:
    """Of each object its name, short where it can be, its name in full, its strands and points."""
    of, count = numbers(strands), len(strands.objects)
    own = np.bincount(of, minlength=count)
    points = np.bincount(of, weights=strands.counts(), minlength=count)
    return [
        {"name": short, "path": name, "strands": int(own[k]), "points": int(points[k])}
        for k, (short, name) in enumerate(zip(short_names(strands.objects), strands.objects, strict=True))
    ]


def pieces(strands: Strands, legal: Callable[[str], str]) -> Pieces:
    """The objects that have strands one by one, with names that ``legal`` makes of their own; all strands as one where
    no objects are named."""
    names = written_names(strands.objects or (UNNAMED,), legal)
    retained = {name: one for name, one in strands.attributes.items() if name != OBJECT or not strands.objects}
    of = numbers(strands)
    strands = replace(strands, attributes=retained, objects=())
    if len(names) < 2 or not of.size:
        return Pieces(names[:1], [strands], [slice(None)], None)
    order = None
    if (np.diff(of) < 0).any():
        strands, order, of = _ordered(strands, np.argsort(of, kind="stable"), of)
    ends = [0, *(np.flatnonzero(np.diff(of)) + 1).tolist(), of.size]
    spans = list(pairwise(ends))
    rows = [slice(int(strands.first[begin]), int(strands.first[end])) for begin, end in spans]
    return Pieces([names[of[begin]] for begin, _ in spans], [_part(strands, *span) for span in spans], rows, order)


def _ordered(strands: Strands, order: Offsets, of: Offsets) -> tuple[Strands, Offsets, Offsets]:
    """Strands in another order (S,), of their points (P,), and their numbers in it."""
    counts = strands.counts()[order]
    first = offsets(counts)
    points = np.arange(first[-1]) + np.repeat(strands.first[order] - first[:-1], counts)
    return strands.at(first, {"point": points, "strand": order}), points, of[order]


def _part(strands: Strands, begin: int, end: int) -> Strands:
    """Strands of these numbers, from ``begin`` to ``end``."""
    low, high = int(strands.first[begin]), int(strands.first[end])
    first = strands.first[begin : end + 1] - low
    return strands.at(first, {"point": slice(low, high), "strand": slice(begin, end)})


def written_names(names: Sequence[str], legal: Callable[[str], str]) -> list[str]:
    """Names that a file is written with, all different: short ones made ``legal``, and not too long."""
    found: list[str] = []
    used: set[str] = set()
    tried: Counter[str] = Counter()
    for short in short_names(names):
        plain = name = legal(short.strip("/"))[:LONGEST] or UNNAMED
        while name in used:
            tried[plain] += 1
            name = f"{plain}_{tried[plain] + 1}"
        used.add(name)
        found.append(name)
    return found


def renamed(strands: Strands, legal: Callable[[str], str], format: str) -> list[str]:
    """A line that tells which objects have other names in a format, or none."""
    short = [one.strip("/") for one in short_names(strands.objects)]
    changed = [pair for pair in zip(short, written_names(strands.objects, legal), strict=True) if pair[0] != pair[1]]
    if not changed:
        return []
    more = f", and {len(changed) - 1:,} more" if len(changed) > 1 else ""
    return [f"{format} takes no such name: object '{shown(changed[0][0])}' is called '{shown(changed[0][1])}'{more}"]
