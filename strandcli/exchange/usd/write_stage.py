"""Write a stage of USD with one prim of curves, of what messages tell; runs in the worker."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom, Vt

from .messages import Fill, Message, receive

NAME = "/strands"
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
        told, arrays = receive(fill)
        if told.get("all"):
            return
        yield told, arrays


def _write(request: dict[str, Any], parts: Iterator[Message]) -> None:
    layer = Sdf.Layer.CreateNew(request["temporary"], {"format": request["format"]})
    stage = Usd.Stage.Open(layer)
    curves = UsdGeom.BasisCurves.Define(stage, NAME)
    told, arrays = next(parts)
    _describe(stage, curves, told, arrays)
    waiting, codes = 0, []
    for told, (points,) in parts:
        code = told["code"]
        moment = Usd.TimeCode.Default() if code is None else Usd.TimeCode(code)
        curves.GetPointsAttr().Set(Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(points)), moment)
        curves.GetExtentAttr().Set([Gf.Vec3f(*corner) for corner in told["extent"]], moment)
        codes += [] if code is None else [code]
        waiting += points.nbytes
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


def _describe(stage: Usd.Stage, curves: UsdGeom.BasisCurves, told: dict[str, Any], arrays: list[Any]) -> None:
    """Write all but points."""
    stage.SetDefaultPrim(curves.GetPrim())
    UsdGeom.SetStageUpAxis(stage, told["up"])
    UsdGeom.SetStageMetersPerUnit(stage, told["unit"])
    stage.GetRootLayer().customLayerData = {"creator": "strandcli"}
    if told["beside"]:
        _add(stage, told["beside"])
    if told["rate"] is not None:
        stage.SetTimeCodesPerSecond(told["rate"])
        stage.SetFramesPerSecond(told["rate"])
    kind, basis, wrap = told["basis"]
    curves.CreateTypeAttr(kind)
    if basis:
        curves.CreateBasisAttr(basis)
    curves.CreateWrapAttr(wrap)
    curves.CreatePointsAttr()
    curves.CreateExtentAttr()
    curves.CreateCurveVertexCountsAttr(Vt.IntArray.FromNumpy(arrays[0]))
    primvars = UsdGeom.PrimvarsAPI(curves.GetPrim())
    for (name, interpolation), values in zip(told["attributes"], arrays[1:], strict=True):
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
