"""Where strands of a file are put: upright, in metres, where the scene wants them."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..errors import UsageError
from ..exchange.edits import turned
from ..exchange.strands import CACHED, Strands
from .fits import hangs_from
from .measure import box_of

if TYPE_CHECKING:
    from ..scene.model import GroomFile

UP = "y"
"""The up axis of scenes."""


class Placement(NamedTuple):
    """Where strands of a file are put: their up axis, metres a unit, and what is the origin then (3,), metres."""

    up: str
    factor: float
    middle: NDArray[np.float64]


def placed(
    strands: Strands, given: GroomFile, notes: list[str], placement: Placement | None = None
) -> tuple[Strands, Placement]:  # fmt: skip
    """Strands where a scene wants them, and where that is; ``placement``: if it
    is known."""
    if placement is not None:
        return put(strands, given, placement), placement
    up = _up_axis(strands, given, notes)
    strands = _upright(strands, up)
    placement = Placement(up, *_scale(strands, given))
    return _moved(strands, given, placement), placement


def _up_axis(strands: Strands, given: GroomFile, notes: list[str]) -> str:
    """The up axis of a file: as the scene or the file says, or a guess."""
    if given.up != "auto":
        return given.up
    up = strands.source.up or UP
    guess = None if strands.source.up else hangs_from(strands)
    if guess is not None and guess != up:
        up = guess
        notes.append(f"{given.file}: up is taken to be {up}, which becomes y; emitter.groom.up says otherwise")
    return up


def _upright(strands: Strands, up: str) -> Strands:
    """Strands whose up axis is y."""
    return strands if up == UP else turned(strands, up, UP)[0]


def put(strands: Strands, given: GroomFile, placement: Placement) -> Strands:
    """Strands of a file where others of it are."""
    return _moved(_upright(strands, placement.up), given, placement)


def _scale(strands: Strands, given: GroomFile) -> tuple[float, NDArray[np.float64]]:
    """Metres of a unit of strands whose up axis is y, and what becomes the origin (3,), metres."""
    factor, middle = strands.source.unit or 1.0 if given.scale is None else given.scale, np.zeros(3)
    if given.size is not None or given.place != "file":
        low, high = box_of(strands.points)
        if given.size is not None:
            factor = given.size / float((high - low).max())
        if given.place != "file":
            middle = 0.5 * factor * (low + high)
            if given.place == "ground":
                middle[1] = factor * low[1]
    return factor, middle


def _moved(strands: Strands, given: GroomFile, placement: Placement) -> Strands:
    """Upright strands in metres, where the scene wants them. Raises `UsageError` where single precision ends before
    that."""
    factor, middle = placement.factor, placement.middle
    if factor == 1 and not middle.any():
        return strands
    moved = np.empty_like(strands.points)
    wide = np.empty((CACHED, 3))
    with np.errstate(over="ignore"):
        for begin in range(0, moved.shape[0], CACHED):
            held = strands.points[begin : begin + CACHED]
            part = np.multiply(held, factor, out=wide[: held.shape[0]], dtype=np.float64)
            part -= middle
            moved[begin : begin + CACHED] = part
    if not np.isfinite(box_of(moved)).all():
        raise UsageError(f"{given.file}: points are too far out for single precision; set emitter.groom.scale or size")
    return replace(strands, points=moved)
