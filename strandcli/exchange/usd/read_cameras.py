"""What a stage of USD says of one of its cameras, as a message; runs in the worker."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator
from typing import Any

import numpy as np
from pxr import Usd, UsdGeom, UsdRender

from .open_stage import layers_of, opened
from .process import Fill, Message, RefusedFileError
from .read_stage import rate_of, times_along

OWN = "strandcli:lens"
"""Attribute of cameras that strandcli wrote: `LENS` in double precision."""
NAMES = "strandcli:names"
"""Names of the views, one for each time."""
LENS = ("focalLength", "horizontalAperture", "horizontalApertureOffset", "verticalApertureOffset", "verticalAperture")
"""Attributes of a camera that are sent, in this order."""
MOST_TOLD, MOST = 8, 100_000
"""Cameras that are listed by name; views of a camera."""


def read(request: dict[str, Any], fill: Fill) -> Iterator[Message]:
    """Of the camera ``name`` (its path, or the end of it; "": the only one, or that of the render settings) at each
    frame: its matrices (n, 4, 4) to the world, `LENS` (n, 5), and what strandcli wrote of that (n, 4) or nothing."""
    stage = opened(request["path"])
    settings = _settings(stage)
    prim = _chosen(stage, request["name"], settings)
    camera = UsdGeom.Camera(prim)
    own = prim.GetAttribute(OWN)
    stated = [camera.GetPrim().GetAttribute(name) for name in LENS]
    times = times_along(prim, [*stated, *([own] if own else [])])
    codes = [Usd.TimeCode(time) for time in _frames(stage, times, bool(own))] or [Usd.TimeCode.EarliestTime()]
    places = UsdGeom.XformCache()
    matrices, lenses, exact = [], [], []
    for code in codes:
        places.SetTime(code)
        matrices.append([list(row) for row in places.GetLocalToWorldTransform(prim)])
        lenses.append([float(one.Get(code)) for one in stated])
        values = own.Get(code) if own else None
        exact += [] if values is None else [list(values)]
    near = camera.GetClippingRangeAttr()
    names = prim.GetAttribute(NAMES)
    yield {
        "camera": str(prim.GetPath()),
        "projection": str(camera.GetProjectionAttr().Get(codes[0])),
        "near": float(near.Get(codes[0])[0]) if near.HasAuthoredValue() else None,
        "codes": [code.GetValue() if times else None for code in codes],
        "names": [str(one) for one in names.Get() or []] if names else [],
        "own": bool(own),
        "up": str(UsdGeom.GetStageUpAxis(stage)).lower() if stage.HasAuthoredMetadata("upAxis") else "y",
        "unit": UsdGeom.GetStageMetersPerUnit(stage) if UsdGeom.StageHasAuthoredMetersPerUnit(stage) else 1.0,
        "layers": layers_of(stage),
        **_picture(settings),
    }, [np.array(matrices), np.array(lenses), np.array(exact, np.float64)]  # fmt: skip


def _chosen(stage: Usd.Stage, name: str, settings: UsdRender.Settings | None) -> Usd.Prim:
    """The camera that is meant. Raises `RefusedFileError`, which names those that there are."""
    prims = list(Usd.PrimRange.Stage(stage, Usd.TraverseInstanceProxies(Usd.PrimDefaultPredicate)))
    found = {str(prim.GetPath()): prim for prim in prims if prim.IsA(UsdGeom.Camera)}
    if not found:
        kinds = Counter(str(prim.GetTypeName()) or "prims without a type" for prim in prims)
        there = ", ".join(f"{count} {kind}" for kind, count in kinds.most_common(MOST_TOLD))
        raise RefusedFileError(f"has no camera; there are {there}" if there else "has no camera and nothing else")
    listed = ", ".join(list(found)[:MOST_TOLD]) + (
        f" and {len(found) - MOST_TOLD} more" if len(found) > MOST_TOLD else ""
    )
    if name:
        meant = [path for path in found if path == name or path.endswith("/" + name.lstrip("/"))]
        if len(meant) > 1 and name not in found:
            raise RefusedFileError(
                f"{len(meant)} cameras are called {name}: {', '.join(meant[:MOST_TOLD])}; give a path"
            )
        if not meant:
            raise RefusedFileError(f"has no camera {name}; there are {listed}")
        return found[name if name in found else meant[0]]
    if len(found) > 1:
        targets = [str(path) for path in settings.GetCameraRel().GetForwardedTargets()] if settings else []
        meant = [path for path in targets if path in found]
        if len(meant) != 1:
            raise RefusedFileError(f"holds {len(found)} cameras: {listed}; choose one: --camera NAME, or camera.name")
        return found[meant[0]]
    return next(iter(found.values()))


def _settings(stage: Usd.Stage) -> UsdRender.Settings | None:
    """The stage's render settings: those that it names, or the only ones."""
    named = UsdRender.Settings.GetStageRenderSettings(stage)
    if named:
        return named
    found = [UsdRender.Settings(prim) for prim in stage.Traverse() if prim.IsA(UsdRender.Settings)]
    return found[0] if len(found) == 1 else None


def _picture(settings: UsdRender.Settings | None) -> dict[str, Any]:
    """Width and height of pictures in pixels, or None; how wide a pixel is over its height; and what is left of the
    aperture where its shape is not the picture's."""
    found: dict[str, Any] = {"size": None, "pixel": 1.0, "conform": "expandAperture"}
    if settings:
        if settings.GetResolutionAttr().HasAuthoredValue():
            found["size"] = [int(one) for one in settings.GetResolutionAttr().Get()]
        found["pixel"] = float(settings.GetPixelAspectRatioAttr().Get())
        found["conform"] = str(settings.GetAspectRatioConformPolicyAttr().Get())
    return found


def _frames(stage: Usd.Stage, times: list[float], own: bool) -> list[float]:
    """Time codes of the views of a camera that changes at ``times``: of one that strandcli wrote these; else a frame
    after the other, from the stage's first to its last, or from the camera's where the stage has none."""
    if own or len(times) < 2:
        return times
    ranged = stage.HasAuthoredTimeCodeRange()
    begin, end = (stage.GetStartTimeCode(), stage.GetEndTimeCode()) if ranged else (times[0], times[-1])
    if not ranged and math.ceil(begin) <= end:
        begin = math.ceil(begin)  # samples before it are for motion blur
    frames = float(stage.GetFramesPerSecond())
    step = rate_of(stage) / frames if frames > 0 else 1.0
    count = (end - begin) / step if math.isfinite(step) else math.nan
    if not count >= 0:
        raise RefusedFileError(f"its frames go from time code {begin:g} to {end:g}, which are none")
    if count >= MOST:
        raise RefusedFileError(f"its frames go from time code {begin:g} to {end:g}; {MOST:,} are read at the most")
    return [begin + step * number for number in range(int(count + 1e-6) + 1)]
