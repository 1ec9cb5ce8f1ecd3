"""Where strands of a file are put: upright, in metres, where the scene wants them."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..errors import UsageError
from ..exchange.edits import turned
from ..exchange.strands import CACHED, Strands
from ..mesh_file.read import UP, standing
from .fits import hangs_from
from .measure import box_of

if TYPE_CHECKING:
    from ..scene.model import GroomFile


class Placement(NamedTuple):
    """Where strands of a file are put: their up axis, metres a unit, and their shift then (3,), metres."""

    up: str
    factor: float
    shift: NDArray[np.float64]


def placement_of(strands: Strands, given: GroomFile, notes: list[str]) -> Placement:
    """Where a scene wants the strands of a file: its up axis is as the scene or the file says, or a guess."""
    up = given.up
    if up == "auto":
        up = strands.source.up or UP
        guess = None if strands.source.up else hangs_from(strands)
        if guess is not None and guess != up:
            up = guess
            notes.append(f"{given.file}: up is taken to be {up}, which becomes y; emitter.groom.up says otherwise")
    scale = strands.source.unit or 1.0 if given.scale is None else given.scale
    return Placement(up, *standing(box_of(strands.points), up, scale, given.size, given.place))


def put(strands: Strands, given: GroomFile, placement: Placement) -> Strands:
    """Strands of a file in metres, y up, where the scene wants them. Raises `UsageError` where single precision ends
    before that."""
    strands = strands if placement.up == UP else turned(strands, placement.up, UP)[0]
    if placement.factor == 1 and not placement.shift.any():
        return strands
    moved = np.empty_like(strands.points)
    wide = np.empty((CACHED, 3))
    with np.errstate(over="ignore"):
        for begin in range(0, moved.shape[0], CACHED):
            some = strands.points[begin : begin + CACHED]
            part = np.multiply(some, placement.factor, out=wide[: some.shape[0]], dtype=np.float64)
            part += placement.shift
            moved[begin : begin + CACHED] = part
    if not np.isfinite(box_of(moved)).all():
        raise UsageError(f"{given.file}: points are too far out for single precision; set emitter.groom.scale or size")
    return replace(strands, points=moved)
