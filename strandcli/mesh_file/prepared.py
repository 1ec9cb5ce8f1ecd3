"""A placed mesh with what rays, contact and shading need of it, made once for each file and settings."""

from __future__ import annotations

import functools
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..meshes.bvh import Bvh, make_bvh
from ..meshes.distance_grid import DistanceGrid, make_distance_grid
from ..meshes.mesh import TriangleMesh
from .normals import shading_normals
from .read import KEPT, Placing, Version, placed, placing, version
from .texture import Pyramid, picture, pyramid

GREY = (0.18, 0.18, 0.18)
"""The default of a solid's `colour`."""


class Key(NamedTuple):
    """All that a prepared mesh follows from."""

    file: Version
    placing: Placing
    resolution: int
    coloured: bool
    """Whether colours of the file are drawn."""
    texture: Version | None
    crease: float
    """Degrees."""


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


def key_of(settings: Any) -> Key:
    """The key of a solid's settings as its files are now."""
    coloured = settings.colour_from == "file" or (
        settings.colour_from == "auto" and (tuple(settings.colour) == GREY or bool(settings.texture))
    )
    texture = version(settings.texture) if settings.texture else None
    return Key(version(settings.file), placing(settings), settings.resolution, coloured, texture, settings.crease)


def mesh_of(settings: Any) -> TriangleMesh:
    """The placed mesh of a solid's settings."""
    return placed(version(settings.file), placing(settings))


def reach_of(settings: Any) -> float:
    """Distance of the farthest vertex from the origin of the solid's frame, metres."""
    return _reach(version(settings.file), placing(settings))


@functools.lru_cache(maxsize=KEPT)
def _reach(file: Version, how: Placing) -> float:
    return 1.0001 * float(np.linalg.norm(placed(file, how).vertices, axis=1).max())


@functools.lru_cache(maxsize=KEPT)
def prepared(key: Key) -> Prepared:
    """The mesh of a key for kernels."""
    mesh = placed(key.file, key.placing)
    bvh = _bvh(key.file, key.placing)
    order = bvh.triangle
    none = np.zeros((0, 3, 3), np.float32)
    texture, uv, density = None, np.zeros((0, 3, 2), np.float32), np.zeros(0, np.float32)
    if key.coloured and mesh.uv is not None:
        found = mesh.texture if key.texture is None else picture(key.texture.path)
        if found is not None:
            texture, uv = pyramid(found), np.ascontiguousarray(mesh.uv[order])
            density = _density(mesh, uv, order, found.shape)
    colours = none
    if key.coloured and texture is None and mesh.colours is not None:
        colours = np.ascontiguousarray(mesh.colours[mesh.triangles[order]], np.float32)
    normals = np.ascontiguousarray(shading_normals(mesh, key.crease)[order], np.float32)
    faces = mesh.face_normals().astype(np.float32)
    grid = _grid(key.file, key.placing, key.resolution)
    return Prepared(bvh, grid, faces, normals, colours, uv, density, texture)


@functools.lru_cache(maxsize=KEPT)
def _bvh(file: Version, how: Placing) -> Bvh:
    mesh = placed(file, how)
    return make_bvh(mesh.vertices, mesh.triangles)


@functools.lru_cache(maxsize=KEPT)
def _grid(file: Version, how: Placing, resolution: int) -> DistanceGrid:
    return make_distance_grid(_bvh(file, how), placed(file, how).closed, resolution)


def _density(
    mesh: TriangleMesh, uv: NDArray[np.float32], order: NDArray[np.int32], shape: tuple[int, ...]
) -> NDArray[np.float32]:
    """(T,) texels a metre on triangles in the tree's order: the root of the texels that they cover by their area."""
    pixels = uv.astype(np.float64) * (shape[1], shape[0])
    a, b = pixels[:, 1] - pixels[:, 0], pixels[:, 2] - pixels[:, 0]
    covered = 0.5 * np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])
    return np.sqrt(covered / mesh.areas()[order]).astype(np.float32)
