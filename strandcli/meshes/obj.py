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
from ..exchange.bounded import Beside, Growing, opened
from ..exchange.obj_lines import MENDS as ANEW
from ..exchange.obj_lines import blocks, line_of, no_numbers, numbers, shown
from .make import RawMesh, lines_beside
from .mesh import fans_of_lists, linear

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
    """What was read so far: rows of each table; linear colours of the first vertices; corners (C, 3), rows of tables
    from 1, 0 for none; how many each polygon has; names of libraries and of materials in their order."""

    path: Path
    tables: dict[bytes, Growing] = field(
        default_factory=lambda: {name: Growing(np.float64, TABLES[name]) for name in TABLES}
    )
    colours: Growing = field(default_factory=lambda: Growing(np.float32, 3))
    corners: Growing = field(default_factory=lambda: Growing(np.int32, 3))
    lengths: Growing = field(default_factory=lambda: Growing(np.int32))
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
            file.room("corners", found.corners.size, OF_CORNER)
            line += len(lines)
    return [_mesh(found, beside)] if found.corners.size else []


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
        found.corners.add(corners)
        found.lengths.add(lengths)
    for name in TABLES:
        rows = [words[1:] for words in lines if words and words[0] == name]
        if rows:
            values = numbers(rows, TABLES[name])
            if values is None:
                raise no_numbers(found.path, name, TABLES[name], lines, line)
            if name == b"v" and values.shape[1] >= 6 and found.colours.size == found.tables[name].size:
                found.colours.add(linear(values[:, 3:6]))
            found.tables[name].add(values[:, : TABLES[name]])
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
        before = found.tables[name].size + np.cumsum([bool(words) and words[0] == name for words in lines])
        there = np.repeat(before[faces], lengths)
        back = corners[:, column] < 0
        corners[back, column] += (there[back] + 1).astype(np.int32)
    return corners


def _mesh(found: _Found, beside: Beside) -> RawMesh:
    """All polygons as one mesh."""
    corners, lengths = found.corners.taken(), found.lengths.taken()
    for column, name in enumerate(TABLES):
        most = int(corners[:, column].max(initial=0))
        if most > found.tables[name].size:
            face = np.searchsorted(np.cumsum(lengths), corners[:, column].argmax(), side="right")
            raise UsageError(
                f"{found.path}: line {line_of(found.path, b'f', int(face)):,}: a corner wants '{name.decode()}' "
                f"{most:,} of {found.tables[name].size:,}: {MENDS}"
            )
    vertices, uv_of, normals_of = (found.tables[name].taken() for name in (b"v", b"vt", b"vn"))
    colours = found.colours.taken() if found.colours.size == len(vertices) else None
    wrong = np.flatnonzero(~np.isfinite(vertices).all(axis=1))
    used = wrong[np.isin(wrong + 1, corners[:, 0])] if wrong.size else wrong
    if used.size:
        line, first = line_of(found.path, b"v", int(used[0])), ", ".join(f"{x:g}" for x in vertices[used[0]])
        raise UsageError(f"{found.path}: line {line:,}: vertex ({first}) of a polygon is not finite: {MENDS}")
    uv = fans_of_lists(lengths, _rows_of(uv_of.astype(np.float32), corners[:, 1])) if corners[:, 1].any() else None
    normals, rows = None, None
    if corners[:, 2].any():
        normals = np.concatenate([np.zeros((1, 3)), normals_of])  # row 0 is that of corners that name none
        rows = fans_of_lists(lengths, corners[:, 2].copy())
    triangles = fans_of_lists(lengths, corners[:, 0] - np.int32(1))
    texture, notes = _texture(found, beside)
    notes += lines_beside(found.lines)
    return RawMesh(
        vertices, triangles, normals, uv, colours, texture=texture, notes=notes, normal_rows=rows
    )  # fmt: skip


def _rows_of(table: npt.NDArray[Any], rows: npt.NDArray[np.int32]) -> npt.NDArray[Any]:
    """The rows of a table that corners name from 1, zeros where they name none."""
    found = table[np.maximum(rows - 1, 0)]
    found[rows == 0] = 0
    return found


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
