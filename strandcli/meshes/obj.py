"""Wavefront `.obj`: polygons with their uv and normals, colours of vertices, and the picture of the first material.

It is read by blocks of lines, so that words of all of it never are in memory.
"""

from __future__ import annotations

import re
import warnings
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from ..errors import UsageError, one_line
from ..exchange.bounded import Bounded, opened
from .files import Beside
from .make import RawMesh
from .polygons import fans_of_lists, linear

BLOCK, LONGEST = 1 << 20, 1 << 22
"""Bytes that are read at once, and of a line."""
TABLES = {b"v": 3, b"vt": 2, b"vn": 3}
"""Statements with numbers, in the order in which corners name their rows, and how many numbers they have at least."""
CORNERS = (
    (re.compile(rb"(?:[-+]?\d+ )*"), (0,)), (re.compile(rb"(?:[-+]?\d+/[-+]?\d+ )*"), (0, 1)),
    (re.compile(rb"(?:[-+]?\d+//[-+]?\d+ )*"), (0, 2)), (re.compile(rb"(?:[-+]?\d+/[-+]?\d+/[-+]?\d+ )*"), (0, 1, 2)),
)  # fmt: skip
"""How corners are written, and the tables that they name."""
CORNER = re.compile(rb"[-+]?\d{1,18}(?:/(?:[-+]?\d{1,18})?){0,2}")
"""A corner that is written in any of these ways, also with slashes that nothing follows."""
OF_CORNER = 30
"""Bytes that a corner of a polygon takes."""
MENDS = "write it anew from its program, with triangles"


@dataclass(slots=True)
class _Found:
    """What was read so far: rows of each table; corners (C, 3), rows of tables from 1, 0 for none; how many each
    polygon has; names of libraries and of materials in their order."""

    path: Path
    tables: dict[bytes, list[npt.NDArray[np.float64]]] = field(default_factory=lambda: {name: [] for name in TABLES})
    rows: dict[bytes, int] = field(default_factory=lambda: dict.fromkeys(TABLES, 0))
    corners: list[npt.NDArray[np.int32]] = field(default_factory=list)
    lengths: list[npt.NDArray[np.int32]] = field(default_factory=list)
    libraries: list[bytes] = field(default_factory=list)
    materials: dict[bytes, None] = field(default_factory=dict)


def read_obj(path: Path, beside: Beside) -> list[RawMesh]:
    """What a file holds. Raises `UsageError`."""
    found = _Found(path)
    with opened(path, ".obj file") as file:
        line = 1
        for lines in _blocks(file):
            _block(found, [one.split() for one in lines], line)
            file.room("corners", sum(map(len, found.corners)), OF_CORNER)
            line += len(lines)
    return [_mesh(found, beside)] if found.corners else []


def _blocks(file: Bounded) -> Iterator[list[bytes]]:
    """Lines, some at once; those that end in a backslash go on in the next one."""
    rest = b""
    while file.left:
        content = rest + file.take("lines", min(BLOCK, file.left))
        end = content.rfind(b"\n") + 1
        while end and (content[end - 2 : end - 1] == b"\\" or content[end - 3 : end - 1] == b"\\\r"):
            end = content.rfind(b"\n", 0, end - 1) + 1
        end = end if file.left else len(content)
        whole, rest = content[:end], content[end:]
        if len(rest) > LONGEST:
            raise file.damaged(f"lines: no end of line within {LONGEST:,} bytes")
        yield whole.replace(b"\\\r\n", b" ").replace(b"\\\n", b" ").splitlines()


