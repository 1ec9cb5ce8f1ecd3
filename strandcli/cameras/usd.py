"""Cameras of USD (https://openusd.org, UsdGeomCamera and UsdRenderSettings).

A camera looks along its -z, with y up, and its matrix, whose rows are its axes, takes it to the world. Only ratios of
the focal length and of the aperture's sides count in perspective; of an orthographic view the aperture is in tenths of
a unit of the world, whatever scales the camera. Offsets move the window on the picture's plane to the right and up. A
camera has no size in pixels: render settings have one, and where the aperture has another shape they say what is left
of it.

Numbers of a lens are in single precision there, which is up to 1e-4 pixels. Beside them strandcli writes them in double
precision, and reads these while they are the same in single precision, so a lens that another program changes counts.

They are written in USD's own text, which needs no library. One camera has all views, view k at time code k: programs
play them, and read a film's camera so.
"""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from ..common.rotations import turning
from ..errors import UsageError, one_line
from ..exchange.usd.process import ask
from ..files.inputs import opened
from .pinhole import Floats, Pinhole, Views, checked_rotation, picture_size, square_focal

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
class Picture:
    """Of the pictures width and height, pixels, the width of a pixel over its height, and what is left of an aperture
    of another shape."""

    size: tuple[int, int]
    pixel: float
    conform: str

    def scales(self, across: float, tall: float) -> tuple[float, float]:
        """Pixels along x and y of a unit of an aperture ``across`` wide and ``tall``."""
        width, height = self.size
        x, y = width / across, height / tall
        wide = y / self.pixel  # pixels along x of a unit where the height stays
        if abs(x - wide) <= SAME * x:
            return x, x * self.pixel
        if self.conform == "adjustPixelAspectRatio":
            return x, y
        keep_height = {
            "expandAperture": wide < x, "cropAperture": wide > x, "adjustApertureWidth": True,
            "adjustApertureHeight": False,
        }[self.conform]  # fmt: skip
        return (wide, y) if keep_height else (x, x * self.pixel)


def read(path: Path, size: tuple[int, int] | None, name: str, notes: list[str]) -> Views:
    """The views of a camera, one for each frame; ``name``: its path in the stage or the end of it, where there are
    several. Raises `UsageError` for a file that is damaged, and for a camera that is none."""
    with opened(path) as file:
        text = file.read(1) == b"#"
    request = {"do": "cameras", "path": str(path.absolute()), "text": text, "name": name}
    ((answer, (matrices, lenses, exact)),) = list(ask(path, request))
    where = f"{path}: {answer['camera']}"
    unit = float(answer["unit"])
    up, conform, projection = (one_line(answer[key])[:WORD] for key in ("up", "conform", "projection"))
    if not (math.isfinite(unit) and unit > 0) or up not in UPS:
        raise UsageError(f"{path}: metersPerUnit {unit:g}, upAxis {up}: they have to be above 0, and y or z")
    if conform not in CONFORMS or not (math.isfinite(answer["pixel"]) and answer["pixel"] > 0):
        raise UsageError(f"{path}: render settings: {conform} of pixels {answer['pixel']:g}: is not known")
    if projection not in ("perspective", "orthographic"):
        raise UsageError(f"{where}: projection {projection} is not drawn")
    width, height = answer["size"] or (None, None)
    picture = Picture(picture_size(width, height, size, path), answer["pixel"], conform)
    codes = answer["codes"]
    found = answer["names"] if len(answer["names"]) == len(codes) else [_name(code) for code in codes]
    exact = exact if exact.shape == (len(found), 4) else lenses[:, :4]
    views = []
    for row, called in enumerate(found):
        at = where if codes[row] is None else f"{where}: time code {codes[row]:g}"
        lens = lenses[row].copy()
        same = exact[row].astype(np.float32) == lens[:4].astype(np.float32)
        lens[:4][same] = exact[row][same]
        view = _view(called, projection == "perspective", matrices[row], lens, picture, at, notes)
        near = answer["near"] if answer["near"] is not None and 0 < answer["near"] < math.inf else None
        view = replace(view, near=near).moved(turning(up, "y"), np.zeros(3), unit)
        views.append(view)
    return Views(views, bool(answer["own"]), unit=unit, up=up)


def _name(code: float | None) -> str:
    """The name of a view at a time code."""
    return "0000" if code is None else f"{round(code):04d}" if float(code).is_integer() else f"{code:g}"


