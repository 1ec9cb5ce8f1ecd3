"""Lines of Wavefront `.obj` files: statements ``l`` that name vertices."""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from ...errors import UsageError
from ...output.files import write_pieces
from ..bounded import Bounded, opened
from ..files import ReadOptions
from ..obj_lines import MENDS, blocks, line_of, no_numbers, numbers, shown
from ..objects import UNNAMED, pieces, renamed
from ..polylines import IS_MESH, OF_POINT, Lines, joined_lines
from ..strands import OBJECT, Attribute, Source, Strands, TimeSample, without_short
from ..written import left_out

name = ".obj"
suffixes = (".obj",)

ROWS = re.compile(rb"(?:[-+]?\d{1,18} )*")
OTHERS = re.compile(rb"(?<=\d)/(?:[-+]?\d+)?")
"""The row of a texture that may stand behind that of a vertex."""
AT_ONCE = 1 << 14
"""Strands that are written at once."""


class _Found:
    """What was read so far: vertices, (n, 3) each; of lines their rows from 0, how many each has, the number of the
    statement's line, and that of the object; how many polygons there are; and names of objects, the last one's
    number, and whether it is one that ``o`` names."""

    def __init__(self) -> None:
        self.vertices: list[npt.NDArray[np.float32]] = []
        self.count = self.faces = self.points = 0
        self.rows: list[npt.NDArray[np.int32]] = []
        self.lengths: list[npt.NDArray[np.int32]] = []
        self.places: list[npt.NDArray[np.int32]] = []
        self.objects: list[int] = []
        self.names = {b"": 0}
        self.now, self.named = 0, False


def sniff(head: bytes, size: int) -> bool:
    """Never: it begins with any statement."""
    return False


def is_mesh(path: Path) -> bool:
    """Whether a file has polygons, and is no strands, or not alone."""
    with opened(path, ".obj file") as file:
        return any(line.split(None, 1)[:1] == [b"f"] for lines in blocks(file) for line in lines)


def read(path: Path, options: ReadOptions) -> Strands:
    """The strands of a file: its lines, of which one that begins at the vertex where the one before it ends goes on
    with it."""
    found = _Found()
    with opened(path, ".obj file", options.lenient) as file:
        line = 1
        for lines in blocks(file):
            _block(file, found, [one.split() for one in lines], line)
            line += len(lines)
        if not found.rows:
            raise UsageError(f"{path}: {IS_MESH}") if found.faces else file.damaged("holds no lines (l)", 0)
    rows, lengths, places = (np.concatenate(one) for one in (found.rows, found.lengths, found.places))
    objects = np.array(found.objects, np.int32)
    if rows.max(initial=-1) >= found.count:
        at = places[int(np.searchsorted(np.cumsum(lengths), int(rows.argmax()), side="right"))]
        raise UsageError(f"{path}: line {at:,}: 'l' wants 'v' {int(rows.max()) + 1:,} of {found.count:,}: {MENDS}")
    first, rows, objects = joined_lines(Lines(lengths, rows, objects))
    found.rows.clear()
    points = np.concatenate([np.zeros((0, 3), np.float32), *found.vertices])[rows]
    wrong = np.flatnonzero(~np.isfinite(points).all(axis=1))
    if wrong.size and not options.lenient:
        at = line_of(path, b"v", int(rows[wrong[0]]))
        raise UsageError(f"{path}: line {at:,}: vertex of a strand is not finite; 'convert --fix' mends it")
    facts: dict[str, Any] = {"not_read": {"polygons": found.faces}} if found.faces else {}
    names, attributes = _objects(found, objects)
    return without_short(Strands(first, points, attributes, Source(name, facts=facts), names))


def _objects(found: _Found, objects: npt.NDArray[np.int32]) -> tuple[tuple[str, ...], dict[str, Attribute]]:
    """The names of objects that have strands, which are of those of these numbers (S,), and of several the attribute
    that tells them apart; () where strands have no names."""
    there, numbers = np.unique(objects, return_inverse=True)
    if not there.any():
        return (), {}
    known = [one.decode("utf-8", "replace") for one in found.names]
    names = tuple(known[one] or UNNAMED for one in there.tolist())
    return names, {OBJECT: Attribute("strand", numbers.astype(np.int32))} if len(names) > 1 else {}


