"""Read a mesh from OBJ, PLY, STL or glTF.

mesh = read_mesh(Path("head.obj"))
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from ..errors import StrandError, UsageError, about, one_line
from ..exchange.bounded import Beside, opened
from ..exchange.ply_file import Rows, read_elements, read_header
from ..files.inputs import reading
from . import SUFFIXES
from .gltf import read_gltf
from .make import RawMesh, mesh_of
from .mesh import TriangleMesh, fans_of_lists, linear
from .obj import read_obj
from .stl import read_stl

FACES = ("vertex_indices", "vertex_index")
UV = (("u", "v"), ("s", "t"), ("texture_u", "texture_v"))
XYZ, NORMAL, RGB = ("x", "y", "z"), ("nx", "ny", "nz"), ("red", "green", "blue")
TEXTURE = "texturefile"


def read_ply(path: Path, beside: Beside) -> list[RawMesh]:
    """What a file holds. Raises `UsageError`."""
    with opened(path, ".ply mesh") as file:
        order, elements, comments = read_header(file)
        vertex, face = elements.get("vertex"), elements.get("face")
        if vertex is None or not set(XYZ) <= vertex.properties.keys() or vertex.lists:
            raise file.damaged("header: declares no element vertex with x, y and z", 0)
        if face is None or not face.count:
            raise file.fault("header: declares no element face; a surface is needed, not points or strands", vertex.at)
        if not any(name in FACES and counts and kind[0] != "f" for name, kind, counts in face.columns):
            raise file.fault("element face: has no list vertex_indices", face.at)
        found = read_elements(file, order, elements, frozenset(("vertex", "face")))
    names = [line.split(None, 1)[1] for line in comments if line.lower().startswith(TEXTURE + " ")]
    return [_mesh(found["vertex"], found["face"], beside.picture(names[0]) if names else None)]


def _mesh(vertex: Rows, face: Rows, texture: npt.NDArray[np.uint8] | None) -> RawMesh:
    """Vertices and faces as a mesh."""
    name = next(name for name in FACES if name in face.lengths)
    lengths = face.lengths[name]
    triangles = fans_of_lists(lengths, face.items[name])
    uv = None
    of_vertex = next((names for names in UV if set(names) <= vertex.items.keys()), None)
    of_corner = face.lengths.get("texcoord")
    if of_corner is not None and np.array_equal(of_corner, 2 * lengths):
        uv = fans_of_lists(lengths, face.items["texcoord"].reshape(-1, 2))
    elif of_vertex is not None and not ((triangles < 0) | (triangles >= vertex.count)).any():
        uv = vertex.columns(of_vertex)[triangles]
    known = {*XYZ, *NORMAL, *RGB, "alpha", *(of_vertex or ())}
    return RawMesh(
        vertex.columns(XYZ), triangles, vertex.columns(NORMAL) if set(NORMAL) <= vertex.items.keys() else None, uv,
        linear(np.stack([vertex.items[one] for one in RGB], axis=1)) if set(RGB) <= vertex.items.keys() else None,
        {name.lower(): one.astype(np.float32) for name, one in vertex.items.items() if name not in known},
        texture,
    )  # fmt: skip


READERS: tuple[Callable[[Path, Beside], list[RawMesh]], ...] = (read_obj, read_ply, read_stl, read_gltf, read_gltf)
"""Of files whose names end in `SUFFIXES`."""
MENDS = "write it anew, as .obj, .ply, .stl or .glb with triangles"


def read_mesh(path: Path, like: TriangleMesh | None = None) -> TriangleMesh:
    """The mesh of a file, in its units and axes, triangles of all its parts together. Raises `UsageError` in one line.

    ``like``: an earlier mesh of a sequence, whose triangles, uv and attributes stay; only the places of the
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
    return like.with_vertices(vertices)


def _raw(path: Path) -> RawMesh:
    """What a file holds, whatever its format."""
    suffix = path.suffix.lower()
    if suffix not in SUFFIXES:
        raise UsageError(f"{path}: is no mesh that can be read; read are {', '.join(SUFFIXES)}")
    beside = Beside(path)
    try:
        with np.errstate(all="ignore"):  # what is not finite is reported afterwards
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
