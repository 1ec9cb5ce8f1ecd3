"""Meshes of files that take long to read, kept from one run to the next."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import UsageError, about
from ..files import inputs
from ..jit.kept import FREE, kept
from ..meshes.mesh import MeshFacts, TriangleMesh
from ..meshes.read import read_mesh

CODE = ("strandcli.meshes.read",)
LEAST, MOST = 100_000, 8 << 20
"""Bytes of files whose mesh is kept."""
ARRAYS: dict[str, tuple[type, tuple[int, ...]]] = {
    "vertices": (np.float64, (3,)), "triangles": (np.int32, (3,)), "normals": (np.float64, (3,)),
    "corner_normals": (np.float64, (3, 3)), "uv": (np.float32, (3, 2)), "colours": (np.float32, (3,)),
    "merge": (np.int32, ()),
}  # fmt: skip
"""Type and shape of a row of those of `TriangleMesh`, some of which may be None."""


def mesh_of_file(path: Path) -> TriangleMesh:
    """The mesh of a file, as `read_mesh`; where that takes long, and the file names no others, it is kept."""
    with about("mesh", path), inputs.reading(path):
        data = _alone(path)
        return read_mesh(path) if data is None else _kept(path, data)


def _kept(path: Path, data: bytes) -> TriangleMesh:
    """The mesh of a file that holds so much."""

    def made() -> Iterable[NDArray[Any]]:
        mesh = read_mesh(path)
        if inputs.content(path) != data:
            raise UsageError(f"{path}: was written while it was read; read it again when it is written")
        return _taken_apart(mesh)

    like: dict[str, NDArray[Any]] = {FREE + name: np.empty(0, kind) for name, (kind, _) in ARRAYS.items()}
    like |= {FREE + "attributes": np.empty(0, np.float32), FREE + "rest": np.empty(0, np.uint8)}
    of = np.frombuffer(data, np.uint8), path.suffix.lower()
    *found, attributes, rest = kept("read", CODE, of, like, made)
    there, shapes, closed, facts, notes = json.loads(rest.tobytes())
    arrays = {
        name: one.reshape(-1, *shape) if name in there else None
        for (name, (_, shape)), one in zip(ARRAYS.items(), found, strict=True)
    }
    named, begin = {}, 0
    for name, shape in shapes:
        end = begin + int(np.prod(shape))
        named[name] = attributes[begin:end].reshape(shape)
        begin = end
    arrays |= {"smooth": arrays.pop("normals"), "own": arrays.pop("corner_normals")}
    return TriangleMesh(**arrays, attributes=named, closed=closed, facts=MeshFacts(**facts), notes=tuple(notes))  # type: ignore[arg-type]


def _taken_apart(mesh: TriangleMesh) -> Iterable[NDArray[Any]]:
    """A mesh without a texture as arrays, the last one JSON."""
    given = {name: getattr(mesh, name) for name in ARRAYS}
    for name, (kind, _) in ARRAYS.items():
        yield np.zeros(0, kind) if given[name] is None else given[name]
    yield np.concatenate([np.zeros(0, np.float32), *(one.reshape(-1) for one in mesh.attributes.values())])
    there = [name for name, one in given.items() if one is not None]
    shapes = [(name, one.shape) for name, one in mesh.attributes.items()]
    yield np.frombuffer(json.dumps([there, shapes, mesh.closed, asdict(mesh.facts), mesh.notes]).encode(), np.uint8)


def _alone(path: Path) -> bytes | None:
    """The content of a file that has all of its mesh; None where it may have a texture, is soon read, or too large."""
    if path.suffix.lower() not in (".ply", ".stl"):
        return None
    with inputs.opened(path) as file:
        size = os.fstat(file.fileno()).st_size
        data = file.read(size) if LEAST <= size <= MOST else b""
    head = data[: max(data.find(b"end_header"), 0)]
    return data if data and b"texturefile" not in head.lower() else None
