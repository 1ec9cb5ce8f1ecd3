"""NeuS's cameras.npz, which is written and not read (Totoro97/NeuS, models/dataset.py; SamsungLabs/NeuralHaircut,
src/models/dataset.py).

`world_mat_0` …: (4, 4) from the world to pixels, whose middles are whole numbers; `scale_mat_0` …: (4, 4) from the unit
ball that the scene is put into to the world. NeuralHaircut's own sets have all of the former as one array, `arr_0`.
"""

from __future__ import annotations

import io
from collections.abc import Sequence
from typing import Any

import numpy as np

from .pinhole import HALF, Floats, Pinhole

WORLD, SCALE, ALL = "world_mat_", "scale_mat_", "arr_0"
SIZE, MARK = "image_size", "strandcli"
"""Arrays that strandcli adds: width and height, and the sign that it wrote the file."""


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
