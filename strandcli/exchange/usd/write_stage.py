"""Write a layer of USD with prims of curves, of what messages tell; runs in the worker."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from pxr import Gf, Sdf, UsdGeom, Vt

from .process import Fill, Message, receive

HOLDER = "/strands"
"""What holds several prims of curves; one stands by itself."""
SAVED = 1 << 26
"""Bytes of points that are in memory before they are written."""
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
OWN = ("widths", "normals")
"""Attributes that curves have themselves; the rest are primvars."""
TYPES = {"normals": Sdf.ValueTypeNames.Normal3fArray, "displayColor": Sdf.ValueTypeNames.Color3fArray,
         "st": Sdf.ValueTypeNames.TexCoord2fArray,
         "groom_root_uv": Sdf.ValueTypeNames.TexCoord2fArray}  # fmt: skip
"""Types of primvars of which the name tells more."""


def write(request: dict[str, Any], fill: Fill) -> Iterator[Message]:
    """Write what comes until it is said to be all. Messages are taken to the last one, whatever is wrong."""
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
    """Write a layer. No stage is open meanwhile: it would compose all prims again for each."""
    layer = Sdf.Layer.CreateNew(request["temporary"], {"format": request["format"]})
    message, arrays = next(parts)
    with Sdf.ChangeBlock():
        places = _prims(layer, message, arrays)
        arrays.clear()
        _describe(layer, message)
    waiting, codes = 0, []
    for message, points in parts:
        code = message["code"]
        points.reverse()
        with Sdf.ChangeBlock():
            for place, extent in zip(places, message["extents"], strict=True):
                waiting += points[-1].nbytes
                values = Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(points.pop()))
                box = Vt.Vec3fArray([Gf.Vec3f(*corner) for corner in extent])
                for name, stored in ((UsdGeom.Tokens.points, values), (UsdGeom.Tokens.extent, box)):
                    if code is None:
                        layer.GetAttributeAtPath(f"{place}.{name}").default = stored
                    else:
                        layer.SetTimeSample(f"{place}.{name}", code, stored)
        codes += [] if code is None else [code]
        if waiting > SAVED and request["format"] == "usdc":
            layer.Save()
            waiting = 0
    if codes:
        layer.startTimeCode, layer.endTimeCode = codes[0], codes[-1]
    layer.Save()


def _add(layer: Sdf.Layer, text: str) -> None:
    """Add the prims of a layer in USD's own text, and which render settings it names."""
    other = Sdf.Layer.CreateAnonymous(".usda")
    other.ImportFromString(text)
    for prim in other.rootPrims:
        Sdf.CopySpec(other, prim.path, layer, prim.path)
    settings = "renderSettingsPrimPath"
    if other.pseudoRoot.HasInfo(settings):
        layer.pseudoRoot.SetInfo(settings, other.pseudoRoot.GetInfo(settings))


def _prims(layer: Sdf.Layer, message: dict[str, Any], arrays: list[Any]) -> list[Sdf.Path]:
    """Write prims of curves, all but their points, and return their paths. The default prim is the only one, or what
    holds several."""
    holder, rest = layer.pseudoRoot, iter(arrays)
    if len(message["prims"]) > 1:
        holder = Sdf.PrimSpec(layer, HOLDER[1:], Sdf.SpecifierDef, "Xform")
    places = []
    for one in message["prims"]:
        prim = Sdf.PrimSpec(holder, one["name"], Sdf.SpecifierDef, "BasisCurves")
        _curves(prim, next(rest))
        _set(prim, one["attributes"], [next(rest) for _ in one["attributes"]])
        places.append(prim.path)
    layer.defaultPrim = layer.rootPrims[0].name
    return places


def _describe(layer: Sdf.Layer, message: dict[str, Any]) -> None:
    """Write what concerns all of the layer."""
    layer.pseudoRoot.SetInfo(UsdGeom.Tokens.upAxis, message["up"])
    layer.pseudoRoot.SetInfo(UsdGeom.Tokens.metersPerUnit, message["unit"])
    layer.customLayerData = {"creator": "strandcli"}
    if message["beside"]:
        _add(layer, message["beside"])
    if message["rate"] is not None:
        layer.timeCodesPerSecond = layer.framesPerSecond = message["rate"]


def _attribute(prim: Sdf.PrimSpec, name: str, kind: Sdf.ValueTypeName, value: Any, interpolation: str = "") -> None:
    """Add an attribute, ``value`` None for one without. Tokens are uniform, as curves have theirs."""
    uniform = kind == Sdf.ValueTypeNames.Token
    found = Sdf.AttributeSpec(prim, name, kind, Sdf.VariabilityUniform if uniform else Sdf.VariabilityVarying)
    if value is not None:
        found.default = value
    if interpolation:
        found.SetInfo("interpolation", interpolation)


def _curves(prim: Sdf.PrimSpec, counts: Any) -> None:
    """Add the attributes of linear curves, without points."""
    types, tokens = Sdf.ValueTypeNames, UsdGeom.Tokens
    _attribute(prim, tokens.type, types.Token, tokens.linear)
    _attribute(prim, tokens.wrap, types.Token, tokens.nonperiodic)
    _attribute(prim, tokens.points, types.Point3fArray, None)
    _attribute(prim, tokens.extent, types.Float3Array, None)
    _attribute(prim, tokens.curveVertexCounts, types.IntArray, Vt.IntArray.FromNumpy(counts))


def _set(prim: Sdf.PrimSpec, attributes: list[list[str]], arrays: list[Any]) -> None:
    """Add attributes, of names and interpolations."""
    for (name, interpolation), values in zip(attributes, arrays, strict=True):
        stored = values[:, 0] if values.shape[1] == 1 else values
        type_name, array = VALUES[values.dtype.str[1:], values.shape[1]]
        own = name in OWN
        kind = TYPES.get(name, type_name)
        numbers = array.FromNumpy(np.ascontiguousarray(stored))
        _attribute(prim, name if own else f"primvars:{name}", kind, numbers, interpolation)
