"""A placed mesh with what rays, contact and shading need of it, made once for each file and settings; and the data of
all meshes of a scene: where the arrays of each begin, as kernels take them.

Normals are the file's, or smooth ones that keep creases.
"""

from __future__ import annotations

import ctypes
import math
from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..files.inputs import cached
from ..jit.array_cache import FREE, Arrays, cached_arrays
from ..meshes.bvh import Bvh, DistanceGrid, make_bvh, make_distance_grid, moved
from ..meshes.mesh import TriangleMesh, Vectors, angles, unit
from .kernels import arrays as at
from .kernels.arrays import Data
from .maps import LINEAR, Pyramid, picture, pyramid
from .read import KEPT, Moment, Placing, between, deformed, moment, placed, placing

GREY = (0.18, 0.18, 0.18)
"""The default of a solid's `colour`."""


class Key(NamedTuple):
    """All that a prepared mesh follows from."""

    file: str
    placing: Placing
    resolution: int
    coloured: bool
    """Whether colours of the file are drawn."""
    texture: str | None
    crease: float
    """Degrees."""
    files: tuple[str, ...] = ()
    """All files between which it deforms."""
    moment: Moment | None = None


class Prepared(NamedTuple):
    """A mesh for kernels."""

    bvh: Bvh
    grid: DistanceGrid
    faces: NDArray[np.float32]
    """(T, 3) unit normals of triangles, in the mesh's order."""
    normals: NDArray[np.float32]
    """(T, 3, 3) unit normals of corners, of triangles in the tree's order, as those below."""
    colours: NDArray[np.float32]
    """(T, 3, 3) linear colours of corners; no rows without."""
    uv: NDArray[np.float32]
    """(T, 3, 2) of corners; no rows without a texture."""
    density: NDArray[np.float32]
    """(T,) texels a metre; no rows without a texture."""
    texture: Pyramid | None


def key_of(settings: Any, time: float = 0.0) -> Key:
    """The key of a solid's settings at a time in seconds."""
    coloured = settings.colour_from == "file" or (
        settings.colour_from == "auto" and (tuple(settings.colour) == GREY or bool(settings.texture))
    )
    return Key(
        settings.file, placing(settings), settings.resolution, coloured, settings.texture, settings.crease,
        _files(settings), moment(settings.deform, time) if settings.deform else None,
    )  # fmt: skip


def _files(settings: Any) -> tuple[str, ...]:
    """The files between which a mesh deforms."""
    return tuple(key.file for key in settings.deform)


def mesh_of(settings: Any) -> TriangleMesh:
    """The placed mesh of a solid's settings."""
    return placed(settings.file, placing(settings))


def reach_of(settings: Any) -> float:
    """Distance of the farthest vertex from the origin of the solid's frame, metres, at any time."""
    return _extent(settings.file, placing(settings), _files(settings))[2]


def box_of(settings: Any) -> tuple[Vectors, Vectors]:
    """Low and high corner of a solid's mesh at any time, metres."""
    return _extent(settings.file, placing(settings), _files(settings))[:2]


@cached(KEPT)
def _extent(file: str, how: Placing, files: tuple[str, ...]) -> tuple[Vectors, Vectors, float]:
    """Low and high corner of all shapes of a mesh, and the distance of the farthest vertex from the origin."""
    shapes = [deformed(file, how, one) for one in files] or [placed(file, how).vertices]
    low, high = np.min([one.min(axis=0) for one in shapes], axis=0), np.max([one.max(axis=0) for one in shapes], axis=0)
    return low, high, 1.0001 * max(float(np.linalg.norm(one, axis=1).max()) for one in shapes)


@cached(KEPT)
def prepared(key: Key) -> Prepared:
    """The mesh of a key for kernels."""
    mesh, bvh = placed(key.file, key.placing), _bvh(key.file, key.placing)
    if key.moment is not None:
        mesh = mesh.with_vertices(between(key.file, key.placing, key.moment))
        bvh = moved(bvh, mesh.vertices, mesh.triangles)
    order = bvh.triangle
    none = np.zeros((0, 3, 3), np.float32)
    texture, uv, density = None, np.zeros((0, 3, 2), np.float32), np.zeros(0, np.float32)
    if key.coloured and mesh.uv is not None:
        found = mesh.texture if key.texture is None else picture(key.texture)
        if found is not None:
            texture, uv = pyramid(found), np.ascontiguousarray(mesh.uv[order])
            density = _density(mesh, uv, order, found.shape)
    colours = none
    if key.coloured and texture is None and mesh.colours is not None:
        colours = np.ascontiguousarray(mesh.colours[mesh.triangles[order]], np.float32)
    normals = np.ascontiguousarray(shading_normals(mesh, key.crease)[order], np.float32)
    faces = mesh.face_normals().astype(np.float32)
    grid = distances(key.file, key.placing, key.resolution) if key.moment is None else _grid_between(key, key.moment)
    return Prepared(bvh, grid, faces, normals, colours, uv, density, texture)


