"""Write a stage of USD with prims of curves, of what messages tell; runs in the worker."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom, Vt

from .messages import Fill, Message, receive

HOLDER = "/strands"
"""What holds several prims of curves; one stands by itself."""
SAVED = 1 << 26
"""Bytes of points that are kept in memory before they are written."""
VALUES = {
    ("f4", 1): (Sdf.ValueTypeNames.FloatArray, Vt.FloatArray),
    ("f4", 2): (Sdf.ValueTypeNames.Float2Array, Vt.Vec2fArray),
    ("f4", 3): (Sdf.ValueTypeNames.Float3Array, Vt.Vec3fArray),
    ("f4", 4): (Sdf.ValueTypeNames.Float4Array, Vt.Vec4fArray),
    ("i4", 1): (Sdf.ValueTypeNames.IntArray, Vt.IntArray),
    ("i8", 1): (Sdf.ValueTypeNames.Int64Array, Vt.Int64Array),
    ("u1", 1): (Sdf.ValueTypeNames.UCharArray, Vt.UCharArray),
}
"""Types of primvars, by the type and number of the numbers that they are made of."""
TYPES = {"displayColor": Sdf.ValueTypeNames.Color3fArray, "st": Sdf.ValueTypeNames.TexCoord2fArray,
         "groom_root_uv": Sdf.ValueTypeNames.TexCoord2fArray}  # fmt: skip
"""Types of primvars of which the name tells more."""


def write(request: dict[str, Any], fill: Fill) -> Iterator[Message]:
    """Write what is told until it is said to be all. Messages are taken to the last one, whatever is wrong."""
    parts = _parts(fill)
    try:
        _write(request, parts)
    except Exception:
        for _ in parts:
            pass
        raise
    yield from ()


def _parts(fill: Fill) -> Iterator[Message]:
    while True:
        message, arrays = receive(fill)
        if message.get("all"):
            return
        yield message, arrays


def _write(request: dict[str, Any], parts: Iterator[Message]) -> None:
    layer = Sdf.Layer.CreateNew(request["temporary"], {"format": request["format"]})
    stage = Usd.Stage.Open(layer)
    message, arrays = next(parts)
    prims = _prims(stage, message, arrays)
    arrays.clear()
    _describe(stage, message)
    waiting, codes = 0, []
    for message, points in parts:
        code = message["code"]
        moment = Usd.TimeCode.Default() if code is None else Usd.TimeCode(code)
        points.reverse()
        for curves, extent in zip(prims, message["extents"], strict=True):
            waiting += points[-1].nbytes
            curves.GetPointsAttr().Set(Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(points.pop())), moment)
            curves.GetExtentAttr().Set([Gf.Vec3f(*corner) for corner in extent], moment)
        codes += [] if code is None else [code]
        if waiting > SAVED and request["format"] == "usdc":
            layer.Save()
            waiting = 0
    if codes:
        stage.SetStartTimeCode(codes[0])
        stage.SetEndTimeCode(codes[-1])
    layer.Save()


def _add(stage: Usd.Stage, text: str) -> None:
    """Add the prims of a layer in USD's own text, and which render settings it names."""
    layer, to = Sdf.Layer.CreateAnonymous(".usda"), stage.GetRootLayer()
    layer.ImportFromString(text)
    for prim in layer.rootPrims:
        Sdf.CopySpec(layer, prim.path, to, prim.path)
    settings = Usd.Stage.Open(layer).GetMetadata("renderSettingsPrimPath")
    if settings:
        stage.SetMetadata("renderSettingsPrimPath", settings)


def _prims(stage: Usd.Stage, message: dict[str, Any], arrays: list[Any]) -> list[UsdGeom.BasisCurves]:
    """Write the prims of curves, all but their points; one is the default prim, or what holds several."""
    names, rest = [one["name"] for one in message["prims"]], iter(arrays)
    holder = f"/{names[0]}" if len(names) == 1 else HOLDER
    if len(names) > 1:
        UsdGeom.Xform.Define(stage, holder)
    found = []
    for one in message["prims"]:
        place = holder if len(names) == 1 else f"{holder}/{one['name']}"
        found.append(_curves(stage, place, message["basis"], next(rest)))
        _set(found[-1], one["attributes"], [next(rest) for _ in one["attributes"]])
    stage.SetDefaultPrim(stage.GetPrimAtPath(holder))
    return found


def _describe(stage: Usd.Stage, message: dict[str, Any]) -> None:
    """Write what concerns all of the stage."""
    UsdGeom.SetStageUpAxis(stage, message["up"])
    UsdGeom.SetStageMetersPerUnit(stage, message["unit"])
    stage.GetRootLayer().customLayerData = {"creator": "strandcli"}
    if message["beside"]:
        _add(stage, message["beside"])
    if message["rate"] is not None:
        stage.SetTimeCodesPerSecond(message["rate"])
        stage.SetFramesPerSecond(message["rate"])


def _curves(stage: Usd.Stage, place: str, message: list[str], counts: Any) -> UsdGeom.BasisCurves:
    """A prim of curves of a basis, without points."""
    curves = UsdGeom.BasisCurves.Define(stage, place)
    kind, basis, wrap = message
    curves.CreateTypeAttr(kind)
    if basis:
        curves.CreateBasisAttr(basis)
    curves.CreateWrapAttr(wrap)
    curves.CreatePointsAttr()
    curves.CreateExtentAttr()
    curves.CreateCurveVertexCountsAttr(Vt.IntArray.FromNumpy(counts))
    return curves


def _set(curves: UsdGeom.BasisCurves, attributes: list[list[str]], arrays: list[Any]) -> None:
    """Write attributes, of names and interpolations."""
    primvars = UsdGeom.PrimvarsAPI(curves.GetPrim())
    for (name, interpolation), values in zip(attributes, arrays, strict=True):
        held = values[:, 0] if values.shape[1] == 1 else values
        type_name, array = VALUES[values.dtype.str[1:], values.shape[1]]
        numbers = array.FromNumpy(np.ascontiguousarray(held))
        if name == "widths":
            curves.CreateWidthsAttr(numbers)
            curves.SetWidthsInterpolation(interpolation)
        elif name == "normals":
            curves.CreateNormalsAttr(numbers)
            curves.SetNormalsInterpolation(interpolation)
        else:
            made = primvars.CreatePrimvar(name, TYPES.get(name, type_name), interpolation)
            made.Set(numbers)
