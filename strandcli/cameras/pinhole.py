"""A view as other programs have it: where a camera stands, how it is turned, and its projection in pixels; lenses
of camera files as that has them, with square pixels and no distortion; and which axis is up in the world of views.

Points of a picture are measured in pixels from its upper left corner, x to the right and y down, so that the middle of
the first pixel is (0.5, 0.5), as in COLMAP, in nerfstudio and in `strandcli.draw.view.camera`. OpenCV and NeuS count
from the middle of the first pixel: there every principal point is less by a half.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..common.rotations import xyz
from ..errors import UsageError

if TYPE_CHECKING:
    from ..scene.model import Camera

Floats = NDArray[np.float64]
HALF = 0.5
"""Pixels from the middle of the first pixel to the corner of the picture."""
DIGITS = 100
"""Of a number in a name, at most."""
LARGEST = 1 << 20
"""Pixels of a picture's side, at most."""
SKEWED = 1e-3
"""Departure from a rotation, in any entry, from which on a matrix is none."""


@dataclass(frozen=True, eq=False)
class Pinhole:
    """A view without lens distortion, of square pixels."""

    name: str
    width: int
    height: int
    focal: float
    """Pixels; of an orthographic view pixels a metre."""
    centre: tuple[float, float]
    """Principal point, pixels from the upper left corner."""
    rotation: Floats
    """(3, 3) world to camera; rows are the camera's right, down and forward axes, as in OpenCV."""
    eye: Floats
    """(3,) metres."""
    perspective: bool = True
    near: float | None = None
    """Metres; of the near plane, where it is known."""

    @property
    def sound(self) -> bool:
        """Whether it may be drawn: all numbers are finite, and size, focal length and near plane above 0."""
        if not (0 < self.width <= LARGEST and 0 < self.height <= LARGEST):
            return False
        lengths = (self.focal, 1.0 if self.near is None else self.near)
        return min(lengths) > 0 and bool(np.isfinite([*lengths, *self.centre, *self.eye]).all())

    def camera_points(self, points: ArrayLike) -> Floats:
        """(k, 3) points of the world along the camera's right, down and forward axes, metres."""
        return np.asarray((np.asarray(points, np.float64) - self.eye) @ self.rotation.T)

    def project(self, points: ArrayLike) -> Floats:
        """(k, 2) pixels that points (k, 3) of the world are seen at."""
        here = self.camera_points(points)
        flat = here[:, :2] / here[:, 2:] if self.perspective else here[:, :2]
        return np.asarray(self.focal * flat + np.array(self.centre))

    def moved(self, turn: Floats, shift: Floats, factor: float = 1.0) -> Pinhole:
        """The same view of a world whose points p are at factor · turn · p + shift."""
        focal = self.focal if self.perspective else self.focal / factor
        near = None if self.near is None else factor * self.near
        eye = factor * turn @ self.eye + shift
        return replace(self, rotation=self.rotation @ turn.T, eye=eye, focal=focal, near=near)

    @property
    def matrix(self) -> Floats:
        """(4, 4) camera to world, with the camera's axes right, down and forward (OpenCV)."""
        out = np.eye(4)
        out[:3, :3], out[:3, 3] = self.rotation.T, self.eye
        return out

    def as_dict(self) -> dict[str, Any]:
        """The same for JSON, which keeps every bit."""
        return {
            "name": self.name,
            "kind": "perspective" if self.perspective else "orthographic",
            "width": self.width,
            "height": self.height,
            "focal": self.focal,
            "centre": list(self.centre),
            "rotation": self.rotation.tolist(),
            "eye": self.eye.tolist(),
            **({} if self.near is None else {"near": self.near}),
        }


def from_dict(data: Mapping[str, Any]) -> Pinhole:
    """A view from what `Pinhole.as_dict` made of it. Raises `KeyError`, `TypeError` or `ValueError` for anything
    else."""
    x, y = (float(number) for number in data["centre"])
    rotation = np.array(data["rotation"], np.float64).reshape(3, 3)
    return Pinhole(
        str(data["name"]), int(data["width"]), int(data["height"]), float(data["focal"]), (x, y),
        checked_rotation(rotation), np.array(data["eye"], np.float64).reshape(3), data["kind"] == "perspective",
        float(data["near"]) if "near" in data else None,
    )  # fmt: skip


def in_order(views: Iterable[Pinhole]) -> list[Pinhole]:
    """Views by their names, in which numbers count as such: 9 comes before 10."""

    def key(view: Pinhole) -> list[tuple[int, str]]:
        parts = re.split(r"(\d+)", view.name)
        return [(int(part), "") if part.isdecimal() and len(part) <= DIGITS else (-1, part) for part in parts]

    return sorted(views, key=key)


def checked_rotation(matrix: Floats) -> Floats:
    """A matrix (3, 3) that is a rotation but for rounding. Raises `ValueError` for any other."""
    if not np.isfinite(matrix).all() or np.abs(matrix @ matrix.T - np.eye(3)).max() > SKEWED:
        raise ValueError("is no rotation")
    if np.linalg.det(matrix) < 0:
        raise ValueError("mirrors")
    return matrix


