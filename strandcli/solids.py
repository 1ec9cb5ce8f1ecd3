"""Solids at one moment, packed as the numbers that kernels take."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .scene.motion import solid_pose

COLUMNS = {"sphere": 5, "capsule": 9, "plane": 4, "box": 16}


def pack(kind: str, solids: list[Any], emitter: Any, time: float, dtype: Any = np.float32) -> NDArray[Any]:
    """All solids of one kind, (m, columns) in world units; the last column of all but planes is a tiny
    squared length, below which a direction counts as none.

    sphere: centre, r · capsule: first end, vector to the other end, r, 1 / its squared length ·
    plane: unit normal, its distance from the origin · box: centre, the rotation by rows, half extents.
    """
    rows = []
    for solid in solids:
        if solid.kind != kind:
            continue
        turned, moved = solid_pose(solid, emitter, time)
        tiny = 1e-30
        if kind == "sphere":
            rows.append([*moved, solid.radius, tiny])
            continue
        rotation, centre = np.array(turned), np.array(moved)
        if kind == "capsule":
            axis = rotation @ np.array([0.0, solid.length, 0.0])
            rows.append([*(centre - axis / 2), *axis, solid.radius, 1 / max(solid.length**2, tiny), tiny])
        elif kind == "plane":
            normal = rotation @ np.array([0.0, 1.0, 0.0])
            rows.append([*normal, float(normal @ centre)])
        else:
            rows.append([*centre, *rotation.ravel(), *(np.array(solid.size) / 2), tiny])
    return np.array(rows, dtype).reshape(-1, COLUMNS[kind])
