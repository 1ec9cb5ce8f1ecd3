"""Lines of Wavefront `.obj` files: statements ``l`` that name vertices."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ...errors import UsageError
from ...output.files import write_pieces
from ..bounded import Growing, not_finite, opened
from ..files import ReadOptions
from ..obj_file import TAKES, ObjFile, blocks, line_of
from ..objects import UNNAMED, pieces, renamed
from ..strands import OBJECT, Attribute, Offsets, Source, Strands, TimeSample, spans, without_short
from ..written import left_out, values_of

name = ".obj"
suffixes = (".obj",)

AT_ONCE = 1 << 16
"""Points that are written at once."""
OF_POINT = TAKES[b"l"][1]
"""Bytes that a point of a strand and its row take; lines may name one point often."""
IS_MESH = (
    "is a mesh, neither a preset nor strands: it has no lines; 'strandcli info' draws it with --picture, "
    "emitter.shape of a preset has strands grow on it, and solids have it drawn"
)


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
    names, faces, each = _Names(), 0, Growing(np.int32)
    with opened(path, ".obj file", options.lenient) as file:
        found = ObjFile(file, b"l", np.float32, lambda colours: colours.astype(np.float32))
        for heads, lines in found.blocks():
            faces += heads.count(b"f")
            each.add(names.of_lines(heads, lines))
        if not found.lengths.size:
            raise UsageError(f"{path}: {IS_MESH}") if faces else file.damaged("has no lines (l)", 0)
    rows, vertices = found.rows.taken()[:, 0] - np.int32(1), found.tables[b"v"].taken()
    first, rows, objects = joined_lines(Lines(found.lengths.taken(), rows, each.taken()))
    points = at_rows(vertices, rows)
    bad, row = not_finite(points)
    if bad and not options.lenient:
        at = line_of(path, b"v", int(rows[row]))
        raise UsageError(f"{path}: line {at:,}: vertex of a strand is not finite; 'convert --fix' mends it")
    labels, attributes = names.used(objects)
    not_read = {"polygons": faces}
    if found.colours.size == len(vertices):
        attributes["colour"] = Attribute("point", at_rows(found.colours.taken(), rows))
    else:
        not_read["colours of vertices, where others have none"] = found.coloured
    not_read = {what: many for what, many in not_read.items() if many}
    facts: dict[str, Any] = {"not_read": not_read} if not_read else {}
    return without_short(Strands(first, points, attributes, Source(name, facts=facts), labels))


class _Names:
    """Names of objects, by ``o``, or by ``g`` where there is no ``o``."""

    def __init__(self) -> None:
        self.numbers = {b"": 0}
        self.now, self.by_object = 0, False

    def of_lines(self, heads: list[bytes], lines: list[list[bytes]]) -> list[int]:
        """The number of the object that each statement ``l`` is of."""
        found = []
        for head, words in zip(heads, lines, strict=True):
            if head == b"l":
                found.append(self.now)
            elif head == b"o" or (head == b"g" and not self.by_object):
                self.by_object = head == b"o"
                self.now = self.numbers.setdefault(b" ".join(words[1:]), len(self.numbers))
        return found

    def used(self, objects: npt.NDArray[np.int32]) -> tuple[tuple[str, ...], dict[str, Attribute]]:
        """The names of objects that have strands, which are of those of these numbers (S,), and of several the
        attribute that tells them apart; () where strands have no names."""
        used = np.zeros(len(self.numbers), np.bool_)
        used[objects] = True
        if not used[1:].any():
            return (), {}
        names = tuple(
            one.decode("utf-8", "replace") or UNNAMED for one, has in zip(self.numbers, used, strict=True) if has
        )
        numbers = (np.cumsum(used, dtype=np.int32) - 1)[objects]
        return names, {OBJECT: Attribute("strand", numbers)} if len(names) > 1 else {}


class Lines(NamedTuple):
    """Lines of a file."""

    lengths: npt.NDArray[np.int32]
    """(L,) rows that each names."""
    rows: npt.NDArray[np.int32]
    """(I,) of the table, one line after the other."""
    objects: npt.NDArray[np.int32]
    """(L,) number of the object that each is of."""


def joined_lines(lines: Lines) -> tuple[Offsets, npt.NDArray[np.int32], npt.NDArray[np.int32]]:
    """Offsets (S + 1,) of strands, the row of each of their points, and the number of each one's object. A line
    that begins at the row where the one before it ends goes on with it: many programs write a line a segment."""
    some = lines.lengths > 0
    lengths, of = lines.lengths[some].astype(np.int64), lines.objects[some]
    ends = np.cumsum(lengths)
    begins = ends - lengths
    goes_on = np.zeros(lengths.size, np.bool_)
    goes_on[1:] = lines.rows[begins[1:]] == lines.rows[ends[:-1] - 1]
    goes_on[1:] &= (lengths[1:] > 1) & (lengths[:-1] > 1) & (of[1:] == of[:-1])
    keep = np.ones(lines.rows.size, np.bool_)
    keep[begins[goes_on]] = False
    first = (begins - np.cumsum(goes_on))[~goes_on]
    return np.append(first, np.count_nonzero(keep)), lines.rows[keep], of[~goes_on]


def at_rows(table: npt.NDArray[Any], rows: npt.NDArray[np.int32]) -> npt.NDArray[Any]:
    """The rows of a table (V, k) that strands name one after the other (P,); the table itself where they name it so."""
    own = np.array_equal(rows, np.arange(rows.size, dtype=np.int32))
    return table[: rows.size] if own else table[rows]


def write(path: Path, strands: Strands, samples: Iterable[TimeSample] | None = None) -> list[str]:
    """Write the points of each strand, with colours where there are several, and a line through them, object by
    object."""
    write_pieces(path, _text(strands))
    retained = [*([OBJECT] if strands.objects else []), *(["colour"] if _colours(strands) is not None else [])]
    return left_out(strands, name, retained) + renamed(strands, _legal, name)


def _legal(label: str) -> str:
    """A name that stands on a line, which a backslash at its end would join to the next one."""
    return " ".join("".join(c if c.isprintable() and c != "\\" else "_" for c in label).split())


def _text(strands: Strands) -> Iterable[bytes]:
    """The text of all objects."""
    found, before = pieces(strands, _legal), 0
    for label, one in zip(found.names, found.strands, strict=True):
        if strands.objects:
            yield f"o {label}\n".encode()
        yield from _strands(one, before)
        before += one.points.shape[0]


def _strands(strands: Strands, before: int) -> Iterable[bytes]:
    """The text of strands, some points at once, before which there are so many vertices."""
    colours = _colours(strands)
    form = " ".join(["v", *["%.9g"] * (3 if colours is None else 6)]) + "\n"
    for rows, points in spans(strands.first, AT_ONCE):
        values = strands.points[points]
        if colours is not None:
            values = np.concatenate([values, colours[points]], axis=1)
        yield "".join([form % tuple(row) for row in values.tolist()]).encode()
        for low, high in pairwise((before + strands.first[rows.start : rows.stop + 1]).tolist()):
            yield f"l {' '.join(map(str, range(low + 1, high + 1)))}\n".encode()


def _colours(strands: Strands) -> npt.NDArray[np.float32] | None:
    """The colours (P, 3) of points; None where there are none, or one for all."""
    one = strands.attributes.get("colour")
    return None if one is None or one.domain == "groom" or one.values.ndim != 2 else values_of(strands, "colour", 3)
