"""nerfstudio's transforms.json (nerfstudio-project/nerfstudio, docs/quickstart/data_conventions.md), and NeuS's
cameras.npz.

`transform_matrix` takes a camera, whose axes are right, up and backward (OpenGL), to the world, whose z is up. The
corner of the picture is (0, 0). Lenses stand at the top of the file or with each picture.
"""

from __future__ import annotations

import io
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..common.rotations import turning
from ..errors import UsageError, one_line
from ..files.inputs import content
from ..output.files import json_of
from .pinhole import HALF, Floats, Pinhole, checked_rotation, in_order, picture_size, refuse_distortion, square_focal

MARK = "strandcli"
"""Key of files that strandcli wrote."""
FLIP = np.diag([1.0, -1.0, -1.0])
"""From right, down, forward to right, up, backward, and back."""
MODELS = ("OPENCV", "PINHOLE", "SIMPLE_PINHOLE", "PERSPECTIVE")
"""Values of camera_model that are pinholes where their distortion is 0."""
BENDING = ("k1", "k2", "k3", "k4", "k5", "k6", "p1", "p2")
UP = "z"
"""Of nerfstudio's world; scenes have y."""


def read(path: Path, size: tuple[int, int] | None, notes: list[str]) -> tuple[list[Pinhole], bool]:
    """The views by the names of their pictures, and whether strandcli wrote them. Raises `UsageError` for a file that
    is damaged and for lenses that are no pinholes. The world of files that strandcli wrote is turned back to y up."""
    try:
        data = json_of(content(path))
    except ValueError as error:
        raise UsageError(f"{path}: is no JSON: {error}") from None
    frames = data.get("frames") if isinstance(data, dict) else None
    if not isinstance(frames, list) or not frames:
        raise UsageError(f"{path}: frames: has no view")
    own = MARK in data
    views = []
    for number, frame in enumerate(frames):
        if not isinstance(frame, dict):
            raise UsageError(f"{path}: frames[{number}]: is no view")
        view = _view({**data, **frame}, number, path, size, notes)
        views.append(view.moved(turning(UP, "y"), np.zeros(3)) if own else view)
    return in_order(views), own


def _view(data: Mapping[str, Any], number: int, path: Path, size: tuple[int, int] | None, notes: list[str]) -> Pinhole:
    """The view of an entry, with what stands at the top of the file."""
    where = f"frames[{number}]"
    model = data.get("camera_model", "OPENCV")
    if model not in MODELS:
        raise UsageError(f"{path}: {where}: camera_model {model!r:.40} is no pinhole; undistort the pictures first")
    try:
        refuse_distortion(path, where, {name: float(data.get(name, 0)) for name in BENDING})
        shape = picture_size(_or_none(data, "w"), _or_none(data, "h"), size, path)
        focal = _focal(data, shape, f"{path}: {where}", notes)
        centre = (float(data.get("cx", shape[0] / 2)), float(data.get("cy", shape[1] / 2)))
        matrix = _matrix(data["transform_matrix"])
        rotation = FLIP @ checked_rotation(matrix[:3, :3]).T
        name = Path(str(data.get("file_path", f"{number:04d}"))).stem
        return Pinhole(name, *shape, focal, centre, rotation, matrix[:3, 3])
    except KeyError as error:
        raise UsageError(f"{path}: {where}: has no {error.args[0]}") from None
    except (TypeError, ValueError, OverflowError) as error:
        raise UsageError(f"{path}: {where}: {one_line(str(error))}") from None


def _or_none(data: Mapping[str, Any], key: str) -> float | None:
    return None if data.get(key) is None else float(data[key])


def _focal(data: Mapping[str, Any], size: tuple[int, int], where: str, notes: list[str]) -> float:
    """The focal length, pixels: as it stands there, or from the angle of view that NeRF's own sets have."""
    if "fl_x" in data or "fl_y" in data:
        fx, fy = (float(data.get(name, data.get(other, 0))) for name, other in (("fl_x", "fl_y"), ("fl_y", "fl_x")))
        return square_focal(fx, fy, size, where, notes)
    if "camera_angle_x" not in data:
        raise KeyError("fl_x")
    angle = float(data["camera_angle_x"])
    if not 0 < angle < math.pi:
        raise ValueError(f"camera_angle_x {angle:g} is no angle of view: radians, above 0 and under pi")
    focal = size[0] / 2 / math.tan(angle / 2)
    return square_focal(focal, focal, size, where, notes)


def _matrix(rows: Any) -> Floats:
    """A matrix (3, 4) or (4, 4) of finite numbers. Raises `ValueError` for anything else."""
    try:
        matrix = np.array(rows, np.float64)
    except (TypeError, ValueError, OverflowError):  # rows of several lengths, words: NumPy tells of its insides
        matrix = np.empty(0)
    if matrix.shape not in ((3, 4), (4, 4)) or not np.isfinite(matrix).all():
        raise ValueError("transform_matrix: is no matrix (4, 4) of finite numbers")
    return matrix


def matrix_of(view: Pinhole) -> Floats:
    """(4, 4) camera to world as this format has it, of a view in a world whose y is up."""
    turned = view.moved(turning("y", UP), np.zeros(3))
    out = np.eye(4)
    out[:3, :3], out[:3, 3] = turned.rotation.T @ FLIP, turned.eye
    return out


def written(views: Sequence[Pinhole], beside: Mapping[str, str], version: str) -> dict[str, Any]:
    """The file's data, of perspective views; ``beside``: keys of files of each view, with ``{}`` for its name."""
    frames = [
        {
            **{key: pattern.format(view.name) for key, pattern in beside.items()},
            "fl_x": view.focal, "fl_y": view.focal, "cx": view.centre[0], "cy": view.centre[1],
            "w": view.width, "h": view.height,
            "transform_matrix": matrix_of(view).tolist(),
        }
        for view in views
    ]  # fmt: skip
    return {"camera_model": "OPENCV", MARK: version, "frames": frames}


WORLD, SCALE, ALL = "world_mat_", "scale_mat_", "arr_0"
SIZE = "image_size"
"""Array that strandcli adds beside its `MARK`: width and height."""


def world_matrix(view: Pinhole) -> Floats:
    """(4, 4) from the world to pixels that are counted from the middle of the first one."""
    k = np.eye(4)
    k[0, 0] = k[1, 1] = view.focal
    k[:2, 2] = view.centre[0] - HALF, view.centre[1] - HALF
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = view.rotation, -view.rotation @ view.eye
    return k @ pose


def neus_written(views: Sequence[Pinhole], middle: Floats, radius: float) -> bytes:
    """NeuS's cameras.npz (Totoro97/NeuS, models/dataset.py; SamsungLabs/NeuralHaircut, src/models/dataset.py), of
    perspective views of one size, and the ball, metres, that becomes the unit ball.

    `world_mat_0` …: (4, 4) from the world to pixels, whose middles are whole numbers; `scale_mat_0` …: (4, 4) from the
    unit ball to the world. NeuralHaircut's own sets have all of the former as one array, `arr_0`.
    """
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
