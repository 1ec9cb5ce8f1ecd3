"""Views as a camera of USD, in USD's own text, which needs no library.

One camera has all views, view k at time code k: programs play them, and read a film's camera so. Render settings have
the size of the pictures.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any

import numpy as np

from ..errors import UsageError
from .pinhole import Pinhole
from .usd import APERTURE_UNIT, TURN

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
