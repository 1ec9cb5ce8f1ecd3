"""Read a mesh from OBJ, PLY, STL or glTF.

mesh = read_mesh(Path("head.obj"))
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import StrandError, UsageError, about, one_line
from ..exchange.beside import Beside
from ..files.inputs import reading
from . import SUFFIXES
from .gltf import read_gltf
from .make import RawMesh, mesh_of
from .mesh import TriangleMesh
from .obj import read_obj
from .ply import read_ply
from .stl import read_stl

READERS: tuple[Callable[[Path, Beside], list[RawMesh]], ...] = (read_obj, read_ply, read_stl, read_gltf, read_gltf)
"""Of files whose names end in `SUFFIXES`."""
MENDS = "write it anew, as .obj, .ply, .stl or .glb with triangles"


def read_mesh(path: Path, like: TriangleMesh | None = None) -> TriangleMesh:
    """The mesh of a file, in its units and axes, triangles of all its parts together. Raises `UsageError` in one line.

    ``like``: an earlier mesh of a sequence, whose triangles, uv and attributes are kept; only the places of the
    vertices are read, which have to be as many in the file, in the same order.
    """
    with about("mesh", path), reading(path):
        if like is None:
            return mesh_of(_raw(Path(path)), str(path))  # which alone has it, and lets go what it is done with
        return _moved(_raw(Path(path)), like, path)


def _moved(raw: RawMesh, like: TriangleMesh, path: Path) -> TriangleMesh:
    """Another mesh with the places of its vertices taken from a file."""
    merge = like.merge
    count = raw.vertices.shape[0]
    if merge is None or merge.size != count:
        known = "unknown" if merge is None else f"{merge.size:,}"
        raise UsageError(
            f"{path}: has {count:,} vertices, the mesh that it moves has {known}; "
            "write all files of the sequence from one mesh, in one format"
        )
    vertices = np.empty_like(like.vertices)
    vertices[merge[merge >= 0]] = raw.vertices[merge >= 0]
    if not np.isfinite(vertices).all():
        raise UsageError(f"{path}: has vertices that are not finite; mend it in its program")
    return replace(like, vertices=vertices, smooth=None, own=None)


def _raw(path: Path) -> RawMesh:
    """What a file holds, whatever its format."""
    suffix = path.suffix.lower()
    if suffix not in SUFFIXES:
        raise UsageError(f"{path}: is no mesh that can be read; read are {', '.join(SUFFIXES)}")
    beside = Beside(path)
    try:
        with np.errstate(all="ignore"):  # what is not finite is told afterwards
            found = joined(READERS[SUFFIXES.index(suffix)](path, beside))
    except (StrandError, MemoryError):
        raise
    except Exception as error:  # whatever else a damaged file makes happen
        why = one_line(f"{type(error).__name__}: {error}")[:120]
        raise UsageError(f"{path}: cannot be read as {suffix} ({why}); {MENDS}") from None
    notes = list(found.notes)
    for names, what in (
        (beside.missing, "not found, or not in its folder"),
        (beside.unread, "no pictures that can be read, such as PNG or JPEG"),
    ):
        if names:
            notes.append(f"{what}: {', '.join(map(one_line, names[:3]))}")
    return replace(found, notes=tuple(notes))


def joined(parts: Sequence[RawMesh]) -> RawMesh:
    """Several parts as one."""
    if not parts:
        return RawMesh(np.zeros((0, 3)), np.zeros((0, 3), np.int64))
    if len(parts) == 1:
        return parts[0]
    begins = np.cumsum([0, *(one.vertices.shape[0] for one in parts)])
    textures = [one.texture for one in parts if one.texture is not None]
    notes = tuple(note for one in parts for note in one.notes)
    if len(textures) > 1:
        notes += (f"{len(textures)} textures: the first is taken for all of it",)
    names = {name: one.attributes[name].shape[1:] for one in parts for name in one.attributes}

    def together(values: list[Any], shapes: Sequence[tuple[int, ...]], empty: float) -> Any:
        """All values one after the other, and `empty` where a part has none; None where no part has any."""
        if all(one is None for one in values):
            return None
        pairs = zip(values, shapes, strict=True)
        return np.concatenate([np.full(shape, empty) if one is None else one for one, shape in pairs])

    sizes = [one.vertices.shape for one in parts]
    corners = [(one.triangles.shape[0], 3, 2) for one in parts]
    return RawMesh(
        np.concatenate([one.vertices for one in parts]),
        np.concatenate([one.triangles + begin for one, begin in zip(parts, begins, strict=False)]),
        together([one.normals for one in parts], sizes, 0.0),
        together([one.uv for one in parts], corners, 0.0),
        together([one.colours for one in parts], sizes, 1.0),
        {
            name: together(
                [one.attributes.get(name) for one in parts], [(size[0], *shape) for size in sizes], 0.0
            )
            for name, shape in names.items()
        },
        textures[0] if textures else None, notes,
    )  # fmt: skip
