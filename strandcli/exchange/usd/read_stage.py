"""What a stage of USD says of its curves, as messages; runs in the worker."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import astuple
from typing import Any

import numpy as np
from pxr import Usd, UsdGeom

from ..splines import LINEAR, STRAIGHT, Basis, of_nurbs
from .open_stage import layers_of, opened
from .process import Fill, Message, RefusedFileError

PURPOSES = (("default", "render"), ("proxy",), ("guide",))
"""What is for pictures goes before stand-ins, and these before guides."""
OTHER_CURVES = ("PointInstancer",)
"""Types of which curves are reported but not read."""
OWN = ("widths", "normals")
"""Attributes that curves have themselves."""
UNREAD = ("velocities", "accelerations")
CLOSE = 1e-6
"""Time codes by which times may differ that mean the same."""


def read(request: dict[str, Any], fill: Fill) -> Iterator[Message]:
    """What a stage says of all curves, then of each prim of curves its points and attributes at the first time, or
    "at" so many seconds."""
    stage = opened(request["path"])
    prims, stated = curves_of(stage)
    times = times_of(prims)
    rate = rate_of(stage)
    yield {
        **stated,
        "up": str(UsdGeom.GetStageUpAxis(stage)).lower() if stage.HasAuthoredMetadata("upAxis") else None,
        "unit": UsdGeom.GetStageMetersPerUnit(stage) if UsdGeom.StageHasAuthoredMetersPerUnit(stage) else None,
        "times": [time / rate for time in times], "rate": frame_rate_of(stage),
        "changing": _changing(prims),
        "application": str((stage.GetRootLayer().customLayerData or {}).get("creator", "")),
        "not_found": len(stage.GetCompositionErrors()),
        "layers": layers_of(stage),
    }, []  # fmt: skip
    moment = Usd.TimeCode.EarliestTime()
    if times:
        moment = Usd.TimeCode(times[0] if request["at"] is None else _code(times, request["at"] * rate))
    places = UsdGeom.XformCache(moment)
    for prim in prims:
        yield _curves(UsdGeom.Curves(prim), moment, places)


def _changing(prims: list[Usd.Prim]) -> list[str]:
    """Names of attributes, visibility among them, that change with time, be they those of curves or of what holds
    them."""
    found, known = set(), set()
    for prim in prims:
        holder = prim
        while holder and holder.GetPath() not in known:
            known.add(holder.GetPath())
            for one in holder.GetAuthoredAttributes():
                name = one.GetName()
                if name.startswith(("primvars:", "widths", "visibility")) and one.GetNumTimeSamples() > 1:
                    found.add(name.removeprefix("primvars:"))
            holder = holder.GetParent()
    return sorted(found)


def rate_of(stage: Usd.Stage) -> float:
    """Time codes a second."""
    found = float(stage.GetTimeCodesPerSecond())
    return found if found > 0 else 24.0


def frame_rate_of(stage: Usd.Stage) -> float:
    """Frames a second: those that the stage says, else its time codes."""
    stated = float(stage.GetFramesPerSecond()) if stage.HasAuthoredMetadata("framesPerSecond") else 0.0
    return stated if stated > 0 else rate_of(stage)


def _code(times: list[float], code: float) -> float:
    """A time code; the sample's own where there is one, so that it is found whatever was rounded."""
    near = min(times, key=lambda time: abs(time - code))
    return near if abs(near - code) < CLOSE else code


def curves_of(stage: Usd.Stage) -> tuple[list[Usd.Prim], dict[str, Any]]:
    """The prims of curves that are read, and what is reported of the rest."""
    found: dict[str, list[Usd.Prim]] = {}
    skipped: Counter[str] = Counter()
    prims = iter(Usd.PrimRange.Stage(stage, Usd.TraverseInstanceProxies(Usd.PrimDefaultPredicate)))
    for prim in prims:
        name = str(prim.GetTypeName())
        if name in OTHER_CURVES:
            skipped[name] += 1
            prims.PruneChildren()
        elif prim.IsA(UsdGeom.Curves):
            curves = UsdGeom.Curves(prim)
            if curves.ComputeVisibility() == UsdGeom.Tokens.invisible:
                skipped["invisible"] += 1
            else:
                found.setdefault(str(curves.ComputePurpose()), []).append(prim)
        elif name == "Mesh":
            skipped[name] += 1
        elif not prim.IsA(UsdGeom.Imageable) or not prim.IsLoaded():
            skipped["not loaded"] += not prim.IsLoaded()
    for purposes in PURPOSES:
        chosen = [prim for purpose in purposes for prim in found.get(purpose, ())]
        if chosen:
            left = {purpose: len(there) for purpose, there in found.items() if purpose not in purposes}
            stated = {f"of purpose {purpose}": count for purpose, count in left.items()}
            purpose = "" if purposes == PURPOSES[0] else purposes[0]
            return chosen, {"not_read": {**{k: v for k, v in skipped.items() if v}, **stated}, "purpose": purpose}
    there = ", ".join(f"{count} {name}" for name, count in skipped.items() if count)
    if skipped["PointInstancer"]:
        there += ", whose instances are curves once its program makes them real"
    missing = len(stage.GetCompositionErrors())
    there += f"{'; ' if there else ''}{missing} of the files that it names cannot be read" if missing else ""
    raise RefusedFileError("has no curves" + (f" that can be read; there are {there}" if there else ""))


