"""Points, normals and widths where a transform puts them."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from .strands import CHUNK, WIDTHS, Attribute

Matrix = npt.NDArray[np.float64]
"""(4, 4), of rows: a point (x, y, z, 1) is multiplied from the left."""


def moved(points: npt.NDArray[np.float32], matrix: Matrix | None) -> npt.NDArray[np.float32]:
    """Points (P, 3) where a transform puts them."""
    if matrix is None:
        return points
    found = np.empty_like(points)
    with np.errstate(over="ignore", invalid="ignore"):
        for begin in range(0, points.shape[0], CHUNK):
            found[begin : begin + CHUNK] = points[begin : begin + CHUNK] @ matrix[:3, :3] + matrix[3, :3]
    return found


def turned(normals: npt.NDArray[np.float32], matrix: Matrix) -> npt.NDArray[np.float32]:
    """Normals (P, 3) as a transform turns them, as long as they were."""
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        cofactors = np.cross(matrix[[1, 2, 0], :3], matrix[[2, 0, 1], :3])
        found = normals @ cofactors * np.sign(np.linalg.det(matrix[:3, :3]))  # the inverse transposed, but for length
        long, now = np.linalg.norm(normals, axis=1, keepdims=True), np.linalg.norm(found, axis=1, keepdims=True)
        return np.asarray(np.where(now > 0, found * (long / now), normals).astype(np.float32))


def moved_attribute(name: str, one: Attribute, matrix: Matrix) -> Attribute:
    """An attribute as a transform leaves it: widths are scaled, normals turned."""
    if name in WIDTHS and one.values.dtype == np.float32:
        with np.errstate(over="ignore", invalid="ignore"):
            scale = abs(float(np.linalg.det(matrix[:3, :3]))) ** (1 / 3)
            return Attribute(one.domain, (one.values * scale).astype(np.float32))
    if name == "normal" and one.values.shape[1:] == (3,) and one.values.dtype == np.float32:
        return Attribute(one.domain, turned(one.values, matrix))
    return one
