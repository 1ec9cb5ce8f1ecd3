"""The mesh of a solid: read from its file, turned, scaled and placed in the solid's own frame.

Meshes of files that take long to read are kept from one run to the next.
"""

from __future__ import annotations

import json
import os
from bisect import bisect_right
from collections.abc import Iterable, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..errors import UsageError, about
from ..exchange.edit.transform import turning
from ..files import inputs
from ..files.inputs import cached
from ..jit.kept import FREE, kept
from ..meshes.make import LARGEST
from ..meshes.mesh import MeshFacts, TriangleMesh, Vectors
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


UP = "y"
KEPT = 8
"""Meshes that are kept, of the last ones asked for."""


class Placing(NamedTuple):
    """How a file's mesh is placed: settings of `strandcli.solid_shapes.mesh`."""

    up: str
    scale: float
    size: float | None
    place: str


def placing(settings: Any) -> Placing:
    """What a solid's settings say of its place."""
    return Placing(settings.up, settings.scale or 1.0, settings.size, settings.place)


class Moment(NamedTuple):
    """A moment of a mesh that deforms: between two files."""

    before: str
    after: str
    share: float
    """Of the way from the first to the second."""


def moment(keys: Sequence[Any], time: float) -> Moment:
    """The moment at a time in seconds of files with times, which ascend; held before the first and after the last."""
    times = [key.time for key in keys]
    place = min(max(bisect_right(times, time), 1), len(keys) - 1) if len(keys) > 1 else 0
    before, after = keys[max(place - 1, 0)], keys[place]
    span = after.time - before.time
    share = min(max((time - before.time) / span, 0.0), 1.0) if span > 0 else 0.0
    return Moment(before.file, after.file, share)


@cached(KEPT)
def placed(file: str, how: Placing) -> TriangleMesh:
    """The mesh of a file in metres, y up, as its solid has it."""
    mesh = as_in_file(file)
    linear, shift = _transform(file, how)
    if (linear == np.eye(3)).all() and not shift.any():
        return mesh
    moved = mesh.transformed(linear, shift)
    if not np.abs(np.array(moved.box())).max() < LARGEST:
        with about("mesh", file):
            raise UsageError(f"{file}: is too far out for single precision; set the solid's scale or size")
    return moved


@cached(KEPT)
def deformed(file: str, how: Placing, other: str) -> Vectors:
    """The vertices of a mesh as another file has them, placed as those of its own file."""
    if other == file:
        return placed(file, how).vertices
    linear, shift = _transform(file, how)
    found: Vectors = read_mesh(Path(other), like=as_in_file(file)).vertices @ linear.T + shift
    return found


def vertices_at(settings: Any, time: float) -> Vectors:
    """The vertices (V, 3) of a placed mesh at a time in seconds, as it deforms."""
    file, how = settings.file, placing(settings)
    if not settings.deform:
        return placed(file, how).vertices
    return between(file, how, moment(settings.deform, time))


def between(file: str, how: Placing, at: Moment) -> Vectors:
    """The vertices of a placed mesh at a moment."""
    first, second = deformed(file, how, at.before), deformed(file, how, at.after)
    found: Vectors = first + at.share * (second - first)
    return found


@cached(KEPT)
def _transform(file: str, how: Placing) -> tuple[Vectors, Vectors]:
    """The matrix and the shift that place the mesh of a file."""
    turn = turning(how.up, UP)
    corners = np.array(as_in_file(file).box()) @ turn.T
    low, high = corners.min(axis=0), corners.max(axis=0)
    factor = how.scale if how.size is None else how.size / float((high - low).max())
    shift = np.zeros(3)
    if how.place != "file":
        shift = -0.5 * factor * (low + high)
        if how.place == "ground":
            shift[1] = -factor * low[1]
    return factor * turn, shift


@cached(KEPT)
def as_in_file(file: str) -> TriangleMesh:
    """The mesh of a file, in its own units and axes."""
    return mesh_of_file(Path(file))