def of_camera(camera: Camera, name: str, width: int, height: int) -> Pinhole:
    """A scene's camera that has no keys, for a picture of so many pixels."""
    eye = np.array(camera.position, np.float64)
    forward = np.array(camera.target, np.float64) - eye
    forward /= np.linalg.norm(forward)
    right = np.cross(forward, np.array(camera.up, np.float64))
    right /= np.linalg.norm(right)
    perspective = camera.kind == "perspective"
    focal = height / 2 / math.tan(math.radians(camera.fov) / 2) if perspective else height / camera.height
    centre = (camera.axis_x * width, camera.axis_y * height)
    rotation = np.stack([right, np.cross(forward, right), forward])
    return Pinhole(name, width, height, focal, centre, rotation, eye, perspective)


def to_camera(view: Pinhole, near: float) -> Camera:
    """A scene's camera of this view, with its near plane or ``near``, that looks at a point a metre ahead."""
    from ..scene.model import Camera

    axis_x, axis_y = view.centre[0] / view.width, view.centre[1] / view.height
    fov = math.degrees(2 * math.atan2(view.height / 2, view.focal)) if view.perspective else Camera().fov
    return Camera(
        kind="perspective" if view.perspective else "orthographic",
        position=xyz(view.eye),
        target=xyz(view.eye + view.rotation[2]),
        up=xyz(-view.rotation[1]),
        fov=fov,
        height=Camera().height if view.perspective else view.height / view.focal,
        axis_x=axis_x,
        axis_y=axis_y,
        near=view.near or near,
    )


UP = (0.0, 1.0, 0.0)
LEAST = 0.3
"""Length of the mean of the cameras' up axes below which they agree on no direction."""
NEAR = 0.77
"""Cosine of the angle to an axis from which on that axis is taken: 40°, as far as cameras look up or down."""


def above(views: Sequence[Pinhole]) -> tuple[float, float, float]:
    """The unit vector that is up in the pictures of views, on average: the axis of the world near to it, or itself
    where none is; y where views do not agree, or there are none."""
    if not views:
        return UP
    mean = -np.mean([view.rotation[1] for view in views], axis=0)
    size = float(np.linalg.norm(mean))
    if size < LEAST:
        return UP
    mean /= size
    most = int(np.argmax(np.abs(mean)))
    if abs(mean[most]) < NEAR:
        return xyz(mean)
    return xyz(np.sign(mean) * (np.arange(3) == most))


def upright(up: tuple[float, float, float]) -> Floats:
    """The turn (3, 3) that takes y to a unit vector, by the lesser angle; half a turn is about x."""
    across, cosine = np.cross(np.array(UP), np.array(up)), float(np.dot(UP, up))
    if cosine < -1 + 1e-12:
        return np.diag([1.0, -1.0, -1.0])
    x, y, z = across
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.asarray(np.eye(3) + cross + cross @ cross / (1 + cosine))


@dataclass(frozen=True)
class Views:
    """What a file of cameras holds."""

    views: Sequence[Pinhole]
    own: bool
    """Whether strandcli wrote it: its world is a scene's, in metres. Else it is that of the file of strands."""
    notes: tuple[str, ...] = ()
    """What a person should know, a line each."""
    unit: float = 1.0
    """Metres of a unit of the file's own coordinates, which are those of the file of strands; views are in metres."""
    up: str = "y"
    """Up axis of these; that of views is y."""
    above: tuple[float, float, float] = UP
    """What is up in the world of the views, as far as they tell."""


SEEN = 0.01
"""Pixels at the picture's rim under which two focal lengths are one."""


class MissingSize(UsageError):
    """A file of cameras does not tell the size of its pictures, and no other file does."""


def square_focal(fx: float, fy: float, size: tuple[int, int], where: str, notes: list[str]) -> float:
    """The focal length, pixels, of a camera that has one for each axis. What the mean of two leaves at the rim of the
    picture is noted. Raises `UsageError` where either is no length."""
    if not (math.isfinite(fx) and math.isfinite(fy) and fx > 0 and fy > 0):
        raise UsageError(f"{where}: focal lengths {fx:g} and {fy:g}: both must be above 0")
    if fx == fy:
        return fx
    focal = 0.5 * (fx + fy)
    off = max(abs(fx - focal) / focal * size[0] / 2, abs(fy - focal) / focal * size[1] / 2)
    if off > SEEN:
        notes.append(f"{where}: focal lengths {fx:g} and {fy:g} are drawn as {focal:g}, {off:.2g} px off at the rim")
    return focal


def refuse_distortion(path: Path, where: str, numbers: dict[str, float]) -> None:
    """Raise `UsageError` where any of a lens's numbers, by name, is not 0."""
    bent = [f"{name} {value:g}" for name, value in numbers.items() if value != 0]
    if bent:
        raise UsageError(
            f"{path}: {where}: has lens distortion ({', '.join(bent)}), which strandcli does not draw; undistort the "
            "pictures and their cameras first (colmap image_undistorter)"
        )


def picture_size(
    width: float | None, height: float | None, given: tuple[int, int] | None, path: Path
) -> tuple[int, int]:
    """Width and height in pixels, of the file or as ``given``. Raises `UsageError` where there is neither or where they
    differ."""
    if width is None or height is None:
        if given is None:
            raise MissingSize(f"{path}: has no size of its pictures; add --size WxH")
        return given
    finite = math.isfinite(width) and math.isfinite(height)
    own = (int(width), int(height)) if finite else (0, 0)
    if own != (width, height) or min(own) < 1:
        raise UsageError(f"{path}: pictures of {width:g}x{height:g} pixels")
    if given is not None and given != own:
        raise UsageError(f"{path}: its cameras are of {own[0]}x{own[1]} pixels; leave out --size")
    return own
