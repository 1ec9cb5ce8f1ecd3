"""Objects and properties of an Alembic archive, and the samples of properties."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from ..bounded import Bounded
from . import layout
from .layout import Child, Container, Cursor, Group

DEEPEST = 128
"""Objects in one another, at most: their paths are stored."""
CLOSE = 1e-6
"""Seconds by which times may differ that mean the same."""


@dataclass(frozen=True, slots=True)
class Sampling:
    """When samples are taken, seconds: ``times`` of a cycle, which is repeated every ``cycle``."""

    cycle: float
    times: tuple[float, ...]

    def time(self, index: int) -> float:
        """Seconds of a sample."""
        turns, index = divmod(index, len(self.times))
        return self.times[index] + (self.cycle * turns if turns else 0.0)


@dataclass(frozen=True, slots=True, eq=False)
class Property:
    """A property: path for messages, its group, and what its header says.

    ``type``: index of `layout.TYPES`; ``extent``: numbers an element; ``first``, ``last``: the first and last sample
    that is not the one before, 0 where all are the same.
    """

    path: str
    kind: int
    child: Child
    metadata: Mapping[str, str]
    type: int = 0
    extent: int = 0
    samples: int = 0
    first: int = 0
    last: int = 0
    sampling: Sampling = Sampling(1.0, (0.0,))

    @property
    def dtype(self) -> str:
        """numpy's type of its numbers, "" for text."""
        return layout.TYPES[self.type].dtype


@dataclass(frozen=True, slots=True, eq=False)
class Object:
    """An object: path, metadata, group, and the object that holds it."""

    path: str
    metadata: Mapping[str, str]
    group: Group
    parent: Object | None
    depth: int


