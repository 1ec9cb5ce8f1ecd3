"""Distance between neighbouring strands, estimated from their local density.

The density of roots does not tell it: a ponytail is bound, locks clump, and hair spreads in the wind.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ...constants import W
from ...groom.emit import PLASTIC
from .extent import Extents, extents_of
from .kernels import spacing as kernel

NEIGHBOURS = 8
"""Nearest strands from which the density at a point is estimated."""
POINTS = 32
"""Points of a groom at which the distance is measured."""
MEASURED_STRANDS = 256
"""Strands on which these points lie, the first that an emitter makes: the points are the same in every frame, however
many strands level of detail draws."""


def spacing_at(
    positions: NDArray[np.float32], strands: int, points: NDArray[np.float32], own: NDArray[np.int64],
    extents: Extents | None = None,
) -> NDArray[np.float64]:  # fmt: skip
    """Return the distance between strands, metres, at points (P, 3) on the strands with the numbers ``own`` (P,); 0 if
    there is one strand.

    It is the side of the square of cross section that a strand has, if the `NEIGHBOURS` nearest ones are evenly
    distributed. positions (blocks, n + 1, 3 W), metres, of which the first ``strands`` count; ``extents``: from
    `extents_of`, if they are known.
    """
    neighbours = min(NEIGHBOURS, strands - 1)
    if neighbours < 1:
        return np.zeros(len(points))
    away = np.empty((len(points), neighbours), np.float32)
    kernel.nearest(positions, strands, *(extents or extents_of(positions)), points, own, away)
    return math.sqrt(math.pi / neighbours) * away[:, -1].astype(np.float64)


def spacing_of(
    positions: NDArray[np.float32], strands: int, among: NDArray[np.integer] | None = None,
    extents: Extents | None = None,
) -> float:  # fmt: skip
    """Return the distance between strands of a groom, metres: the median of `spacing_at` at `POINTS` points.

    The points are evenly distributed along and over the strands, or those that ``among`` says. ``extents``: as
    in `spacing_at`.
    """
    own = measured(strands) if among is None else among[measured(len(among))].astype(np.int64)
    rows = 1 + (_even()[:, 1] * (positions.shape[1] - 1)).astype(np.int64)
    points = positions.reshape(*positions.shape[:2], 3, W)[own // W, rows, :, own % W]
    return float(np.median(spacing_at(positions, strands, np.ascontiguousarray(points), own, extents)))


def measured(strands: int) -> NDArray[np.int64]:
    """Return on which of so many strands each of the `POINTS` points lies."""
    return np.asarray(_even()[:, 0] * strands, np.int64)


def _even() -> NDArray[np.float64]:
    """(`POINTS`, 2) points that are evenly distributed in the unit square."""
    return np.asarray((0.5 + np.arange(POINTS)[:, None] * np.array([1 / PLASTIC, 1 / PLASTIC**2])) % 1.0)


def first_emitted(strands: int, ids: NDArray[np.int32] | None) -> NDArray[np.int64]:
    """Return where the first `MEASURED_STRANDS` of so many strands are, the first emitted first.

    ``ids`` (strands,): numbers in the order of emission, of which any prefix is evenly distributed; None: 0, 1, …
    """
    many = min(MEASURED_STRANDS, strands)
    if ids is None:
        return np.arange(many)
    first = np.flatnonzero(ids < many)
    if len(first) < many:  # some of the first are not drawn
        first = np.argpartition(ids, many - 1)[:many]
    return np.asarray(first[np.argsort(ids[first])])
