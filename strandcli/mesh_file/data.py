"""The data of all meshes of a scene: where the arrays of each begin, as kernels take them."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..files.inputs import cached
from .kernels import arrays as at
from .kernels.arrays import Data
from .maps import LINEAR
from .prepared import Key, Prepared, corners_at, key_of, prepared
from .read import KEPT


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
    return Data(that_keeps(rows, [before, *(held for _, held in made.values())]))


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
    held = {column: np.ascontiguousarray(one) for column, one in arrays.items() if one.size}
    for column, one in held.items():
        row[column] = one.ctypes.data
    return row, list(held.values())


def that_keeps(table: NDArray[np.int64], arrays: Any) -> NDArray[np.int64]:
    """A copy of a table of addresses. The arrays stay for as long as it does, or any view of it."""
    memory: Any = (ctypes.c_int64 * table.size)()
    memory.keeps = arrays
    kept = np.frombuffer(memory, np.int64).reshape(table.shape)
    kept[:] = table
    return kept
