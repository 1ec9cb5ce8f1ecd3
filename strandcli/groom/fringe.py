"""Hair where hair begins: children that grow at the hairline and along the parting, beyond those that grow anywhere.

Strands lie over those that grow behind them, so that it takes a while from an edge inward until they cover the skin:
with ρ roots a square metre and strands w wide, 1 / (ρ w) metres. A head has ten times the hairs that are drawn of it,
each a third as wide, and covers its skin three times as soon. So some of the children move there, as thick at an edge
as hair is, and 1/e of that `within` metres inside.
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
"""First of the random streams that are used here."""
BEHIND = -0.15
"""Radians ahead of the crown at which partings end."""


def lengths(fringe: Fringe, seed: int, count: int, guides: int) -> NDArray[np.float64]:
    """(count,) of each child its length as a share of what it would have without a fringe."""
    shorter = 1.0 - (1.0 - fringe.length) * stream(seed, RANDOM + 1, count)
    return np.where(_chosen(fringe, seed, count, guides), shorter, 1.0)


def roots(fringe: Fringe, emitter: Emitter, seed: int, places: NDArray[np.float64], guides: int) -> NDArray[np.float64]:
    """Where children grow, (N, 3) metres, that would at ``places`` (N, 3), of which the first so many are guides, which
    stay. Those of the fringe are dealt out to hairline and parting by how long these are."""
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
        both = 2.0 * math.cos(line) * max(math.radians(shape.cap) - BEHIND, 0.0)  # it has two sides
        found = np.where((which * (edge + both) < both)[:, None], by_parting, found)
    return np.where(_chosen(fringe, seed, count, guides)[:, None], shape.radius * found, places)


def _chosen(fringe: Fringe, seed: int, count: int, guides: int) -> NDArray[np.bool_]:
    """(count,) which children belong to it."""
    return np.asarray((stream(seed, RANDOM, count) < fringe.share) & (np.arange(count) >= guides))
