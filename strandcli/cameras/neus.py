"""NeuS's cameras.npz (Totoro97/NeuS, models/dataset.py; SamsungLabs/NeuralHaircut, src/models/dataset.py).

`world_mat_0` …: (4, 4) from the world to pixels, whose middles are whole numbers; `scale_mat_0` …: (4, 4) from the unit
ball that the scene is put into to the world. NeuralHaircut's own sets have all of the former as one array, `arr_0`.
"""

from __future__ import annotations

import io
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import UsageError
from ..exchange.archive import arrays_of
from ..exchange.bounded import opened
from .pinhole import HALF, Floats, Pinhole, checked_rotation, picture_size, square_focal

WORLD, SCALE, ALL = "world_mat_", "scale_mat_", "arr_0"
SIZE, MARK = "image_size", "strandcli"
"""Arrays that strandcli adds: width and height, and the sign that it wrote the file."""
SKEW = 1e-3
"""Pixels a pixel by which rows may be sheared."""


def read(path: Path, size: tuple[int, int] | None, notes: list[str]) -> tuple[list[Pinhole], bool]:
    """The views in order, and whether strandcli wrote them. Raises `UsageError` for a file that is damaged."""
    with opened(path, ".npz file") as file, arrays_of(file) as archive:
        arrays = {name: archive.read(member, double=True) for name, member in archive.members.items()}
    own = MARK in arrays
    if SIZE in arrays and arrays[SIZE].shape == (2,):
        width, height = (float(one) for one in arrays[SIZE])
        size = picture_size(width, height, size, path)
    shape = picture_size(None, None, size, path)
    if ALL in arrays:
        matrices = list(arrays[ALL])
    else:
        count = sum(name.startswith(WORLD) and name[len(WORLD) :].isdigit() for name in arrays)
        missing = [number for number in range(count) if f"{WORLD}{number}" not in arrays]
        if missing or not count:
            raise UsageError(f"{path}: has no array {WORLD}{missing[0] if missing else 0}")
        matrices = [arrays[f"{WORLD}{number}"] for number in range(count)]
    views = []
    for number, matrix in enumerate(matrices):
        where = f"{path}: view {number}"
        try:
            with np.errstate(all="ignore"):  # what is not finite is refused
                view = _view(np.asarray(matrix, np.float64), f"{number:04d}", shape, where, notes)
        except (ValueError, np.linalg.LinAlgError) as error:
            raise UsageError(f"{where}: {error}") from None
        views.append(view)
    if not views:
        raise UsageError(f"{path}: has no view")
    return views, own


def _view(matrix: Floats, name: str, size: tuple[int, int], where: str, notes: list[str]) -> Pinhole:
    """The view of a projection matrix (3 or 4, 4): K [R | t]."""
    if matrix.shape not in ((3, 4), (4, 4)) or not np.isfinite(matrix).all():
        raise ValueError("is no projection matrix (4, 4)")
    projection = matrix[:3]
    # RQ by QR of the matrix turned upside down: K has a positive diagonal
    flip = np.eye(3)[::-1]
    q, r = np.linalg.qr((flip @ projection[:, :3]).T)
    k, rotation = flip @ r.T @ flip, flip @ q.T
    signs = np.where(np.diag(k) < 0, -1.0, 1.0)
    k, rotation = k * signs, signs[:, None] * rotation
    if not (np.abs(np.diag(k)) > 0).all():
        raise ValueError("is no projection matrix: it has no inverse")
    if np.linalg.det(rotation) < 0:
        rotation = -rotation  # the sign of a projection matrix says nothing
    eye = -np.linalg.solve(projection[:, :3], projection[:, 3])
    k = k / k[2, 2]
    if abs(k[0, 1]) > SKEW * k[0, 0]:
        raise ValueError("its pixels are sheared, which strandcli does not draw")
    focal = square_focal(float(k[0, 0]), float(k[1, 1]), size, where, notes)
    centre = (float(k[0, 2]) + HALF, float(k[1, 2]) + HALF)
    return Pinhole(name, *size, focal, centre, checked_rotation(rotation), np.asarray(eye))


def world_matrix(view: Pinhole) -> Floats:
    """(4, 4) from the world to pixels that are counted from the middle of the first one."""
    k = np.eye(4)
    k[0, 0] = k[1, 1] = view.focal
    k[:2, 2] = view.centre[0] - HALF, view.centre[1] - HALF
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = view.rotation, -view.rotation @ view.eye
    return k @ pose


def written(views: Sequence[Pinhole], middle: Floats, radius: float) -> bytes:
    """The file, of perspective views of one size, and the ball, metres, that becomes the unit ball."""
    scale = np.diag([radius, radius, radius, 1.0])
    scale[:3, 3] = middle
    matrices = [world_matrix(view) for view in views]
    arrays: dict[str, Any] = {ALL: np.stack(matrices), MARK: np.array(1)}
    for number, matrix in enumerate(matrices):
        arrays |= {f"{WORLD}{number}": matrix, f"{SCALE}{number}": scale}
    arrays[SIZE] = np.array([views[0].width, views[0].height])
    file = io.BytesIO()
    np.savez(file, **arrays)
    return file.getvalue()
