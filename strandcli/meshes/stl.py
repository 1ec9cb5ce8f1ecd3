"""`.stl`, text or binary: bare triangles, of all solids of a file together.

Text is read by blocks that end with a facet, so that words of all of it never are in memory.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from ..errors import UsageError, one_line
from ..exchange.bounded import Bounded, opened
from .beside import Beside
from .make import RawMesh

BLOCK, LONGEST = 1 << 18, 1 << 16
"""Bytes of a text that are read at once, and of a facet with the names of solids before it."""
HEADER, BEGIN = 84, 1024
"""Bytes of a binary file before its triangles, whose last four count them; and by which a text is known."""
RECORD = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("more", "<u2")])
MARK = b"\xef\xbb\xbf"
"""What some programs put before a text."""
VERTEX = (b"vertex", None, None, None)
FACET = (b"facet", b"normal", None, None, None, b"outer", b"loop", *VERTEX, *VERTEX, *VERTEX, b"endloop", b"endfacet")
"""Words of a facet; None are numbers, the first three of them its normal, which is not read."""
COORDINATES = tuple(k for k, word in enumerate(FACET) if word is None)[3:]
SHORTEST = sum(len(word or b"0") + 1 for word in FACET)
"""Bytes of a facet, at least."""
NAMED = re.compile(rb"(?<!\S)((?:end)?solid)(?!\S)(?:(?!facet\s+normal\s)[^\r\n])*")
"""Where a solid begins or ends, with its name, which goes up to the end of the line or to the next facet."""
TO_LAST_FACET = re.compile(rb"(?s:.*)endloop\s+endfacet(?=\s)")
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
        corners = np.empty((count, 3, 3), np.float32)
        file.columns("triangles", RECORD, count, {"corners": corners})
        return corners
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
    rows = np.empty((file.left // SHORTEST + 1, len(COORDINATES)))  # whose memory is taken when it is written
    done, line, last = 0, 1, b""
    for content in _blocks(file):
        begin = 0
        for named in (*NAMED.finditer(content), None):
            part = content[begin : named.start() if named else len(content)]
            words = part.split()
            if words:
                found = _facets(words)
                if found is None:
                    raise _wrong(file.path, line + _lines(content[:begin]), part)
                rows[done : done + found.shape[0]] = found
                done += found.shape[0]
            if named:
                begin, last = named.end(), named[1]
        line += _lines(content)
    if last != b"endsolid":
        raise UsageError(f"{file.path}: line {line:,}: ends without 'endsolid', it was cut off: {MENDS}")
    return rows[:done].reshape(-1, 3, 3)


def _blocks(file: Bounded) -> Iterator[bytes]:
    """The text in small letters, some at once, each but the last up to the end of a facet."""
    rest = b""
    while file.left:
        content = rest + file.take("facets", min(BLOCK, file.left)).lower()
        last = TO_LAST_FACET.match(content)
        end = (last.end() if last else 0) if file.left else len(content)
        rest = content[end:]
        if len(rest) > LONGEST:
            raise file.damaged(f"facets: no end of a facet within {LONGEST:,} bytes")
        yield content[:end]


def _facets(words: list[bytes]) -> npt.NDArray[np.float64] | None:
    """Coordinates (T, 9) of facets; None where the words are not theirs, or a coordinate is no finite number."""
    count = len(words) // len(FACET)
    if count * len(FACET) < len(words):
        return None
    if any(word and words[k :: len(FACET)].count(word) < count for k, word in enumerate(FACET)):
        return None
    found = np.empty((count, len(COORDINATES)))
    try:
        for column, k in enumerate(COORDINATES):
            found[:, column] = np.array(words[k :: len(FACET)], np.float64)
    except ValueError:
        return None
    return found if np.isfinite(found).all() else None


def _wrong(path: Path, line: int, part: bytes) -> UsageError:
    """An error that names the first word of a text that is none of a facet, and its line; `line`: that of its begin."""
    for number, found in enumerate(re.finditer(rb"\S+", part)):
        at, wanted = number % len(FACET), FACET[number % len(FACET)]
        if found[0] == wanted or (wanted is None and (at not in COORDINATES or _is_finite(found[0]))):
            continue
        line += _lines(part[: found.start()])
        word, needs = one_line(found[0][:40].decode("latin-1")), f"'{wanted.decode()}'" if wanted else "a finite number"
        return UsageError(f"{path}: line {line:,}: '{word}' in place of {needs}: {MENDS}")
    return UsageError(f"{path}: line {line + _lines(part.rstrip()):,}: ends within a facet: {MENDS}")


def _is_finite(word: bytes) -> bool:
    try:
        return math.isfinite(float(word))
    except ValueError:
        return False


def _lines(content: bytes) -> int:
    """Ends of lines, as any system writes them."""
    return content.count(b"\n") + content.count(b"\r") - content.count(b"\r\n")
