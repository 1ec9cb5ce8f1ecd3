"""The arrays of all meshes of a scene: one after the other, with a table of where each begins."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .kernels import arrays as at
from .kernels.arrays import Data
from .prepared import Key, Prepared, key_of, prepared
from .read import KEPT
from .texture import LINEAR


def data(solids: Sequence[Any], time: float) -> Data:
    """The data of solids by their settings at a time; the same arrays until their shapes change."""
    return _together(tuple(key_of(one, time) for one in solids))


@functools.lru_cache(maxsize=KEPT)
def _together(keys: tuple[Key, ...]) -> Data:
    distinct = list(dict.fromkeys(keys))
    meshes = [prepared(key) for key in distinct]
    rows = table(meshes)
    whole = np.array([rows[distinct.index(key)] for key in keys], np.int64).reshape(len(keys), at.SIZE)
    low = np.array([[*meshes[distinct.index(key)].grid.low, meshes[distinct.index(key)].grid.spacing] for key in keys])
    trees = [one.bvh for one in meshes]
    pictures = [one.texture for one in meshes if one.texture is not None]
    return Data(
        whole, low.astype(np.float32).reshape(-1, 4),
        _joined([one.boxes for one in trees]), _joined([one.child for one in trees]),
        _joined([one.counts for one in trees]), _joined([one.corners for one in trees]),
        _joined([one.triangle for one in trees]),
        _joined([one.faces for one in meshes]),
        _joined([one.normals for one in meshes]), _joined([one.colours for one in meshes]),
        _joined([one.uv for one in meshes]), _joined([one.density for one in meshes]),
        _joined([np.zeros((0, 3), np.uint8), *(one.texels for one in pictures)]),
        _joined([np.zeros((0, 3), np.int64), *(one.levels for one in pictures)]),
        LINEAR, _joined([one.grid.values.reshape(-1) for one in meshes]),
    )  # fmt: skip


def triangles(numbers: NDArray[Any], data: Data) -> NDArray[np.float64]:
    """(T, 3, 3) the corners of the mesh of a solid that has these numbers."""
    row = data.table[int(numbers[0])]
    return data.corners[row[at.TRIANGLES] : row[at.TRIANGLES_END]]


def table(meshes: Sequence[Prepared]) -> NDArray[np.int64]:
    """(meshes, `arrays.SIZE`) where the parts of each begin and end, when they stand one after the other."""
    out = np.zeros((len(meshes), at.SIZE), np.int64)
    begin = np.zeros(7, np.int64)
    for row, one in zip(out, meshes, strict=True):
        texels, levels = (len(one.texture.texels), len(one.texture.levels)) if one.texture else (0, 0)
        count = (
            len(one.bvh.boxes), len(one.bvh.corners), one.grid.values.size, len(one.colours), len(one.uv), texels,
            levels,
        )  # fmt: skip
        row[at.NODES : at.NODES + 14 : 2] = begin
        begin = begin + count
        row[at.NODES + 1 : at.NODES + 15 : 2] = begin
        row[at.NZ : at.NX + 1] = one.grid.values.shape
    return out


def _joined(parts: Sequence[NDArray[Any]]) -> NDArray[Any]:
    """Arrays one after the other; not copied where only one has rows."""
    filled = [one for one in parts if len(one)]
    return np.ascontiguousarray(filled[0] if len(filled) == 1 else np.concatenate(filled or list(parts)))
