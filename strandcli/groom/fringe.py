"""Fringe: additional children at the hairline and along the parting.

Strands lie over those behind them, so it takes a distance from an edge inward until they cover the skin: 1 / (ρ w)
metres with ρ roots a square metre and strands of width w. A head has ten times as many hairs as are drawn, each a third
as wide, so its skin is covered in a third of the distance. Therefore some children are moved to the edges; their
density falls to 1/e `within` metres from an edge.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..scene.model import SphereShape
from .emit import rim, stream

if TYPE_CHECKING:
    from ..scene.model import Emitter, Fringe

RANDOM = 200
"""Number of the first random stream that is used here."""
BEHIND = -0.15
"""Angle from the crown toward the front, radians, at which partings end."""


def lengths(fringe: Fringe, seed: int, count: int, guides: int) -> NDArray[np.float64]:
    """Return (count,) the factor of each child's length."""
    shorter = 1.0 - (1.0 - fringe.length) * stream(seed, RANDOM + 1, count)
    return np.where(_chosen(fringe, seed, count, guides), shorter, 1.0)


def roots(fringe: Fringe, emitter: Emitter, seed: int, places: NDArray[np.float64], guides: int) -> NDArray[np.float64]:
    """Return the roots of children (N, 3), metres, which without a fringe would be at ``places`` (N, 3); the first
    ``guides`` stay. Those of the fringe are divided between hairline and parting in proportion to their lengths."""
    shape, count = emitter.shape, len(places)
    assert isinstance(shape, SphereShape)
    deep = -fringe.within / shape.radius * np.log1p(-stream(seed, RANDOM + 2, count))
    which, along = stream(seed, RANDOM + 3, count), stream(seed, RANDOM + 4, count)
    edge = 2 * math.pi * math.sin(math.radians(shape.cap)) if shape.cap < 180 else 0.0
    turn = np.arctan2(places[:, 2], places[:, 0])
    polar = np.maximum(np.radians(rim(shape, turn / (2 * math.pi) % 1.0, seed)) - deep, 0.0)
    found = np.stack([np.sin(polar) * np.cos(turn), np.cos(polar), np.sin(polar) * np.sin(turn)], 1)
    if emitter.parting is not None:
        line = math.asin(min(max(emitter.parting / shape.radius, -1.0), 1.0))
        side = np.clip(line + deep * np.where(which < 0.5, -1.0, 1.0), -0.5 * math.pi, 0.5 * math.pi)
        which = 2.0 * which % 1.0
        lowest = np.cos(np.radians(rim(shape, (0.25 - side / (2 * math.pi)) % 1.0, seed)))
        front = np.arccos(np.clip(lowest / np.maximum(np.cos(side), 1e-9), -1.0, 1.0))
        ahead = BEHIND + np.maximum(front - BEHIND, 0.0) * along
        by_parting = np.stack([np.sin(side), np.cos(side) * np.cos(ahead), np.cos(side) * np.sin(ahead)], 1)
        both = 2.0 * math.cos(line) * max(math.radians(shape.cap) - BEHIND, 0.0)  # a parting has two sides
        found = np.where((which * (edge + both) < both)[:, None], by_parting, found)
    return np.where(_chosen(fringe, seed, count, guides)[:, None], shape.radius * found, places)


def _chosen(fringe: Fringe, seed: int, count: int, guides: int) -> NDArray[np.bool_]:
    """Return (count,) whether children belong to the fringe."""
    return np.asarray((stream(seed, RANDOM, count) < fringe.share) & (np.arange(count) >= guides))
