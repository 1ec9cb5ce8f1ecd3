"""`.abc`, curves of Alembic in the Ogawa back end, with their points at several times."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ..alembic import layout
from ..alembic.archive import Archive
from ..alembic.curves import Clock, all_curves, attributes_of, part_of
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
        fitter, clock = Fitter(file.size), Clock()
        parts: list[Part] = []
        for one in all_curves(archive):  # whose headers take more than the points of a few strands
            attributes = attributes_of(archive, one)
            parts.append(part_of(archive, one, attributes, fitter, options.at))
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
