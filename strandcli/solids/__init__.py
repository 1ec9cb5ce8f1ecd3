"""Solids that drawing, grooming and simulation share.

`Solids` holds all of them at one moment as the numbers that kernels take. What belongs to one shape stands in one file
in `shapes` (rows, bounds) and one in `kernels` (rays, normals, depth, contact). Nothing imported here is compiled.
Custom shapes, of `strandcli.solid_shapes` and of other packages (`register`), have all of theirs in one file.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..scene.model.solids import add as register
from ..scene.motion import Pose, solid_pose
from .shapes import box, capsule, plane, sphere

__all__ = [
    "COLUMNS", "SHAPES", "Solids", "custom_of", "in_order", "joined_with", "numbers", "pack",
    "pack_all", "register",
]  # fmt: skip

SHAPES: dict[str, Any] = {"sphere": sphere, "capsule": capsule, "plane": plane, "box": box}
"""By the `kind` that presets write, in the order of the fields of `Solids`."""
COLUMNS: dict[str, int] = {kind: shape.COLUMNS for kind, shape in SHAPES.items()}
"""Numbers of a packed solid of each kind."""


class Solids(NamedTuple):
    """All solids at one moment, packed in world units, metres: (m, columns) of each kind, float32 where they are drawn.

    Columns have their names in `strandcli.solids.shapes`. Solids are numbered through in the order of the fields.
    """

    spheres: NDArray[Any]
    """(m, 5) centre, radius, least squared length."""
    capsules: NDArray[Any]
    """(m, 9) first end, vector to the other end, radius, 1 / the vector's squared length, least squared length."""
    planes: NDArray[Any]
    """(m, 4) unit normal, its distance from the origin."""
    boxes: NDArray[Any]
    """(m, 16) centre, the rotation by rows, half extents, least squared length."""


def pack_all(solids: Sequence[Any], emitter: Any, time: float, dtype: Any = np.float32) -> Solids:
    """Solids of every kind packed at a time in seconds; with a fifth field where there are custom ones."""
    rows, found = [pack(kind, list(solids), emitter, time, dtype) for kind in SHAPES], custom_of(solids)
    if not found:
        return Solids(*rows)
    from .custom import data_of
    from .custom import pack as pack_custom

    rows.append(pack_custom(found, [solid_pose(one, emitter, time) for one in found], dtype))
    return joined_with(solids, rows, data_of(found, time))


def joined_with(solids: Sequence[Any], rows: Sequence[NDArray[Any]], data: Sequence[NDArray[Any]] = ()) -> Solids:
    """The packed rows of each kind of ``solids``, those of custom ones last, with the data of their shapes."""
    found = custom_of(solids)
    if not found:
        return Solids(*rows)
    from .custom import module_for

    module = module_for(found)
    made: Solids = (module.Solids if len(solids) > len(found) else module.LoneSolids)(*rows, *data)
    return made


def custom_of(solids: Sequence[Any]) -> list[Any]:
    """Those of solids whose shape has no kernels of its own."""
    return [one for one in solids if one.kind not in SHAPES]


def in_order(solids: Sequence[Any]) -> list[Any]:
    """Solids in the order in which `Solids` numbers them."""
    return [one for kind in SHAPES for one in solids if one.kind == kind] + custom_of(solids)


def pack(kind: str, solids: list[Any], emitter: Any, time: float, dtype: Any = np.float32) -> NDArray[Any]:
    """All solids of one kind, (m, columns) as in the fields of `Solids`."""
    rows = [numbers(one, solid_pose(one, emitter, time)) for one in solids if one.kind == kind]
    return np.array(rows, dtype).reshape(-1, COLUMNS[kind])


def numbers(solid: Any, pose: Pose) -> list[float]:
    """The row of one solid that has a pose."""
    row: list[float] = SHAPES[solid.kind].numbers(solid, pose)
    return row
