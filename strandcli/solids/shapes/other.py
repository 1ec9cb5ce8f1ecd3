"""Solids that have no kernels of their own: rows that hold a pose and the numbers of a shape, and the shapes' data.

Their shapes are files of `strandcli.solid_shapes` or of other packages. They are the rows of one array, `others`, the
fifth field of a named tuple that is made for the kinds that a scene has (`other_code`), after which come the arrays of
shapes that have `data`. Kernels are compiled for that type; scenes without such solids have `strandcli.solids.Solids`
and none of this.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...scene.model.solids import has_data, shape_of
from ...scene.motion import Pose

X, Y, Z = range(3)
"""Columns of a packed solid: its origin, metres."""
ROW_X, ROW_Y, ROW_Z = 3, 6, 9
"""Where the rows of its rotation begin: world = rotation · own. Column ROW_X + k is x of its own axis k."""
REACH, KIND, NUMBERS = 12, 13, 14
"""Radius of the ball about the origin that holds it, metres; its kind's place; the first number of its shape."""


def kinds_of(solids: Sequence[Any]) -> tuple[str, ...]:
    """The kinds of some solids, each once."""
    return tuple(sorted({solid.kind for solid in solids}))


def count_of(solid: Any) -> int:
    """How many numbers the functions of a solid's shape are given: those of the shape, and where it has data, the
    solid's place among those that share it."""
    shape = shape_of(solid.kind)
    return len(shape.numbers(solid)) + has_data(shape)


def columns_of(solids: Sequence[Any]) -> int:
    """Columns of the array of some solids."""
    return NUMBERS + max(count_of(one) for one in solids)


def numbers(solid: Any, pose: Pose, among: Sequence[Any]) -> list[float]:
    """The row of a solid that has a pose, one of the solids ``among``."""
    a, b, c = pose.rotation
    shape = shape_of(solid.kind)
    own = [float(one) for one in shape.numbers(solid)]
    if has_data(shape):
        own.append(float(next(place for place, one in enumerate(of_kind(solid.kind, among)) if one is solid)))
    kind = kinds_of(among).index(solid.kind)
    return [*pose.translation, *a, *b, *c, float(shape.reach(solid)), float(kind), *own]


def of_kind(kind: str, solids: Sequence[Any]) -> list[Any]:
    """Those of solids that are of a kind, in order."""
    return [one for one in solids if one.kind == kind]


def pack(solids: Sequence[Any], poses: Sequence[Pose], dtype: Any) -> NDArray[Any]:
    """(m, columns) the rows of such solids."""
    out = np.zeros((len(solids), columns_of(solids)), dtype)
    for row, solid, pose in zip(out, solids, poses, strict=True):
        found = numbers(solid, pose, solids)
        row[: len(found)] = found
    return out


def data_of(solids: Sequence[Any], time: float, past: float | None = None) -> list[NDArray[Any]]:
    """The arrays of the shapes of some solids at a time in seconds, kind after kind; ``past``: that of the step before,
    for shapes that carry along what touches them."""
    found: list[NDArray[Any]] = []
    for kind in kinds_of(solids):
        shape: Any = shape_of(kind)
        if has_data(shape):
            more = () if past is None or getattr(shape, "drift", None) is None else (past,)
            found += shape.data(of_kind(kind, solids), time, *more)
    return found


def ball(row: NDArray[np.float64]) -> tuple[NDArray[np.float64], float]:
    """Centre and radius of a ball about a packed solid."""
    return row[:3], float(row[REACH])
