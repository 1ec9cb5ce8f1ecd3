"""Meshes of files that take long to read, kept from one run to the next."""

from __future__ import annotations

import json
from collections.abc import Iterable
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..kept import FREE, kept
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


def mesh_of_file(path: Path, size: int) -> TriangleMesh:
    """The mesh of a file of so many bytes, as `read_mesh`; where that takes long, and the file names no others, it is
    kept."""
    content = _alone(path) if LEAST <= size <= MOST else None
    if content is None:
        return read_mesh(path)
    like: dict[str, NDArray[Any]] = {FREE + name: np.empty(0, kind) for name, (kind, _) in ARRAYS.items()}
    like |= {FREE + "attributes": np.empty(0, np.float32), FREE + "rest": np.empty(0, np.uint8)}
    of = np.frombuffer(content, np.uint8), path.suffix.lower()
    *found, attributes, rest = kept("read", CODE, of, like, lambda: _taken_apart(read_mesh(path)))
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
    """The content of a file that has all of its mesh; None where it may have a texture, and where it cannot be read."""
    if path.suffix.lower() not in (".ply", ".stl"):
        return None
    try:
        content = path.read_bytes()
    except OSError:
        return None
    head = content[: max(content.find(b"end_header"), 0)]
    return None if b"texturefile" in head.lower() else content
