"""Solids as the drawing kernels need them beside their packed form: where on the screen, and in which colour."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...scene.motion import solid_pose
from ...solids import COLUMNS, SHAPES, Solids, in_order, joined, pack
from ...solids.shapes import other
from ..view.camera import View

NONE = Solids(*(np.zeros((0, 1), np.float32),) * len(COLUMNS))
"""Packed, those of a scene that has none: kernels are the same with them and without."""
ROOM = 4.0
"""Blending distances by which a solid that blends may become thicker."""


def packed(solids: Sequence[Any], emitter: Any, time: float) -> Solids:
    """Solids packed for drawing: of spheres and capsules the distance over which they blend is the last column."""
    out = []
    for kind in COLUMNS:
        rows = pack(kind, list(solids), emitter, time)
        if kind in ("sphere", "capsule"):
            ways = [solid.blend for solid in solids if solid.kind == kind]
            rows = np.column_stack([rows, np.array(ways, np.float32).reshape(len(rows), 1)]).astype(np.float32)
        out.append(rows)
    return joined(out, solids, emitter, time, np.float32)


def _blend(kind: str, solid: NDArray[np.float64]) -> float:
    """Distance over which a packed solid blends, metres; 0: it does not."""
    blends = kind in ("sphere", "capsule") and len(solid) > COLUMNS[kind]
    return float(solid[COLUMNS[kind]]) if blends else 0.0


def frames_of(packed: Solids, view: View) -> NDArray[np.int64]:
    """(m, 4) left, right, top, bottom in pixels of every solid, right and bottom not included; in the order of
    `COLUMNS`. The whole picture for a plane, and for a solid that reaches behind the eye."""
    width, height = int(view.width), int(view.height)
    rows: list[tuple[int, int, int, int]] = []
    nowhere = (2 * width + 2, 2 * width + 2, 2 * height + 2, 2 * height + 2)
    group: list[tuple[int, int, int, int]] = []
    first = -1
    for kind, solid in rows_of(packed):
        whole = (0, width, 0, height)
        if _blend(kind, solid) > 0:  # all that blend are drawn as the first of them
            centre, radius = ball_of(kind, solid)
            first = len(rows) if first < 0 else first
            group.append(_frame(centre, radius + ROOM * _blend(kind, solid), view) or whole)
            rows.append(nowhere)
            continue
        rows.append(whole if kind == "plane" else _frame(*ball_of(kind, solid), view) or whole)
    if group:
        left, right, top, bottom = zip(*group, strict=True)
        rows[first] = (min(left), max(right), min(top), max(bottom))
    return np.array(rows, np.int64).reshape(-1, 4)


def rows_of(packed: Solids) -> Iterator[tuple[str, NDArray[np.float64]]]:
    """The kind and the row of each of packed solids, in their order; the kind is "" for `others`."""
    for kind, rows in zip((*SHAPES, ""), packed, strict=False):
        for row in rows.astype(np.float64):
            yield kind, row


def ball_of(kind: str, row: NDArray[np.float64]) -> tuple[NDArray[np.float64], float]:
    """Centre and radius of a ball about a packed solid that is not a plane."""
    found: tuple[NDArray[np.float64], float] = (SHAPES[kind] if kind else other).ball(row)
    return found


def _frame(centre: NDArray[np.float64], radius: float, view: View) -> tuple[int, int, int, int] | None:
    """Pixels that a ball covers, or None where it reaches behind the eye."""
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
    """(m, 8) colour, fade distance and the centre of the fading, in the order of `COLUMNS`."""
    rows = [
        [*solid.colour, getattr(solid, "fade", 0.0), *solid_pose(solid, emitter, time).translation, 0.0]
        for solid in in_order(solids)
    ]
    return np.array(rows, np.float32)


def coats_of(solids: Sequence[Any]) -> NDArray[np.float32] | None:
    """(m, 4) of what each surface has beside its colour, as `kernels.coat` reads it: the coat's reflectance straight
    on and its roughness, spread of the patches and the width of the largest, in the order of `COLUMNS`; None where no
    solid has a coat or patches."""
    if not any(solid.coat > 0 or solid.mottle > 0 for solid in solids):
        return None
    rows = [
        [solid.coat, solid.roughness, solid.mottle, solid.grain]
        for solid in in_order(solids)
    ]
    return np.array(rows, np.float32)
