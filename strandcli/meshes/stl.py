"""`.stl`, text or binary: bare triangles, of all solids of a file together.

Text is read by blocks that end with a facet, so that words of all of it never are in memory.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from ..errors import UsageError, one_line
from ..exchange.bounded import Beside, Bounded, Growing, opened
from .make import RawMesh

BLOCK, LONGEST = 1 << 18, 1 << 16
"""Bytes of a text that are read at once, and of a facet with the names of solids before it."""
HEADER, BEGIN = 84, 1024
"""Bytes of a binary file before its triangles, whose last four count them; and by which a text is known."""
RECORD = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("more", "<u2")])
MARK = b"\xef\xbb\xbf"
"""What some programs put before a text."""
END = b"endfacet"
NUMBER = rb"[-+]?(?:\d++(?:\.\d*+)?|\.\d++)(?:e[-+]?\d++)?+"
VERTEX = rb"vertex\s+(%b)\s+(%b)\s+(%b)\s+" % (NUMBER, NUMBER, NUMBER)
FACET = rb"facet\s+normal\s+\S+\s+\S+\s+\S+\s+outer\s+loop\s+" + 3 * VERTEX + rb"endloop\s+endfacet(?!\S)"
"""A facet, whose normal is not read."""
SOLID = rb"(?:end)?solid(?!\S)(?:(?!facet\s+normal\s)[^\r\n])*"
"""Where a solid begins or ends, with its name, which goes up to the end of the line or to the next facet."""
FACETS, SOLIDS, ANY = re.compile(FACET), re.compile(SOLID), re.compile(rb"\s+|%b|%b" % (FACET, SOLID))
MENDS = "write it anew from its program"


def read_stl(path: Path, beside: Beside) -> list[RawMesh]:
    """What a file holds. Raises `UsageError`."""
    with opened(path, ".stl file") as file:
        corners = _binary(file)
        corners = _text(file) if corners is None else corners
    count = corners.shape[0]
    return [RawMesh(corners.reshape(-1, 3), np.arange(3 * count, dtype=np.int32).reshape(-1, 3))] if count else []


def _binary(file: Bounded) -> npt.NDArray[Any] | None:
    """Corners (T, 3, 3) of a binary file, known by its size alone, for headers of some begin as texts do. None for a
    text, which is what is read next. Raises `UsageError` for what is neither."""
    begin = file.take("begin", min(BEGIN, file.size))
    count = int.from_bytes(begin[HEADER - 4 : HEADER], "little")
    whole = HEADER + RECORD.itemsize * count
    if file.size == whole:
        file.seek("triangles", HEADER)
        return np.ascontiguousarray(file.array("triangles", RECORD, (count,))["corners"])
    mark = len(MARK) if begin.startswith(MARK) else 0
    if b"\0" in begin or begin[mark:].lower().split(None, 1)[:1] != [b"solid"]:
        raise UsageError(
            f"{file.path}: has {file.size:,} bytes, where {count:,} triangles, as its header declares, have {whole:,}, "
            f"and is no text that begins with 'solid': {MENDS}"
        )
    file.seek("content", mark)
    return None


def _text(file: Bounded) -> npt.NDArray[np.float64]:
    """Corners (T, 3, 3) of the facets of a text."""
    rows, line, last = Growing(np.float64, 9), 1, b""
    for content in map(bytes.lower, file.blocks("a facet", BLOCK, LONGEST, _last_end)):
        found = FACETS.findall(content)
        names = SOLIDS.findall(content)
        if SOLIDS.sub(b"", FACETS.sub(b"", content)).strip():
            at = 0
            while match := ANY.match(content, at):
                at = match.end()
            word = one_line(content[at : at + 40].split(None, 1)[0].decode("latin-1"))
            line += _lines(content[:at])
            raise UsageError(f"{file.path}: line {line:,}: no whole facet begins with '{word}': {MENDS}")
        if found:
            rows.add(np.array(found).astype(np.float64))
        last, line = names[-1] if names else last, line + _lines(content)
    if not last.startswith(b"end"):
        raise UsageError(f"{file.path}: line {line:,}: ends without 'endsolid', it was cut off: {MENDS}")
    return rows.taken().reshape(-1, 3, 3)


def _last_end(content: bytes) -> int:
    """Where the last whole facet ends."""
    found = content.lower().rfind(END)
    return found + len(END) if found >= 0 else 0


def _lines(content: bytes) -> int:
    """Ends of lines, as any system writes them."""
    return content.count(b"\n") + content.count(b"\r") - content.count(b"\r\n")