def corners_at(key: Key) -> Vectors:
    """(T, 3, 3) the corners of triangles in the tree's order, as those of `prepared`."""
    mesh, bvh = placed(key.file, key.placing), _bvh(key.file, key.placing)
    vertices = mesh.vertices if key.moment is None else between(key.file, key.placing, key.moment)
    return vertices[mesh.triangles[bvh.triangle]]


@cached(KEPT)
def _bvh(file: str, how: Placing) -> Bvh:
    mesh = placed(file, how)
    return make_bvh(mesh.vertices, mesh.triangles)


@cached(KEPT)
def distances(file: str, how: Placing, resolution: int) -> DistanceGrid:
    """The grid of distances from the mesh of a file."""
    return distances_of(_bvh(file, how), placed(file, how).closed, resolution)


def distances_of(bvh: Bvh, closed: bool, resolution: int) -> DistanceGrid:
    """The grid of distances from a mesh, as `make_distance_grid`; cached from one run to the next."""
    like: Arrays = {
        FREE + "values": np.empty(0, np.float32), "size": np.empty(3, np.int64), "low": np.empty(3, np.float32),
        "spacing": np.empty(1, np.float32),
    }  # fmt: skip

    def make() -> Iterable[NDArray[Any]]:
        values, low, spacing = make_distance_grid(bvh, closed, resolution)
        return values, np.array(values.shape), low, np.array([spacing])

    of = *bvh, bool(closed), resolution
    values, size, low, spacing = cached_arrays("grid", ("strandcli.meshes.bvh",), of, like, make)
    return DistanceGrid(values.reshape(size), low, spacing[0])


def _grid_between(key: Key, when: Moment) -> DistanceGrid:
    """The grid at a moment: between those of two files, whose nodes are the same."""
    first = _grid_of(key.file, key.placing, key.resolution, key.files, when.before)
    if when.share == 0 or when.after == when.before:
        return first
    second = _grid_of(key.file, key.placing, key.resolution, key.files, when.after)
    share = np.float32(when.share)
    return first._replace(values=first.values + share * (second.values - first.values))


@cached(KEPT)
def _grid_of(file: str, how: Placing, resolution: int, files: tuple[str, ...], one: str) -> DistanceGrid:
    mesh = placed(file, how)
    low, high, _ = _extent(file, how, files)
    bvh = moved(_bvh(file, how), deformed(file, how, one), mesh.triangles)
    return make_distance_grid(bvh, mesh.closed, resolution, box=(low, high))


def _density(
    mesh: TriangleMesh, uv: NDArray[np.float32], order: NDArray[np.int32], shape: tuple[int, ...]
) -> NDArray[np.float32]:
    """(T,) texels a metre on triangles in the tree's order: the root of the texels that they cover by their area."""
    pixels = uv.astype(np.float64) * (shape[1], shape[0])
    a, b = pixels[:, 1] - pixels[:, 0], pixels[:, 2] - pixels[:, 0]
    covered = 0.5 * np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])
    return np.sqrt(covered / mesh.areas()[order]).astype(np.float32)


SAME = 1e-3
"""Sine of the angle within which a file's normal is that of its face; files have some six digits."""
FACETS = 0.99
"""Share of triangles whose normals are those of their faces, from which on a file tells no more than faces do."""


def shading_normals(mesh: TriangleMesh, crease: float) -> Vectors:
    """Unit normals (T, 3, 3) of the corners of triangles: the file's own; where it has none, or those of the faces
    alone, smooth ones, but not across edges where faces meet at ``crease`` degrees or more."""
    own = mesh.corner_normals
    if own is not None:
        off = np.linalg.norm(np.cross(np.broadcast_to(mesh.face_normals()[:, None], own.shape), own), axis=2)
        if (off < SAME).all(axis=1).mean() <= FACETS:
            return own
    return smooth(mesh, crease)