def times_of(prims: list[Usd.Prim]) -> list[float]:
    """Time codes at which points change, or where they are put, rising."""
    return sorted({time for prim in prims for time in times_along(prim, [UsdGeom.Curves(prim).GetPointsAttr()])})


def times_along(prim: Usd.Prim, attributes: list[Usd.Attribute]) -> list[float]:
    """Time codes at which any of its attributes changes, or where it is put, rising."""
    found = {time for one in attributes for time in one.GetTimeSamples()}
    holder = prim
    while holder and not holder.IsPseudoRoot():
        if holder.IsA(UsdGeom.Xformable):
            place = UsdGeom.Xformable(holder)
            if place.TransformMightBeTimeVarying():
                found.update(place.GetTimeSamples())
            if place.GetResetXformStack():
                break
        holder = holder.GetParent()
    return sorted(found)


def _matrix(prim: Usd.Prim, places: UsdGeom.XformCache) -> list[float]:
    return np.array(places.GetLocalToWorldTransform(prim)).ravel().tolist()  # its rows by the library: 40 times slower


def _counts(prim: Usd.Prim, moment: Usd.TimeCode) -> Any:
    """Control points of each curve (S,)."""
    values = UsdGeom.Curves(prim).GetCurveVertexCountsAttr().Get(moment)
    return _array(prim, "curveVertexCounts", values, "iu", 1)


def _points(prim: Usd.Prim, moment: Usd.TimeCode) -> Any:
    """Control points (P, 3)."""
    return _array(prim, "points", UsdGeom.Curves(prim).GetPointsAttr().Get(moment), "f", 2)


def _basis(prim: Usd.Prim, moment: Usd.TimeCode) -> Basis:
    """What control points of curves mean."""
    if prim.IsA(UsdGeom.NurbsCurves):
        curves = UsdGeom.NurbsCurves(prim)
        weights = np.asarray(curves.GetPointWeightsAttr().Get(moment) or [])
        if weights.size and (weights != weights[0]).any():
            raise RefusedFileError(f"{prim.GetPath()}: NURBS with weights that differ are not read")
        orders, knots = (one.Get(moment) or [] for one in (curves.GetOrderAttr(), curves.GetKnotsAttr()))
        return of_nurbs(np.asarray(orders), np.asarray(knots))
    if not prim.IsA(UsdGeom.BasisCurves):
        return Basis(LINEAR, label=f"{prim.GetTypeName()}, {STRAIGHT}")
    curves = UsdGeom.BasisCurves(prim)
    stated = [curves.GetTypeAttr(), curves.GetBasisAttr(), curves.GetWrapAttr()]
    return Basis(*(str(one.Get(moment)) for one in stated))


def _array(prim: Usd.Prim, name: str, values: Any, kinds: str, dimensions: int) -> Any:
    found = np.asarray([] if values is None else values)
    if values is None or not found.size:
        return np.zeros((0, 3) if dimensions == 2 else 0, "f4" if "f" in kinds else "i4")
    if found.dtype.kind not in kinds or found.ndim != dimensions or (dimensions == 2 and found.shape[1] != 3):
        raise RefusedFileError(f"{prim.GetPath()}: {name} are of a type that curves do not have")
    return found.astype(np.float32, copy=False) if "f" in kinds else found


def _curves(curves: UsdGeom.Curves, moment: Usd.TimeCode, places: UsdGeom.XformCache) -> Message:
    """Of a prim what its control points mean, those, and its attributes."""
    prim = curves.GetPrim()
    arrays = [_counts(prim, moment), _points(prim, moment)]
    listed, unread = [], []
    for name, interpolation, values in _attributes(curves, moment):
        if values is None:
            unread.append(name)
        else:
            listed.append([name, interpolation])
            arrays.append(values)
    unread += [name for name in UNREAD if prim.GetAttribute(name).HasAuthoredValue()]
    return {
        "prim": str(prim.GetPath()), "basis": astuple(_basis(prim, moment)),
        "matrix": _matrix(prim, places), "attributes": listed, "unread": unread,
    }, arrays  # fmt: skip


def _attributes(curves: UsdGeom.Curves, moment: Usd.TimeCode) -> Iterator[tuple[str, str, Any]]:
    """Name, interpolation and values of each attribute; None for values that are no numbers."""
    primvars = UsdGeom.PrimvarsAPI(curves.GetPrim()).FindPrimvarsWithInheritance()
    there = {str(one.GetPrimvarName()) for one in primvars}
    stated = (curves.GetWidthsInterpolation(), curves.GetNormalsInterpolation())
    for name, interpolation in zip(OWN, stated, strict=True):
        attribute = curves.GetPrim().GetAttribute(name)
        if attribute.HasAuthoredValue() and name not in there:
            values = attribute.Get(moment)
            yield name, str(interpolation), None if values is None else _numbers(values)
    for one in primvars:
        if not one.HasAuthoredValue():
            continue
        values = one.ComputeFlattened(moment) if one.GetElementSize() == 1 else None
        yield str(one.GetPrimvarName()), str(one.GetInterpolation()), None if values is None else _numbers(values)


def _numbers(values: Any) -> Any:
    """Values as an array with a row each, None for what is no numbers."""
    found = np.asarray(values)
    if found.dtype.kind not in "fiub" or found.ndim > 3 or (found.ndim == 0 and found.size != 1):
        return None
    rows = found.reshape(1, -1) if found.ndim == 0 else found.reshape(found.shape[0], -1) if found.size else None
    return None if rows is None else (rows.astype(np.int8) if rows.dtype.kind == "b" else rows)