def _block(found: _Found, lines: list[list[bytes]], line: int) -> None:
    """Add lines, as their words, of which the first has a number."""
    faces = [k for k, words in enumerate(lines) if words and words[0] == b"f"]
    if faces:
        words = [word for k in faces for word in lines[k][1:]]
        lengths = np.array([len(lines[k]) - 1 for k in faces], np.int32)
        corners, bad = _corners(words)
        used = corners != 0
        if (corners < 0).any():
            corners = _absolute(found, lines, faces, lengths, corners)
        wrong = np.flatnonzero((corners < 0).any(axis=1) | (used & (corners == 0)).any(axis=1) | (corners[:, 0] == 0))
        if wrong.size or bad is not None:
            first = int(wrong[0]) if bad is None else bad
            face = faces[int(np.searchsorted(np.cumsum(lengths), first, side="right"))]
            why = "indices count from 1" if bad is None else "is no corner, such as 1, 1/1, 1//1 or 1/1/1"
            raise UsageError(f"{found.path}: line {line + face:,}: '{_shown(words[first])}': {why}: {MENDS}")
        found.corners.append(corners)
        found.lengths.append(lengths)
    for name in TABLES:
        rows = [words[1:] for words in lines if words and words[0] == name]
        if rows:
            numbers = _numbers(name, rows)
            if numbers is None:
                raise _no_numbers(found.path, name, lines, line)
            found.tables[name].append(numbers)
            found.rows[name] += len(rows)
    for words in lines:
        if words and words[0] == b"mtllib":
            found.libraries.append(b" ".join(words[1:]))
        elif words and words[0] == b"usemtl":
            found.materials[b" ".join(words[1:])] = None


def _numbers(name: bytes, rows: list[list[bytes]]) -> npt.NDArray[np.float64] | None:
    """Rows of numbers (n, k), as many of each as the shortest has; None where those are too few, or no numbers."""
    width = min(map(len, rows))
    if width < TABLES[name]:
        return None
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # of text that is no number
        try:
            found = np.fromstring(b" ".join([b" ".join(row[:width]) for row in rows]), np.float64, sep=" ")
            return found.reshape(len(rows), width)
        except (ValueError, DeprecationWarning):
            return None


def _no_numbers(path: Path, name: bytes, lines: list[list[bytes]], line: int) -> UsageError:
    """The error of the first statement of a name among lines that has not the numbers it needs."""
    those = [(line + k, words[1:]) for k, words in enumerate(lines) if words and words[0] == name]
    at, words = next((one for one in those if _numbers(name, [one[1]]) is None), those[0])
    letters = name.decode()
    if len(words) < TABLES[name]:
        return UsageError(
            f"{path}: line {at:,}: '{letters}' of {len(words)} numbers, {TABLES[name]} are needed: {MENDS}"
        )
    return UsageError(f"{path}: line {at:,}: '{letters}' with what is no number: '{_shown(b' '.join(words))}': {MENDS}")


def _shown(words: bytes) -> str:
    """Words of a file for a message."""
    return one_line(words[:40].decode("utf-8", "replace"))


def _corners(words: list[bytes]) -> tuple[npt.NDArray[np.int32], int | None]:
    """Corners (C, 3) as they are written, and the number of the first word that is none."""
    text = b" ".join(words) + b" "
    corners = np.zeros((len(words), len(TABLES)), np.int32)
    for pattern, tables in CORNERS:
        if pattern.fullmatch(text):
            values = np.fromstring(text.replace(b"/", b" "), np.int64, sep=" ").reshape(-1, len(tables))
            corners[:, tables] = np.clip(values, -(2**31), 2**31 - 1)
            return corners, None
    for k, word in enumerate(words):  # each its own way
        if not CORNER.fullmatch(word):
            return corners[:k], k
        parts = [int(part) if part else 0 for part in word.split(b"/")]
        corners[k, : len(parts)] = np.clip(parts, -(2**31), 2**31 - 1)
    return corners, None


def _absolute(
    found: _Found, lines: list[list[bytes]], faces: list[int], lengths: npt.NDArray[np.int32], corners: npt.NDArray[Any]
) -> npt.NDArray[np.int32]:
    """Corners whose indices count from the begin, where they counted back from their line; still negative for those
    before the begin, and 0 for the one before the first."""
    for column, name in enumerate(TABLES):
        before = found.rows[name] + np.cumsum([bool(words) and words[0] == name for words in lines])
        there = np.repeat(before[faces], lengths)
        back = corners[:, column] < 0
        corners[back, column] += (there[back] + 1).astype(np.int32)
    return corners


