"""Wavefront `.obj`: polygons with their uv and normals, colours of vertices, and the picture of the first material."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from ..exchange.bounded import Beside, opened
from ..exchange.obj_file import ObjFile, line_of
from .make import RawMesh, lines_beside
from .mesh import fans_of_lists, linear


def read_obj(path: Path, beside: Beside) -> list[RawMesh]:
    """What a file holds. Raises `UsageError`."""
    libraries: list[bytes] = []
    materials: dict[bytes, None] = {}
    strands = 0
    with opened(path, ".obj file") as file:
        found = ObjFile(file, b"f", np.float64, linear)
        for heads, lines in found.blocks():
            strands += heads.count(b"l")
            for head, words in zip(heads, lines, strict=True):
                if head == b"mtllib":
                    libraries.append(b" ".join(words[1:]))
                elif head == b"usemtl":
                    materials[b" ".join(words[1:])] = None
    if not found.rows.size:
        return []
    texture, notes = _texture(libraries, materials, beside)
    return [_mesh(found, texture, notes + lines_beside(strands))]


def _mesh(found: ObjFile, texture: npt.NDArray[np.uint8] | None, notes: tuple[str, ...]) -> RawMesh:
    """All polygons as one mesh."""
    corners, lengths = found.rows.taken(), found.lengths.taken()
    vertices, uv_of, normals_of = (table.taken() for table in found.tables.values())
    colours = found.colours.taken() if found.colours.size == len(vertices) else None
    wrong = np.flatnonzero(~np.isfinite(vertices).all(axis=1))
    used = wrong[np.isin(wrong + 1, corners[:, 0])] if wrong.size else wrong
    if used.size:
        at, first = line_of(found.file.path, b"v", int(used[0])), ", ".join(f"{x:g}" for x in vertices[used[0]])
        raise found.fault(at, f"vertex ({first}) of a polygon is not finite")
    uv = fans_of_lists(lengths, _rows_of(uv_of.astype(np.float32), corners[:, 1])) if corners[:, 1].any() else None
    normals, rows = None, None
    if corners[:, 2].any():
        normals = np.concatenate([np.zeros((1, 3)), normals_of])  # row 0 is that of corners that name none
        rows = fans_of_lists(lengths, corners[:, 2].copy())
    triangles = fans_of_lists(lengths, corners[:, 0] - np.int32(1))
    return RawMesh(
        vertices, triangles, normals, uv, colours, texture=texture, notes=notes, normal_rows=rows
    )  # fmt: skip


def _rows_of(table: npt.NDArray[Any], rows: npt.NDArray[np.int32]) -> npt.NDArray[Any]:
    """The rows of a table that corners name from 1, zeros where they name none."""
    found = table[np.maximum(rows - 1, 0)]
    found[rows == 0] = 0
    return found


def _texture(
    libraries: list[bytes], materials: dict[bytes, None], beside: Beside
) -> tuple[npt.NDArray[np.uint8] | None, tuple[str, ...]]:
    """The picture of the first material that has one, and a note where more have one."""
    named: dict[bytes, str] = {}
    for library in libraries:
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
    names = list(dict.fromkeys(named[one] for one in materials if one in named))
    pictures = (beside.picture(one) for one in names)
    texture = next((one for one in pictures if one is not None), None)
    more = (f"{len(names)} textures: the first is taken for all of it",) if len(names) > 1 else ()
    return texture, more