def smooth(mesh: TriangleMesh, crease: float) -> Vectors:
    """Unit normals (T, 3, 3): at each corner the mean of the triangles around the vertex whose faces are turned against
    its own by less than ``crease`` degrees, weighted by their angles there."""
    faces, corners = mesh.face_normals(), mesh.vertices[mesh.triangles]
    if crease >= 180.0:
        return mesh.normals[mesh.triangles]
    weighted = np.empty((len(faces), 3, 3))
    for k in range(3):
        weighted[:, k] = angles(corners, k)[:, None] * faces
    flat = weighted.reshape(-1, 3)
    vertex = mesh.triangles.reshape(-1)
    order = np.argsort(vertex, kind="stable")
    begin = np.searchsorted(vertex[order], np.arange(len(mesh.vertices) + 1))
    around = np.diff(begin)[vertex]
    place = np.empty(len(order), np.int64)
    place[order] = np.arange(len(order)) - begin[vertex[order]]
    least = math.cos(math.radians(crease))
    found = flat.copy()
    for step in range(1, int(around.max())):  # each corner together with the next, the one after that and so on
        mine = np.flatnonzero(around > step)
        other = order[begin[vertex[mine]] + (place[mine] + step) % around[mine]]
        near = np.einsum("ij,ij->i", faces[mine // 3], faces[other // 3]) > least
        found[mine[near]] += flat[other[near]]
    made: Vectors = unit(found).reshape(-1, 3, 3)
    return made


def data(solids: Sequence[Any], time: float, past: float | None = None) -> Data:
    """The data of solids by their settings at a time; the same until their shapes change. ``past``: the time since
    when surfaces drift."""
    keys = tuple(key_of(one, time) for one in solids)
    if past is None or not any(one.deform for one in solids):
        return _together(keys)
    return _together(keys, tuple(key_of(one, past) if one.deform else None for one in solids))


@cached(KEPT)
def _together(keys: tuple[Key, ...], past: tuple[Key | None, ...] = ()) -> Data:
    made = {key: columns(prepared(key)) for key in dict.fromkeys(keys)}
    rows = np.array([made[key][0] for key in keys], np.int64).reshape(len(keys), at.SIZE)
    before = [None if key is None or key == keys[k] else corners_at(key) for k, key in enumerate(past)]
    for row, corners in zip(rows, before, strict=False):
        row[at.PAST] = 0 if corners is None else corners.ctypes.data
    return Data(that_keeps(rows, [before, *(columns for _, columns in made.values())]))


def triangles(numbers: NDArray[Any], data: Data) -> NDArray[np.float64]:
    """(T, 3, 3) the corners of the mesh of a solid that has these numbers."""
    row = data.table[int(numbers[0])]
    count = int(row[at.TRIANGLES])
    memory: Any = (ctypes.c_double * (9 * count)).from_address(int(row[at.CORNERS]))
    memory.keeps = data.table
    return np.frombuffer(memory, np.float64).reshape(count, 3, 3)


def columns(mesh: Prepared) -> tuple[list[int], list[NDArray[Any]]]:
    """A mesh's row of the table, and the arrays that it tells of."""
    grid, tree, picture = mesh.grid, mesh.bvh, mesh.texture
    arrays: dict[int, NDArray[Any]] = {
        at.LOW: np.array([*grid.low, grid.spacing], np.float32), at.VALUES: grid.values,
        at.BOXES: tree.boxes, at.CHILD: tree.child, at.COUNTS: tree.counts, at.CORNERS: tree.corners,
        at.TRIANGLE: tree.triangle, at.FACES: mesh.faces, at.NORMALS: mesh.normals, at.COLOURS: mesh.colours,
        at.UV: mesh.uv, at.DENSITY: mesh.density, at.LINEAR: LINEAR,
    }  # fmt: skip
    row = [0] * at.SIZE
    row[at.NZ : at.NX + 1] = grid.values.shape
    row[at.NODES], row[at.TRIANGLES] = len(tree.boxes), len(tree.corners)
    if picture is not None:
        arrays |= {at.TEXELS: picture.texels, at.LEVELS: picture.levels}
        row[at.TEXEL_COUNT], row[at.LEVEL_COUNT] = len(picture.texels), len(picture.levels)
    columns = {column: np.ascontiguousarray(one) for column, one in arrays.items() if one.size}
    for column, one in columns.items():
        row[column] = one.ctypes.data
    return row, list(columns.values())


def that_keeps(table: NDArray[np.int64], arrays: Any) -> NDArray[np.int64]:
    """A copy of a table of addresses. The arrays stay for as long as it does, or any view of it."""
    memory: Any = (ctypes.c_int64 * table.size)()
    memory.keeps = arrays
    copy = np.frombuffer(memory, np.int64).reshape(table.shape)
    copy[:] = table
    return copy
