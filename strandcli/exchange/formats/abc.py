"""`.abc`, curves of Alembic in the Ogawa back end, with their points at several times."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ..alembic import layout
from ..alembic.archive import CLOSE, Archive, Object, Property
from ..alembic.curves import Curves, attributes_of, chain, read_part
from ..alembic.export import write as write
from ..bounded import opened
from ..files import ReadOptions
from ..parts import Part, joined
from ..splines import Fitter
from ..strands import Source, Strands, without_short

name = ".abc"
suffixes = (".abc",)
moving = True

WHAT = ".abc file"


def sniff(head: bytes, size: int) -> bool:
    """Whether it begins with Ogawa."""
    return head.startswith(layout.MAGIC)


def read(path: Path, options: ReadOptions) -> Strands:
    """The strands of a file, of all its objects of curves in their first sample or at a time. Cubic curves become
    points on them."""
    with opened(path, WHAT, options.lenient) as file:
        archive = Archive(file)
        fitter, clock = Fitter(file.size), _Clock()
        parts: list[Part] = []
        for one in _all_curves(archive):  # whose headers take more than the points of a few strands
            attributes = attributes_of(archive, one)
            parts.append(read_part(archive, one, attributes, fitter, options.at))
            clock.add(archive, one, attributes)
        times = clock.times
        facts: dict[str, Any] = {
            **fitter.facts(),
            "times": len(times), "begin": times[0], "end": times[-1],
        }  # fmt: skip
        if clock.changing:
            facts["changing"] = sorted(clock.changing)
        if archive.metadata.get("_ai_Application"):
            facts["application"] = archive.metadata["_ai_Application"]
        source = Source(name, archive.version, facts, times=tuple(times), rate=clock.rate)
        strands, lost = joined(parts, source)
    if lost:
        facts["attributes_not_read"] = lost
    return without_short(strands)


class _Clock:
    """When objects of curves change, gathered from each of them as it is read."""

    def __init__(self) -> None:
        self._times: set[float] = set()
        self._cycles: set[float] = set()
        self.changing: set[str] = set()
        """Attributes, by our names, that change with time."""

    def add(self, archive: Archive, one: Curves, attributes: Mapping[str, Property]) -> None:
        """Take in an object with attributes."""
        moving = [move.values for move in one.transforms if move.values and move.values.last]
        for entry in (one.points, *moving):
            self._times.update(archive.times(entry))
            if entry.last and 0 < entry.sampling.cycle < layout.ACYCLIC:
                self._cycles.add(entry.sampling.cycle)
        for name, entry in attributes.items():
            parts = archive.compound(entry).values() if entry.kind == layout.COMPOUND else (entry,)
            self.changing.update([name] if any(part.last for part in parts) else [])

    @property
    def times(self) -> list[float]:
        """Seconds at which points change, rising."""
        found = sorted(self._times)
        return [time for place, time in enumerate(found) if not place or time - found[place - 1] > CLOSE]

    @property
    def rate(self) -> float | None:
        """Frames a second of samples that are taken at equal distances or in cycles; None where none are."""
        return 1 / min(self._cycles) if self._cycles else None


def _all_curves(archive: Archive) -> Iterator[Curves]:
    """The objects of curves of an archive, one after the other. Raises `UsageError` where there are none."""
    found, schemas = False, set()
    for one in archive.objects():
        schema = one.metadata.get("schema", "")
        if schema.startswith("AbcGeom_Curve_"):
            found = True
            yield _curves(archive, one)
        else:
            schemas.add(schema or "no schema")
    if not found:
        there = f"; there are objects of {', '.join(sorted(schemas)[:5])}" if schemas else ""
        raise archive.file.fault(f"has no curves{there}", archive.container.root.at)


def _curves(archive: Archive, one: Object) -> Curves:
    geometry = archive.properties(one).get(".geom")
    if geometry is None or geometry.kind != layout.COMPOUND:
        raise archive.file.damaged(f"{one.path}: has no .geom", one.group.begin)
    entry = archive.compound(geometry)
    for name, extent, kinds in (("P", 3, "f"), ("nVertices", 1, "iu")):
        found = entry.get(name)
        if found is None or found.kind == layout.COMPOUND:
            raise archive.file.damaged(f"{geometry.path}: has no {name}", geometry.child.at)
        if found.extent != extent or np.dtype(found.dtype or "S").kind not in kinds:
            kind = layout.TYPES[found.type].name
            raise archive.file.damaged(f"{found.path}: {found.extent} {kind} an element", found.child.at)
    return Curves(one.path, entry, chain(archive, one))