class Archive:
    """An archive that is read."""

    def __init__(self, file: Bounded) -> None:
        """Read what concerns all of it. Raises `UsageError` where it is no archive."""
        self.file = file
        self.container = Container(file)
        self.root = self.container.group(self.container.root)
        if self.root.size <= layout.INDEXED:
            raise file.damaged(f"archive: has {self.root.size:,} parts, {layout.INDEXED + 1} are needed", 8)
        version = self._part(layout.VERSIONS, "version of the layout").number("version", "<i")
        library = self._part(layout.LIBRARY, "version of the library").number("version", "<i")
        if not 0 <= version <= layout.NEWEST_LAYOUT or library < layout.OLDEST_LIBRARY:
            raise file.fault(f"archive: layout {version} of Alembic {library} is not known", self.root.begin)
        self.version = f"{library // 10000}.{library // 100 % 100}.{library % 100}"
        metadata = self._part(layout.METADATA, "metadata")
        self.metadata = layout.pairs(metadata.text("metadata", metadata.left))
        self.samplings = self._samplings(self._part(layout.SAMPLINGS, "time samplings"))
        self.indexed = self._indexed(self._part(layout.INDEXED, "indexed metadata"))

    def _part(self, index: int, name: str) -> Cursor:
        return self.container.headers(self.container.child(self.root, index, name))

    def _samplings(self, headers: Cursor) -> list[Sampling]:
        found = []
        while headers.left:
            headers.number("largest sample", "<I")
            at = headers.position
            cycle, count = headers.number("seconds a cycle", "<d"), headers.number("times", "<I")
            times = np.frombuffer(headers.take("times", 8 * count), "<f8")
            if not count or not math.isfinite(cycle) or not np.isfinite(times).all() or (np.diff(times) <= 0).any():
                raise self.file.damaged("time samplings: times do not rise", at)
            found.append(Sampling(cycle, tuple(times.tolist())))
        return found

    def _indexed(self, headers: Cursor) -> list[str]:
        found = [""]
        while headers.left:
            found.append(headers.text("indexed metadata", headers.number("length", "<B")))
        return found

    def _metadata(self, index: int, headers: Cursor, width: str) -> Mapping[str, str]:
        if index == layout.WRITTEN_OUT:
            return layout.pairs(headers.text("metadata", headers.number("length of metadata", width)))
        if index >= len(self.indexed):
            raise self.file.damaged(f"{headers.name}: metadata {index} of {len(self.indexed)}", headers.position)
        return layout.pairs(self.indexed[index])

    def objects(self) -> Iterator[Object]:
        """All objects, parents before what they hold; each once, though a damaged file may tell it twice."""
        top = self.container.child(self.root, layout.TOP, "top object")
        seen = {top.word}
        waiting = [self._children(Object("", {}, self.container.group(top), None, 0), seen)]
        while waiting:
            found = next(waiting[-1], None)
            if found is None:
                waiting.pop()
            else:
                yield found
                waiting.append(self._children(found, seen))

    def _children(self, parent: Object, seen: set[int]) -> Iterator[Object]:
        group = parent.group
        if group.size < 2:
            return
        headers = self.container.headers(self.container.child(group, group.size - 1, f"{parent.path or '/'}: objects"))
        place = 0
        while headers.left > layout.DIGESTS:
            name = headers.text("name", headers.number("length of a name", "<I"))
            metadata = self._metadata(headers.number("index of metadata", "<B"), headers, "<I")
            path, place = f"{parent.path}/{name}", place + 1
            child = self.container.child(group, place, path)
            if child.word and child.word in seen:
                raise self.file.damaged(f"{path}: is referenced twice, or by itself", child.at)
            if parent.depth >= DEEPEST:
                raise self.file.damaged(f"{path}: is referenced by {DEEPEST} objects in one another", child.at)
            seen.add(child.word)
            yield Object(path, metadata, self.container.group(child), parent, parent.depth + 1)

    def properties(self, one: Object) -> dict[str, Property]:
        """The properties of an object, by name."""
        if not one.group.size:
            return {}
        return self._members(self.container.child(one.group, 0, one.path), one.path)

    def compound(self, one: Property) -> dict[str, Property]:
        """The properties in a compound one, by name."""
        return self._members(one.child, one.path)

    def _members(self, child: Child, path: str) -> dict[str, Property]:
        group = self.container.group(child)
        if not group.size:
            return {}
        headers = self.container.headers(self.container.child(group, group.size - 1, f"{path}: properties"))
        found: dict[str, Property] = {}
        place = 0
        while headers.left:
            one = self._property(headers, group, path, place)
            found[one.path.removeprefix(f"{path}/")] = one
            place += 1
        return found

    def _property(self, headers: Cursor, group: Group, path: str, place: int) -> Property:
        at = headers.position
        info = headers.number("header", "<I")
        kind = min(info & layout.KIND, layout.ARRAY)
        hint = info >> layout.HINT & 0x3
        if hint >= len(layout.WIDTHS):
            raise self.file.damaged(f"{path}: header {info:#x} of a property", at)
        width = layout.WIDTHS[hint]
        more: dict[str, Any] = {}
        if kind != layout.COMPOUND:
            more = self._samples(headers, info, width, path)
        name = headers.text("name", headers.number("length of a name", width))
        metadata = self._metadata(info >> layout.INDEX & 0xFF, headers, width)
        full = f"{path}/{name}"
        return Property(full, kind, self.container.child(group, place, full), metadata, **more)

    def _samples(self, headers: Cursor, info: int, width: str, path: str) -> dict[str, Any]:
        at = headers.position
        found = {"type": info >> layout.TYPE & 0xF, "extent": info >> layout.EXTENT & 0xFF}
        samples = headers.number("samples", width)
        first, last = 1, samples - 1
        if info & layout.RANGE:
            first, last = headers.number("first change", width), headers.number("last change", width)
        elif info & layout.CONSTANT or samples < 2:
            first, last = 0, 0
        sampling = headers.number("time sampling", width) if info & layout.SAMPLED else 0
        fine = found["type"] < len(layout.TYPES) and found["extent"] > 0 and sampling < max(1, len(self.samplings))
        if not fine or not (first <= last < samples or first == last == 0) or (last > 0 and first < 1):
            raise self.file.damaged(
                f"{path}: a property of {samples:,} samples of which {first:,} to {last:,} change, type "
                f"{found['type']}, extent {found['extent']}, time sampling {sampling:,}", at,
            )  # fmt: skip
        found |= {"samples": samples, "first": first, "last": last}
        return {**found, **({"sampling": self.samplings[sampling]} if self.samplings else {})}

    def times(self, one: Property) -> list[float]:
        """Seconds at which a property changes, and of its first sample. Raises `UsageError` where samples are told
        that are not there."""
        if not one.last:
            return [self._time(one, 0)]
        self._stored(one, one.last)
        return [self._time(one, index) for index in (0, *range(one.first, one.last + 1))]

    def at(self, one: Property, seconds: float | None) -> npt.NDArray[Any]:
        """The numbers (n, extent) of a property at a time: of the last sample that is not after it, or the first."""
        if seconds is None:
            return self.values(one)
        number = bisect_right(range(one.last + 1), seconds + CLOSE, key=lambda index: self._time(one, index))
        return self.values(one, max(0, number - 1))

    def _time(self, one: Property, index: int) -> float:
        sampling = one.sampling
        if sampling.cycle >= layout.ACYCLIC and index >= len(sampling.times):
            raise self.file.damaged(f"{one.path}: sample {index:,} of {len(sampling.times):,} times", one.child.at)
        return sampling.time(index)

    def _stored(self, one: Property, index: int) -> Child:
        """The data of a sample."""
        place = 0 if index < one.first or not one.last else min(index, one.last) - one.first + 1
        each = 2 if one.kind == layout.ARRAY else 1
        return self.container.child(self.container.group(one.child), place * each, one.path)

    def values(self, one: Property, index: int = 0) -> npt.NDArray[Any]:
        """The numbers (n, extent) of a sample; no sample has none."""
        if one.kind == layout.COMPOUND or not one.dtype:
            raise self.file.damaged(f"{one.path}: is not made of numbers", one.child.at)
        if not one.samples:
            return np.zeros((0, one.extent), one.dtype)
        data = self.container.data(self._stored(one, index))
        dtype = "|u1" if one.dtype == "?" else one.dtype
        found = self.container.numbers(one.path, data, dtype, one.extent)
        if one.kind == layout.SCALAR and found.shape[0] != 1:
            raise self.file.damaged(f"{one.path}: {found.shape[0]:,} values of a scalar", data.begin)
        if found.dtype.kind == "f":
            each = found.dtype.itemsize * one.extent
            self.file.finite(one.path, found, lambda row: data.begin + layout.DIGEST + each * row)
        return found
