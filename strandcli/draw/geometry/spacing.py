"""Distance between neighbouring strands, estimated from their local density. The density of roots would not do: a
ponytail is bound, locks clump, and hair spreads in the wind."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ...constants import W
from ...groom.emit import PLASTIC
from .kernels import spacing as kernel

NEIGHBOURS = 8
PLACES = 32
"""Points of a groom at which the distance is measured."""
STEADY = 256
"""Number of strands that are measured if they are in the order of emission, whose first ones are spread
evenly: the same in every frame, however many strands level of detail keeps."""


def spacing_at(
    positions: NDArray[np.float32], strands: int, points: NDArray[np.float32], own: NDArray[np.int64]
) -> NDArray[np.float64]:
    """Metres between strands at points (P, 3) on the strands ``own`` (P,): the side of the square that each has for
    itself across its length, were the eighth nearest neighbours evenly about; 0 for a single strand.

    positions: (blocks, n + 1, 3 W), of which the first ``strands`` count.
    """
    neighbours = min(NEIGHBOURS, strands - 1)
    if neighbours < 1:
        return np.zeros(len(points))
    away = np.empty((len(points), neighbours), np.float32)
    kernel.nearest(positions, strands, points, own, away)
    return math.sqrt(math.pi / neighbours) * away[:, -1].astype(np.float64)


def spacing_of(positions: NDArray[np.float32], strands: int, asked: int | None = None) -> float:
    """The same of a groom: the median of some places that are spread evenly over its strands, or the first ``asked`` of
    them, and along them."""
    turns = (0.5 + np.arange(PLACES)[:, None] * np.array([1 / PLASTIC, 1 / PLASTIC**2])) % 1.0
    own = (turns[:, 0] * (strands if asked is None else min(asked, strands))).astype(np.int64)
    rows = 1 + (turns[:, 1] * (positions.shape[1] - 1)).astype(np.int64)
    points = positions.reshape(*positions.shape[:2], 3, W)[own // W, rows, :, own % W]
    return float(np.median(spacing_at(positions, strands, np.ascontiguousarray(points), own)))