def _block(file: Bounded, found: _Found, lines: list[list[bytes]], line: int) -> None:
    """Add lines, as their words, of which the first has a number."""
    heads = [words[0] if words else b"" for words in lines]
    for head, words in zip(heads, lines, strict=True):
        if head == b"l":
            found.objects.append(found.now)
        elif head == b"o" or (head == b"g" and not found.named):
            found.named = head == b"o"
            found.now = found.names.setdefault(b" ".join(words[1:]), len(found.names))
    own = [k for k, head in enumerate(heads) if head == b"l"]
    if own:
        before = found.count + np.cumsum([head == b"v" for head in heads])[own]
        _add_lines(file, found, [lines[k][1:] for k in own], before, line + np.array(own, np.int32))
    rows = [words[1:] for head, words in zip(heads, lines, strict=True) if head == b"v"]
    if rows:
        values = numbers(rows, 3)
        if values is None:
            raise no_numbers(file.path, b"v", 3, lines, line)
        with np.errstate(over="ignore"):
            found.vertices.append(values[:, :3].astype(np.float32))
        found.count += len(rows)
    found.faces += heads.count(b"f")


def _add_lines(
    file: Bounded, found: _Found, lines: list[list[bytes]], before: npt.NDArray[np.int64],
    places: npt.NDArray[np.int32],
) -> None:  # fmt: skip
    """Add statements ``l``, as their words, each with how many vertices there are before it and the number of its
    line."""
    lengths = np.array([len(words) for words in lines], np.int32)
    found.points += int(lengths.sum())
    file.room("points of its lines", found.points, OF_POINT)
    text = OTHERS.sub(b"", b" ".join([word for words in lines for word in words]) + b" ")
    rows = np.fromstring(text, np.int64, sep=" ") if ROWS.fullmatch(text) and text.strip() else np.zeros(0, np.int64)
    if rows.size != lengths.sum():
        wrong = (k for k, words in enumerate(lines) if not ROWS.fullmatch(OTHERS.sub(b"", b" ".join(words)) + b" "))
        bad = next(wrong, 0)
        raise UsageError(f"{file.path}: line {places[bad]:,}: 'l' of '{shown(b' '.join(lines[bad]))}': {MENDS}")
    rows = np.where(rows < 0, rows + np.repeat(before, lengths), rows - 1)
    if rows.min(initial=0) < 0:
        at = places[int(np.searchsorted(np.cumsum(lengths), int(rows.argmin()), side="right"))]
        raise UsageError(f"{file.path}: line {at:,}: 'l' wants a 'v' before the first; they count from 1: {MENDS}")
    found.rows.append(np.minimum(rows, 2**31 - 1).astype(np.int32))
    found.lengths.append(lengths)
    found.places.append(places)


def write(path: Path, strands: Strands, samples: Iterable[TimeSample] | None = None) -> list[str]:
    """Write the points of each strand and a line through them, object by object."""
    write_pieces(path, _text(strands))
    return left_out(strands, name, (OBJECT,) if strands.objects else ()) + renamed(strands, _legal, name)


def _legal(label: str) -> str:
    """A name that stands on a line."""
    return " ".join("".join(c if c.isprintable() else "_" for c in label).split())


def _text(strands: Strands) -> Iterable[bytes]:
    """The text of all objects."""
    found, before = pieces(strands, _legal), 0
    for label, one in zip(found.names, found.strands, strict=True):
        if strands.objects:
            yield f"o {label}\n".encode()
        yield from _strands(one, before)
        before += one.points.shape[0]


def _strands(strands: Strands, before: int) -> Iterable[bytes]:
    """The text of strands, some at once, before which there are so many vertices."""
    for begin in range(0, strands.count, AT_ONCE):
        first = strands.first[begin : begin + AT_ONCE + 1]
        points = strands.points[first[0] : first[-1]].tolist()
        yield "".join([f"v {x:.9g} {y:.9g} {z:.9g}\n" for x, y, z in points]).encode()
        pairs = zip((before + first[:-1]).tolist(), (before + first[1:]).tolist(), strict=True)
        yield "".join([f"l {' '.join(map(str, range(low + 1, high + 1)))}\n" for low, high in pairs]).encode()
