"""`.abc`, curves of Alembic in the Ogawa back end, with their points at several times."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from ..alembic import layout
from ..alembic.archive import CLOSE, Archive
from ..alembic.curves import Curves, curves_of, read_part
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
        fitter = Fitter(file.size)
        parts: list[Part] = []
        seconds: set[float] = set()
        cycles: set[float] = set()
        changing: set[str] = set()
        for one in _all_curves(archive):  # whose headers take more than the points of a few strands
            parts.append(read_part(archive, one, fitter, options.at))
            for entry in one.moving():
                seconds.update(archive.times(entry))
                if entry.last and 0 < entry.sampling.cycle < layout.ACYCLIC:
                    cycles.add(entry.sampling.cycle)
            for label, entry in one.attributes.items():
                members = archive.compound(entry).values() if entry.kind == layout.COMPOUND else (entry,)
                changing.update([label] if any(member.last for member in members) else [])
        every = sorted(seconds)
        times = [time for place, time in enumerate(every) if not place or time - every[place - 1] > CLOSE]
        facts: dict[str, Any] = {**fitter.facts(), "times": len(times), "begin": times[0], "end": times[-1]}
        if changing:
            facts["changing"] = sorted(changing)
        if archive.metadata.get("_ai_Application"):
            facts["application"] = archive.metadata["_ai_Application"]
        source = Source(name, archive.version, facts, times=tuple(times), rate=1 / min(cycles) if cycles else None)
        strands, lost = joined(parts, source)
    if lost:
        facts["attributes_not_read"] = lost
    return without_short(strands)


def _all_curves(archive: Archive) -> Iterator[Curves]:
    """The objects of curves of an archive, one after the other. Raises `UsageError` where there are none."""
    found, schemas = False, set()
    for one in archive.objects():
        schema = one.metadata.get("schema", "")
        if schema.startswith("AbcGeom_Curve_"):
            found = True
            yield curves_of(archive, one)
        else:
            schemas.add(schema or "no schema")
    if not found:
        there = f"; there are objects of {', '.join(sorted(schemas)[:5])}" if schemas else ""
        raise archive.file.fault(f"has no curves{there}", archive.container.root.at)
