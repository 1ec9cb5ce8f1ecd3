"""A placed mesh with what rays, contact and shading need of it, made once for each file and settings."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..inputs import cached
from ..meshes.bvh import Bvh, moved
from ..meshes.distance_grid import DistanceGrid, make_distance_grid
from ..meshes.mesh import TriangleMesh, Vectors
from . import long
from .normals import shading_normals
from .read import KEPT, Moment, Placing, deformed, moment, placed, placing
from .texture import Pyramid, picture, pyramid

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
        mesh = mesh.with_vertices(_vertices_at(key, mesh))
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
    return _vertices_at(key, mesh)[mesh.triangles[bvh.triangle]]


def _vertices_at(key: Key, mesh: TriangleMesh) -> Vectors:
    """The vertices of a placed mesh at the moment of a key."""
    if key.moment is None:
        return mesh.vertices
    first, second = (deformed(key.file, key.placing, one) for one in key.moment[:2])
    found: Vectors = first + key.moment.share * (second - first)
    return found


@cached(KEPT)
def _bvh(file: str, how: Placing) -> Bvh:
    return long.tree_of(placed(file, how))


@cached(KEPT)
def distances(file: str, how: Placing, resolution: int) -> DistanceGrid:
    """The grid of distances from the mesh of a file."""
    return long.distances_of(_bvh(file, how), placed(file, how).closed, resolution)


def _grid_between(key: Key, at: Moment) -> DistanceGrid:
    """The grid at a moment: between those of two files, whose nodes are the same."""
    first = _grid_of(key.file, key.placing, key.resolution, key.files, at.before)
    if at.share == 0 or at.after == at.before:
        return first
    second = _grid_of(key.file, key.placing, key.resolution, key.files, at.after)
    share = np.float32(at.share)
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