def _view(
    name: str, perspective: bool, matrix: Floats, lens: Floats, picture: Picture, where: str, notes: list[str]
) -> Pinhole:
    """The view of a camera in the stage's own coordinates, its focal length in pixels a unit where it is
    orthographic."""
    focal_length, across, off_x, off_y, tall = (float(one) for one in lens)
    given = f"focalLength {focal_length:g}, aperture {across:g} by {tall:g}, offsets {off_x:g} and {off_y:g}"
    if not np.isfinite(lens).all() or min(across, tall) <= 0 or (perspective and focal_length <= 0):
        raise UsageError(f"{where}: {given}: the first three must be above 0, all finite")
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


APERTURE = 36.0
"""Width of a perspective camera's aperture, of what programs take for millimetres; cf. full frame."""
CAMERA, SETTINGS = "/camera", "/Render/settings"
HEAD = f"""#usda 1.0
(
    defaultPrim = "{CAMERA[1:]}"
    metersPerUnit = 1
    upAxis = "Y"
{{ranged}}    timeCodesPerSecond = {{rate}}
    framesPerSecond = {{rate}}
    renderSettingsPrimPath = "{SETTINGS}"
)

def Camera "{CAMERA[1:]}"
{{{{
"""
TAIL = f"""
}}}}

def Scope "Render"
{{{{
    def RenderSettings "settings"
    {{{{
        uniform int2 resolution = ({{width}}, {{height}})
        rel camera = <{CAMERA}>
    }}}}
}}}}
"""
NEAR, FAR = 0.01, 1e4
"""Metres; clipping planes that are written where a view has none."""
LENS = ("focalLength", "horizontalAperture", "horizontalApertureOffset", "verticalApertureOffset")
"""Attributes that `strandcli:lens` has in double precision."""


def written(views: Sequence[Pinhole], codes: Sequence[float] | None = None, rate: float = 24.0) -> bytes:
    """The file, of views of one size and projection in metres, y up, at time codes that rise, of which ``rate`` are a
    second. Raises `UsageError` for views that differ in size or projection."""
    codes = range(1, len(views) + 1) if codes is None else codes
    first, last = views[0], codes[-1]
    for view in views:
        if (view.width, view.height, view.perspective) != (first.width, first.height, first.perspective):
            raise UsageError("a camera of USD has views of one size and projection; these are of several")
    lenses = [_lens(view) for view in views]
    tall = [lens[1] * view.height / view.width for lens, view in zip(lenses, views, strict=True)]
    nears = [_single(view.near or NEAR) for view in views]
    lines = [
        _values("matrix4d xformOp:transform", [_matrix(view) for view in views], codes),
        '    uniform token[] xformOpOrder = ["xformOp:transform"]',
        f'    token projection = "{"perspective" if first.perspective else "orthographic"}"',
        _values("float2 clippingRange", [f"({near}, {_single(max(FAR, 2 * float(near)))})" for near in nears], codes),
        _values("float verticalAperture", [_single(one) for one in tall], codes),
        *(_values(f"float {name}", [_single(lens[k]) for lens in lenses], codes) for k, name in enumerate(LENS)),
        _values("custom double4 strandcli:lens", [_row(lens) for lens in lenses], codes),
        f"    custom string[] strandcli:names = {json.dumps([view.name for view in views])}",
    ]  # fmt: skip
    ranged = f"    startTimeCode = {codes[0]!r}\n    endTimeCode = {last!r}\n" if len(views) > 1 else ""
    text = HEAD.format(ranged=ranged, rate=f"{rate:.12g}") + "\n".join(lines)
    return (text + TAIL.format(width=first.width, height=first.height)).encode()


def _lens(view: Pinhole) -> tuple[float, float, float, float]:
    """Focal length, width of the aperture, and its offsets to the right and up."""
    across = APERTURE if view.perspective else view.width / view.focal / APERTURE_UNIT
    each = across / view.width
    focal = view.focal * each if view.perspective else APERTURE
    return focal, across, (view.width / 2 - view.centre[0]) * each, (view.centre[1] - view.height / 2) * each


def _matrix(view: Pinhole) -> str:
    """From the camera to the world, rows in brackets; its rows are the camera's axes, and where it is."""
    axes = [_row([*axis, 0.0]) for axis in TURN @ view.rotation]
    return f"({', '.join([*axes, _row([*view.eye, 1.0])])})"


def _values(what: str, values: Sequence[str], codes: Sequence[float]) -> str:
    """A line of an attribute with its value, or one at each time."""
    if len(values) == 1:
        return f"    {what} = {values[0]}"
    samples = "".join(f"        {code!r}: {value},\n" for code, value in zip(codes, values, strict=True))
    return f"    {what}.timeSamples = {{\n{samples}    }}"


def _row(values: Any) -> str:
    return f"({', '.join(repr(float(one)) for one in values)})"


def _single(value: float) -> str:
    return str(np.float32(value))
