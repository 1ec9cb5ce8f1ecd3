"""Cameras of USD (https://openusd.org, UsdGeomCamera and UsdRenderSettings).

A camera looks along its -z, with y up, and its matrix, whose rows are its axes, takes it to the world. Only ratios of
the focal length and of the aperture's sides count in perspective; of an orthographic view the aperture is in tenths of
a unit of the world, whatever scales the camera. Offsets move the window on the picture's plane to the right and up. A
camera has no size in pixels: render settings have one, and where the aperture has another shape they say what is kept
of it.

Numbers of a lens are in single precision there, which is up to 1e-4 pixels. Beside them strandcli writes them in double
precision, and reads these while they are the same in single precision, so a lens that another program changes counts.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ..errors import UsageError, one_line
from ..exchange.edit.transform import turning
from ..exchange.usd.process import ask
from ..files.inputs import opened
from .lens import picture_size, square_focal
from .pinhole import Floats, Pinhole, checked_rotation

APERTURE_UNIT = 0.1
"""Units of the world, of an aperture of 1."""
SAME = 1e-6
"""Share by which shapes of aperture and picture may differ by rounding."""
CONFORMS = ("expandAperture", "cropAperture", "adjustApertureWidth", "adjustApertureHeight", "adjustPixelAspectRatio")
WORD = 40
"""Letters of a word of a file in a message, at most."""
UPS = ("y", "z")
TURN = np.diag([1.0, -1.0, -1.0])
"""From right, up, back to right, down, forward."""


@dataclass(frozen=True)
class Stage:
    """Views of a camera of a stage, in metres, y up; and of the stage's own coordinates the metres of a unit, and the
    up axis."""

    views: Sequence[Pinhole]
    own: bool
    unit: float
    up: str


@dataclass(frozen=True)
class Picture:
    """Of the pictures width and height, pixels, the width of a pixel over its height, and what is kept of an aperture
    of another shape."""

    size: tuple[int, int]
    pixel: float
    conform: str

    def scales(self, across: float, tall: float) -> tuple[float, float]:
        """Pixels along x and y of a unit of an aperture ``across`` wide and ``tall``."""
        width, height = self.size
        x, y = width / across, height / tall
        wide = y / self.pixel  # pixels along x of a unit where the height is kept
        if abs(x - wide) <= SAME * x:
            return x, x * self.pixel
        if self.conform == "adjustPixelAspectRatio":
            return x, y
        keep_height = {
            "expandAperture": wide < x, "cropAperture": wide > x, "adjustApertureWidth": True,
            "adjustApertureHeight": False,
        }[self.conform]  # fmt: skip
        return (wide, y) if keep_height else (x, x * self.pixel)


def read(path: Path, size: tuple[int, int] | None, name: str, notes: list[str]) -> Stage:
    """The views of a camera, one for each frame; ``name``: its path in the stage or the end of it, where there are
    several. Raises `UsageError` for a file that is damaged, and for a camera that is none."""
    with opened(path) as file:
        text = file.read(1) == b"#"
    request = {"do": "cameras", "path": str(path.absolute()), "text": text, "name": name}
    ((told, (matrices, lenses, exact)),) = list(ask(path, request))
    where = f"{path}: {told['camera']}"
    unit = float(told["unit"])
    up, conform, projection = (one_line(told[key])[:WORD] for key in ("up", "conform", "projection"))
    if not (math.isfinite(unit) and unit > 0) or up not in UPS:
        raise UsageError(f"{path}: metersPerUnit {unit:g}, upAxis {up}: they have to be above 0, and y or z")
    if conform not in CONFORMS or not (math.isfinite(told["pixel"]) and told["pixel"] > 0):
        raise UsageError(f"{path}: render settings: {conform} of pixels {told['pixel']:g}: is not known")
    if projection not in ("perspective", "orthographic"):
        raise UsageError(f"{where}: projection {projection} is not drawn")
    width, height = told["size"] or (None, None)
    picture = Picture(picture_size(width, height, size, path), told["pixel"], conform)
    found = told["names"] if len(told["names"]) == len(told["codes"]) else [_name(code) for code in told["codes"]]
    exact = exact if exact.shape == (len(found), 4) else lenses[:, :4]
    views = []
    for row, called in enumerate(found):
        at = where if told["codes"][row] is None else f"{where}: time code {told['codes'][row]:g}"
        lens = lenses[row].copy()
        same = exact[row].astype(np.float32) == lens[:4].astype(np.float32)
        lens[:4][same] = exact[row][same]
        view = _view(called, projection == "perspective", matrices[row], lens, picture, at, notes)
        near = told["near"] if told["near"] is not None and 0 < told["near"] < math.inf else None
        view = replace(view, near=near).moved(turning(up, "y"), np.zeros(3), unit)
        views.append(view)
    return Stage(views, bool(told["own"]), unit, up)


def _name(code: float | None) -> str:
    """The name of a view at a time code."""
    return "0000" if code is None else f"{round(code):04d}" if float(code).is_integer() else f"{code:g}"


def _view(
    name: str, perspective: bool, matrix: Floats, lens: Floats, picture: Picture, where: str, notes: list[str]
) -> Pinhole:
    """The view of a camera in the stage's own coordinates, its focal length in pixels a unit where it is
    orthographic."""
    focal_length, across, off_x, off_y, tall = (float(one) for one in lens)
    told = f"focalLength {focal_length:g}, aperture {across:g} by {tall:g}, offsets {off_x:g} and {off_y:g}"
    if not np.isfinite(lens).all() or min(across, tall) <= 0 or (perspective and focal_length <= 0):
        raise UsageError(f"{where}: {told}: the first three must be above 0, all finite")
    scale = float(np.cbrt(abs(np.linalg.det(matrix[:3, :3])))) if np.isfinite(matrix).all() else 0.0
    try:
        if not scale > 0 or not math.isfinite(scale):
            raise ValueError("is no rotation")
        rotation = TURN @ checked_rotation(matrix[:3, :3] / scale)
    except ValueError as error:
        raise UsageError(f"{where}: its transform {error}; a camera may be turned, moved and scaled evenly") from None
    x, y = picture.scales(across, tall)
    width, height = picture.size
    centre = (width / 2 - off_x * x, height / 2 + off_y * y)
    if perspective:
        focal = square_focal(x * focal_length, y * focal_length, picture.size, where, notes)
    else:
        focal = square_focal(x / APERTURE_UNIT, y / APERTURE_UNIT, picture.size, where, notes)
    return Pinhole(name, width, height, focal, centre, rotation, matrix[3, :3].copy(), perspective)
