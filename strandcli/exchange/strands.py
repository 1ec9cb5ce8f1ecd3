"""What a file of strands holds, whatever its format."""

from __future__ import annotations

from collections.abc import Callable, Mapping
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
    ``root_uv`` (2), ``root_normal`` (3), ``movable`` (0 where a point is held).
    """

    domain: Domain
    values: npt.NDArray[Any]


@dataclass(frozen=True, slots=True)
class Source:
    """Where strands come from: the format's name and version, what its header says worth telling, metres a unit and the
    up axis where the format says them, and how many strands were skipped, by reason.

    times: seconds at which strands of a file that moves are known, rising; rate: frames a second, where the file says
    so; steady: whether the file says that all moments have the same strands; pieces: points that each object of cubic
    curves has a piece."""

    format: str = ""
    version: str = ""
    facts: Mapping[str, Any] = field(default_factory=dict)
    unit: float | None = None
    up: str | None = None
    skipped: Mapping[str, int] = field(default_factory=dict)
    times: tuple[float, ...] = ()
    rate: float | None = None
    steady: bool = True
    pieces: tuple[int, ...] = ()


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

    def counts(self) -> Offsets:
        """Points of each strand."""
        return np.diff(self.first)

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
        counts = self.counts()
        return int(counts[0]) if counts.size and (counts == counts[0]).all() else 0

    def lengths(self) -> npt.NDArray[np.float64]:
        """Length of each strand, units of the file."""
        segments, found = self.segments(), np.zeros(self.count)
        some = max(1, CACHED * self.count // max(segments.shape[0], 1))
        for begin in range(0, self.count, some):
            first = self.first[begin : begin + some + 1]
            wide = segments[first[0] : first[-1]].astype(np.float64)
            found[begin : begin + some] = np.add.reduceat(wide, first[:-1] - first[0])
        return found

    def segments(self) -> npt.NDArray[np.float32]:
        """From each point the distance to the next one of its strand, units of the file; 0 at tips."""
        found = np.zeros(self.points.shape[0], np.float32)
        wide, step, long = np.empty((CACHED + 1, 3)), np.empty((CACHED, 3)), np.empty(CACHED)
        for begin in range(0, found.shape[0] - 1, CACHED):
            held = self.points[begin : begin + CACHED + 1]
            n = held.shape[0] - 1
            wide[: n + 1] = held
            np.subtract(wide[1 : n + 1], wide[:n], out=step[:n])
            np.einsum("ij,ij->i", step[:n], step[:n], out=long[:n])
            np.sqrt(long[:n], out=long[:n])
            found[begin : begin + n] = np.minimum(long[:n], LARGEST, out=long[:n])
        if self.count:
            found[self.first[1:] - 1] = 0
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
        of_points = np.repeat(keep, counts)
        rows: dict[str, Any] = {"point": of_points, "strand": keep, "groom": slice(None)}
        kept = {name: Attribute(one.domain, one.values[rows[one.domain]]) for name, one in self.attributes.items()}
        return replace(self, first=offsets(counts[keep]), points=self.points[of_points], attributes=kept)


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


def offsets(counts: npt.NDArray[Any]) -> Offsets:
    """Offsets (S + 1,) of strands with so many points each (S,)."""
    first = np.zeros(counts.shape[0] + 1, np.int64)
    np.cumsum(counts, out=first[1:])
    return first


def even_offsets(strands: int, points: int) -> Offsets:
    """Offsets of so many strands of as many points each."""
    return np.arange(strands + 1, dtype=np.int64) * points


def without_short(strands: Strands) -> Strands:
    """Strands without those of fewer than two points, which are counted as skipped."""
    keep = strands.counts() >= SHORTEST
    few = int(keep.size - np.count_nonzero(keep))
    if not few:
        return strands
    skipped = {**strands.source.skipped, SHORT: few}
    return replace(strands.select(keep), source=replace(strands.source, skipped=skipped))
