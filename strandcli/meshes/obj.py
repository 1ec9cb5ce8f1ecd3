"""Wavefront `.obj`: polygons with their uv and normals, colours of vertices, and the picture of the first material.

It is read by blocks of lines, so that words of all of it never are in memory.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from ..errors import UsageError
from ..exchange.beside import Beside
from ..exchange.bounded import opened
from ..exchange.obj_lines import MENDS as ANEW
from ..exchange.obj_lines import blocks, line_of, no_numbers, numbers, shown
from .make import RawMesh, lines_beside
from .polygons import fans_of_lists, linear

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
MENDS = f"{ANEW}, with triangles"


@dataclass(slots=True)
class _Found:
    """What was read so far: rows of each table; corners (C, 3), rows of tables from 1, 0 for none; how many each
    polygon has; names of libraries and of materials in their order."""

    path: Path
    tables: dict[bytes, list[npt.NDArray[np.float64]]] = field(default_factory=lambda: {name: [] for name in TABLES})
    rows: dict[bytes, int] = field(default_factory=lambda: dict.fromkeys(TABLES, 0))
    corners: list[npt.NDArray[np.int32]] = field(default_factory=list)
    lengths: list[npt.NDArray[np.int32]] = field(default_factory=list)
    lines: int = 0
    """Statements of lines, which are strands."""
    libraries: list[bytes] = field(default_factory=list)
    materials: dict[bytes, None] = field(default_factory=dict)


def read_obj(path: Path, beside: Beside) -> list[RawMesh]:
    """What a file holds. Raises `UsageError`."""
    found = _Found(path)
    with opened(path, ".obj file") as file:
        line = 1
        for lines in blocks(file):
            _block(found, [one.split() for one in lines], line)
            file.room("corners", sum(map(len, found.corners)), OF_CORNER)
            line += len(lines)
    return [_mesh(found, beside)] if found.corners else []


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
            raise UsageError(f"{found.path}: line {line + face:,}: '{shown(words[first])}': {why}: {MENDS}")
        found.corners.append(corners)
        found.lengths.append(lengths)
    for name in TABLES:
        rows = [words[1:] for words in lines if words and words[0] == name]
        if rows:
            values = numbers(rows, TABLES[name])
            if values is None:
                raise no_numbers(found.path, name, TABLES[name], lines, line)
            found.tables[name].append(values)
            found.rows[name] += len(rows)
    for words in lines:
        found.lines += bool(words) and words[0] == b"l"
        if words and words[0] == b"mtllib":
            found.libraries.append(b" ".join(words[1:]))
        elif words and words[0] == b"usemtl":
            found.materials[b" ".join(words[1:])] = None


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
                f"{found.path}: line {line_of(found.path, b'f', int(face)):,}: a corner wants '{name.decode()}' "
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
        line, first = line_of(found.path, b"v", int(used[0]) - 1), ", ".join(f"{x:g}" for x in table[b"v"][used[0]])
        raise UsageError(f"{found.path}: line {line:,}: vertex ({first}) of a polygon is not finite: {MENDS}")
    uv = fans_of_lists(lengths, table[b"vt"][corners[:, 1]].astype(np.float32)) if corners[:, 1].any() else None
    normals, rows = None, None
    if corners[:, 2].any():
        normals, rows = table[b"vn"], fans_of_lists(lengths, corners[:, 2].copy())
    triangles = fans_of_lists(lengths, corners[:, 0] - np.int32(1))
    texture, notes = _texture(found, beside)
    notes += lines_beside(found.lines)
    return RawMesh(
        table[b"v"][1:], triangles, normals, uv, colours, texture=texture, notes=notes, normal_rows=rows
    )  # fmt: skip


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
