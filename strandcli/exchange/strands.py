"""What a file of strands holds, whatever its format."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

Points = npt.NDArray[np.float32]
Offsets = npt.NDArray[np.int64]
Mask = npt.NDArray[np.bool_]
Domain = Literal["point", "strand", "groom"]
"""What an attribute has a value for: each point, each strand, or all of it."""
Layer = Callable[[float], str]
"""Makes a layer in USD's own text, whose time codes are so many a second."""
OBJECT = "object"
"""Attribute of strands that come from several objects of a file: the number of each one's, of `Strands.objects`."""
WIDTHS = {"width": 1.0, "widths": 1.0, "groom_width": 1.0, "thickness": 1.0, "pscale": 2.0}
"""Names of widths, the one that counts first, and diameters a unit: Houdini's ``pscale`` is a radius, of which its
translation to USD writes twice as much."""
SHORTEST = 2
"""Points of a strand, at least; readers skip and count those that have fewer."""
SHORT = "fewer than two points"
"""Why they are skipped."""


@dataclass(frozen=True, slots=True, eq=False)
class Attribute:
    """Numbers beside the points: of a domain, with a row each.

    Usual names: ``width`` (diameter, units of the points), ``colour`` (linear, 3), ``transparency``, ``uv`` (2),
    ``root_uv`` (2), ``root_normal`` (3), ``movable`` (0 where a point is pinned).
    """

    domain: Domain
    values: npt.NDArray[Any]


@dataclass(frozen=True, slots=True)
class Source:
    """Where strands come from: the format's name and version, what its header says worth telling, metres a unit and the
    up axis where the format says them, and how many strands were skipped, by reason.

    times: seconds at which strands of a file that moves are known, rising; rate: frames a second, where the file says
    so."""

    format: str = ""
    version: str = ""
    facts: Mapping[str, Any] = field(default_factory=dict)
    unit: float | None = None
    up: str | None = None
    skipped: Mapping[str, int] = field(default_factory=dict)
    times: tuple[float, ...] = ()
    rate: float | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Strands:
    """Strands of at least two points each.

    first: (S + 1,), of each strand its first point, and last the number of points; points: (P, 3), root to tip, units
    of the file; attributes: by name; objects: full names of the objects of the file that they come from, one alone or
    those that the attribute `OBJECT` (S,) numbers; () where it names none.
    """

    first: Offsets
    points: Points
    attributes: Mapping[str, Attribute] = field(default_factory=dict)
    source: Source = field(default_factory=Source)
    objects: tuple[str, ...] = ()

    @property
    def count(self) -> int:
        """Number of strands."""
        return self.first.shape[0] - 1

    def counts(self, kind: npt.DTypeLike = np.int64) -> npt.NDArray[Any]:
        """Points of each strand, in a type."""
        return np.subtract(self.first[1:], self.first[:-1], dtype=kind, casting="unsafe")

    def with_width(self) -> Strands:
        """The strands with an attribute ``width``, where they have one by another name."""
        for name, diameters in WIDTHS.items():
            one = self.attributes.get(name)
            if one is None or one.values.dtype.kind not in "fiu" or one.values.size != one.values.shape[0]:
                continue
            if name == "width" and one.values.ndim == 1 and one.values.dtype.kind == "f":
                return self
            values = np.multiply(one.values.reshape(-1), diameters, dtype=np.float32)
            rest = {other: found for other, found in self.attributes.items() if other not in (name, "width")}
            return replace(self, attributes={"width": Attribute(one.domain, values), **rest})
        return self

    def equal(self) -> int:
        """Points of every strand where all have as many, else 0; 0 of no strands."""
        counts = self.counts(np.int32)
        return int(counts[0]) if counts.size and (counts == counts[0]).all() else 0

    def lengths(self, kind: npt.DTypeLike = np.float64) -> npt.NDArray[Any]:
        """Length of each strand, units of the file, in a type, of which it is the largest number at most."""
        found, most = np.zeros(self.count, kind), float(np.finfo(kind).max)
        for rows, points in spans(self.first, CACHED):
            steps = np.diff(self.points[points.start : points.stop + 1].astype(np.float64), axis=0)
            long = np.zeros(points.stop - points.start)
            long[: len(steps)] = np.minimum(np.sqrt(np.einsum("ij,ij->i", steps, steps)), LARGEST).astype(np.float32)
            long[self.first[rows.start + 1 : rows.stop + 1] - 1 - points.start] = 0
            found[rows] = np.minimum(np.add.reduceat(long, self.first[rows] - points.start), most)
        return found

    def roots(self) -> Points:
        """First point of each strand."""
        return self.points[self.first[:-1]]

    def tips(self) -> Points:
        """Last point of each strand."""
        return self.points[self.first[1:] - 1]

    def select(self, keep: Mask) -> Strands:
        """The strands for which ``keep`` (S,) holds, in their order."""
        if keep.all():
            return self
        counts = self.counts()
        return self.at(offsets(counts[keep]), {"point": np.repeat(keep, counts), "strand": keep})

    def thinned(self, keep: Mask) -> Strands:
        """All strands, of the points for which ``keep`` (P,) holds."""
        return self.at(offsets(np.add.reduceat(keep, self.first[:-1], dtype=np.int64)), {"point": keep})

    def at(self, first: Offsets, rows: Mapping[Domain, Any]) -> Strands:
        """What belongs to some of the points and strands, in an order, with the offsets (K + 1,) that these have then;
        ``rows``: of points, and of strands where they are not all, as NumPy's indices."""
        attributes = {
            name: Attribute(one.domain, one.values[rows[one.domain]]) if one.domain in rows else one
            for name, one in self.attributes.items()
        }
        return replace(self, first=first, points=self.points[rows["point"]], attributes=attributes)


CHUNK = 1 << 17
"""Points that are looked at at once, so that what is between takes little memory."""
CACHED = 1 << 13
"""The same where what is between should stay in the processor's cache."""
LARGEST = float(np.finfo(np.float32).max)


@dataclass(frozen=True, slots=True, eq=False)
class TimeSample:
    """The points (P, 3) of strands at a moment, seconds."""

    seconds: float
    points: Points


def offsets(counts: npt.NDArray[Any], more: int = 0) -> Offsets:
    """Offsets (S + 1,) of strands with so many points each (S,), and ``more``."""
    first = np.zeros(counts.shape[0] + 1, np.int64)
    np.cumsum(counts, out=first[1:], dtype=np.int64)
    if more:
        first += more * np.arange(first.size)
    return first


def even_offsets(strands: int, points: int) -> Offsets:
    """Offsets of so many strands of as many points each."""
    found = np.arange(strands + 1, dtype=np.int64)
    found *= points
    return found


def spans(first: Offsets, most: int = CHUNK) -> Iterator[tuple[slice, slice]]:
    """All strands of offsets (S + 1,) and their points, some at once: those that have ``most`` points together, or one
    that has more. So what is computed meanwhile takes little memory."""
    low, count = 0, first.size - 1
    while low < count:
        high = max(int(np.searchsorted(first, first[low] + most, side="right")) - 1, low + 1)
        yield slice(low, high), slice(int(first[low]), int(first[high]))
        low = high


def without_short(strands: Strands) -> Strands:
    """Strands that were just read without those of fewer than two points, which are counted as skipped."""
    keep = strands.counts(np.int32) >= SHORTEST
    retained = strands.select(keep)
    if retained is strands:
        return strands
    skipped = {**strands.source.skipped, SHORT: int(keep.size - np.count_nonzero(keep))}
    return replace(retained, source=replace(strands.source, skipped=skipped))
