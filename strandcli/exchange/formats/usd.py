"""`.usd`, `.usda`, `.usdc`: the BasisCurves of a stage of USD, with their points at several times."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ..bounded import opened
from ..files import ReadOptions
from ..parts import joined
from ..strands import Source, Strands, without_short
from ..usd.curves import Reader
from ..usd.export import write as write

name = ".usd"
suffixes = (".usd", ".usda", ".usdc")
moving = staged = interpolates = True

MAGIC = {b"PXR-USDC": "binary", b"#usda ": "text", b"#sdf ": "text"}
"""How files begin."""
WHAT = ".usd file"


def sniff(head: bytes, size: int) -> bool:
    """Whether it begins as USD, binary or text."""
    return head.startswith(tuple(MAGIC))


def read(path: Path, options: ReadOptions) -> Strands:
    """The strands of a file, of all prims of BasisCurves that are visible, where their transforms put them at the first
    time, or another. Cubic curves become points on them."""
    encoding = _encoding(path)
    reader = Reader(path, options.lenient, encoding == "text")
    stage = reader.stage(options.at)
    header = stage.header
    facts = {"encoding": encoding, **reader.fitter.facts(), **_facts(header)}
    source = Source(
        name, "", facts, header["unit"] or None, header["up"], times=tuple(header["times"]), rate=header["rate"],
    )  # fmt: skip
    strands, lost = joined(stage.parts, source)
    if lost:
        facts["attributes_not_read"] = lost
    return without_short(strands)


def _encoding(path: Path) -> str:
    """ "binary" or "text". Raises `UsageError` where it is no USD."""
    with opened(path, WHAT) as file:
        head = file.take("begin", min(16, file.size))
        for magic, kind in MAGIC.items():
            if head.startswith(magic):
                return kind
        raise file.damaged("does not begin as USD does", 0)


def _facts(header: dict[str, Any]) -> dict[str, Any]:
    times = header["times"]
    facts: dict[str, Any] = {"times": max(len(times), 1)}
    if times:
        facts |= {"begin": times[0], "end": times[-1]}
    facts |= {key: header[key] for key in ("not_read", "purpose", "changing", "application") if header[key]}
    if header["not_found"]:
        facts["files_not_found"] = header["not_found"]
    return facts