def _mesh(found: _Found, beside: Beside) -> RawMesh:
    """All polygons as one mesh."""
    corners, lengths = np.concatenate(found.corners), np.concatenate(found.lengths)
    found.corners.clear()
    for column, name in enumerate(TABLES):
        most = int(corners[:, column].max(initial=0))
        if most > found.rows[name]:
            face = np.searchsorted(np.cumsum(lengths), corners[:, column].argmax(), side="right")
            raise UsageError(
                f"{found.path}: line {_line_of(found.path, b'f', int(face)):,}: a corner wants '{name.decode()}' "
                f"{most:,} of {found.rows[name]:,}: {MENDS}"
            )
    table = {name: _table(parts, TABLES[name]) for name, parts in found.tables.items()}
    colours = None
    if all(one.shape[1] >= 6 for one in found.tables[b"v"]):
        colours = linear(np.concatenate([one[:, 3:6] for one in found.tables[b"v"]]))
    found.tables.clear()
    wrong = np.flatnonzero(~np.isfinite(table[b"v"]).all(axis=1))
    used = wrong[np.isin(wrong, corners[:, 0])]
    if used.size:
        line, first = _line_of(found.path, b"v", int(used[0]) - 1), ", ".join(f"{x:g}" for x in table[b"v"][used[0]])
        raise UsageError(f"{found.path}: line {line:,}: vertex ({first}) of a polygon is not finite: {MENDS}")
    uv = fans_of_lists(lengths, table[b"vt"][corners[:, 1]].astype(np.float32)) if corners[:, 1].any() else None
    normals, rows = None, None
    if corners[:, 2].any():
        normals, rows = table[b"vn"], fans_of_lists(lengths, corners[:, 2].copy())
    triangles = fans_of_lists(lengths, corners[:, 0] - np.int32(1))
    texture, notes = _texture(found, beside)
    return RawMesh(
        table[b"v"][1:], triangles, normals, uv, colours, texture=texture, notes=notes, normal_rows=rows
    )  # fmt: skip


def _line_of(path: Path, name: bytes, number: int) -> int:
    """The line of a statement, of which there are so many of that name before it; 0 of none."""
    line = 1
    with opened(path, ".obj file") as file:
        for lines in _blocks(file):
            places = [k for k, words in enumerate(lines) if words.split(None, 1)[:1] == [name]]
            if number < len(places):
                return line + places[number]
            number -= len(places)
            line += len(lines)
    return 0


def _table(parts: list[npt.NDArray[np.float64]], width: int) -> npt.NDArray[np.float64]:
    """Rows (1 + n, width) of numbers, of which row 0 is that of corners that name none."""
    return np.concatenate([np.zeros((1, width)), *(one[:, :width] for one in parts)])


def _texture(found: _Found, beside: Beside) -> tuple[npt.NDArray[np.uint8] | None, tuple[str, ...]]:
    """The picture of the first material that has one, and a note where others have one, too."""
    named: dict[bytes, str] = {}
    for library in found.libraries:
        try:
            content = beside.get(library.decode("utf-8", "replace"))
        except (OSError, ValueError):
            continue
        material = b""
        for line in content.splitlines():
            match line.split(None, 1):
                case [b"newmtl", name]:
                    material = b" ".join(name.split())
                case [b"map_Kd", name]:  # options before the name have no blanks in theirs
                    last = name.split()[-1] if name.startswith(b"-") else name.strip()
                    named.setdefault(material, last.decode("utf-8", "replace"))
    names = list(dict.fromkeys(named[one] for one in found.materials if one in named))
    pictures = (beside.picture(one) for one in names)
    texture = next((one for one in pictures if one is not None), None)
    more = (f"{len(names)} textures: the first is taken for all of it",) if len(names) > 1 else ()
    return texture, more
