"""Data of solids for drawing, beside their packed form: screen bounds, colours and coats."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...scene.motion import solid_pose
from ...solids import COLUMNS, SHAPES, Solids, custom, in_order
from ..view.camera import View

NONE = Solids(*(np.zeros((0, 1), np.float32),) * len(COLUMNS))
"""Packed solids of a scene without any; kernels compiled for solids take it too."""


def frames_of(packed: Solids, view: View) -> NDArray[np.int64]:
    """Return the screen bounds (m, 4) of all solids, in the order of `COLUMNS`: left, right, top, bottom in pixels,
    right and bottom exclusive. They are the whole picture for a plane, and for a solid that extends behind the eye."""
    whole = (0, int(view.width), 0, int(view.height))
    rows = [
        whole if kind == "plane" else _frame(*ball_of(kind, solid), view) or whole for kind, solid in rows_of(packed)
    ]
    return np.array(rows, np.int64).reshape(-1, 4)


def rows_of(packed: Solids) -> Iterator[tuple[str, NDArray[np.float64]]]:
    """Yield the kind and the row of each packed solid, in order; the kind is "" for custom ones."""
    for kind, rows in zip((*SHAPES, ""), packed, strict=False):
        for row in rows.astype(np.float64):
            yield kind, row


def ball_of(kind: str, row: NDArray[np.float64]) -> tuple[NDArray[np.float64], float]:
    """Return centre and radius of a bounding ball of a packed solid that is not a plane."""
    found: tuple[NDArray[np.float64], float] = (SHAPES[kind] if kind else custom).ball(row)
    return found


def _frame(centre: NDArray[np.float64], radius: float, view: View) -> tuple[int, int, int, int] | None:
    """Return the screen bounds of a ball, or None if it extends behind the eye."""
    x, y, z = (float(axis @ (centre - view.eye)) for axis in (view.right, view.up, view.forward))
    out: list[int] = []
    for along, axis, size in zip((x, -y), view.middle, (view.width, view.height), strict=True):
        if view.perspective:
            flat = along * along + z * z
            if z <= radius or flat <= radius * radius:
                return None
            # tangents from the eye to the circle in this plane
            middle, reach = math.atan2(along, z), math.asin(radius / math.sqrt(flat))
            if abs(middle) + reach >= math.pi / 2 - 1e-6:
                return None
            low, high = view.focal * math.tan(middle - reach), view.focal * math.tan(middle + reach)
        else:
            low, high = view.focal * (along - radius), view.focal * (along + radius)
        low, high = (min(max(axis + side, 0.0), size) for side in (low, high))
        out += [math.floor(low), math.ceil(high)]
    return out[0], out[1], out[2], out[3]


def paint_of(solids: Sequence[Any], emitter: Any, time: float) -> NDArray[np.float32]:
    """Return (m, 8) colour, fade distance, centre of the fading and an unused column, in the order of `COLUMNS`."""
    rows = [
        [*solid.colour, getattr(solid, "fade", 0.0), *solid_pose(solid, emitter, time).translation, 0.0]
        for solid in in_order(solids)
    ]
    return np.array(rows, np.float32)


def coats_of(solids: Sequence[Any]) -> NDArray[np.float32] | None:
    """Return (m, 7) the columns of `kernels.coat`, in the order of `COLUMNS`: reflectance of the coat at normal
    incidence, its roughness, amplitude of the patches, width of the largest, subsurface scattering of red, green and
    blue; None if no solid has any of them."""
    if not any(solid.coat > 0 or solid.mottle > 0 or any(solid.subsurface) for solid in solids):
        return None
    rows = [[one.coat, one.roughness, one.mottle, one.grain, *one.subsurface] for one in in_order(solids)]
    return np.array(rows, np.float32)
