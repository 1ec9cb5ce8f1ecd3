"""`.ply` with faces: any polygons, every number of a vertex as an attribute."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt

from ..exchange.beside import Beside
from ..exchange.bounded import opened
from ..exchange.ply_file import Rows, read_elements, read_header
from .make import RawMesh
from .mesh import fans_of_lists, linear

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
