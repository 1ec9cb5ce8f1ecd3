"""Solids at one moment, packed as the numbers that kernels take."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..scene.motion import Pose, rotate, solid_pose

COLUMNS = {"sphere": 5, "capsule": 9, "plane": 4, "box": 16}
"""Numbers of a packed solid of each kind, in the order of the fields of `Solids`."""


class Solids(NamedTuple):
    """All solids at one moment, packed in world units, metres: (m, columns) of each kind, float32 where they are drawn.

    Solids are numbered through in the order of the fields. For drawing, spheres and capsules have one more column: the
    distance over which they blend. The last of the columns below is `TINY` but for planes.
    """

    spheres: NDArray[Any]
    """(m, 5) centre, radius."""
    capsules: NDArray[Any]
    """(m, 9) first end, vector to the other end, radius, 1 / the vector's squared length."""
    planes: NDArray[Any]
    """(m, 4) unit normal, its distance from the origin."""
    boxes: NDArray[Any]
    """(m, 16) centre, the rotation by rows, half extents."""


TINY = 1e-30
"""The last column of all but planes: a squared length below which a direction counts as none."""


def pack_all(solids: Sequence[Any], emitter: Any, time: float, dtype: Any = np.float32) -> Solids:
    """Solids of every kind packed at a time in seconds."""
    return Solids(*(pack(kind, list(solids), emitter, time, dtype) for kind in COLUMNS))


def pack(kind: str, solids: list[Any], emitter: Any, time: float, dtype: Any = np.float32) -> NDArray[Any]:
    """All solids of one kind, (m, columns) as in the fields of `Solids`."""
    rows = [numbers(one, solid_pose(one, emitter, time)) for one in solids if one.kind == kind]
    return np.array(rows, dtype).reshape(-1, COLUMNS[kind])


def numbers(solid: Any, pose: Pose) -> list[float]:
    """The row of one solid that has a pose."""
    if solid.kind == "sphere":
        return [*pose.translation, solid.radius, TINY]
    if solid.kind == "box":
        a, b, c = pose.rotation
        return [*pose.translation, *a, *b, *c, *(side / 2 for side in solid.size), TINY]
    x, y, z = rotate(pose.rotation, (0.0, 1.0, 0.0))
    u, v, w = pose.translation
    if solid.kind == "plane":
        return [x, y, z, x * u + y * v + z * w]
    size = solid.length
    axis = x * size, y * size, z * size
    first = u - axis[0] / 2, v - axis[1] / 2, w - axis[2] / 2
    return [*first, *axis, solid.radius, 1 / max(size**2, TINY), TINY]
