"""Hair along the hairline that is too short for the tie: wisps that lie about as it grew, and stand off at their tips.

At the rim of what bears roots their share is `wisps`, and it falls to 1/e over `wisp_length`. They do not hang: they
are worked out once, in the emitter's frame, and are carried along with it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from .tie import Floats, Over, chart_of

if TYPE_CHECKING:
    from ..scene.model import Emitter
    from .record import Groom

ASIDE = 0.7
"""Radians from the way to the tie, to either side, in which wisps begin at the most,"""
BEND = 1.2
"""by which they turn from root to tip,"""
OFF = 0.4
"""and share of their length by which their tips stand off; half of them by less than an eighth of it."""
SHORTEST = 0.4
"""Of `wisp_length`."""


def chosen(emitter: Emitter, groom: Groom, lots: Floats) -> NDArray[np.int64]:
    """(K,) which strands are wisps, by even ``lots`` (strands,) in [0, 1)."""
    tie, chart = emitter.tie, chart_of(emitter)
    assert tie is not None
    assert groom.grown is not None
    d, ways = chart.polar(groom.grown)
    inside = np.maximum(chart.rim(ways) - d, 0.0)
    return np.flatnonzero(lots < tie.wisps * np.exp(-inside / tie.wisp_length))


def wisps(emitter: Emitter, roots: Floats, lots: Floats, rows: int, over: Over) -> NDArray[np.float32]:
    """Wisps that grow at ``roots`` (K, 3), evenly in so many rows, the one before the root first: (K, rows, 3) metres
    in the emitter's frame. ``lots`` (K, 4), even in [0, 1), tell their length, way, bend and how far they stand off;
    ``over`` as in `tie.paths`."""
    tie, chart = emitter.tie, chart_of(emitter)
    assert tie is not None
    d, ways = chart.polar(roots)
    none = np.zeros(len(roots))
    ahead = chart.point(d - 1e-4 * tie.wisp_length, ways, none)[0] - chart.point(d, ways, none)[0]
    ahead /= np.linalg.norm(ahead, axis=1)[:, None]
    normals = chart.point(d, ways, none)[1]
    aside = np.cross(normals, ahead)
    length = tie.wisp_length * (SHORTEST + (1.0 - SHORTEST) * lots[:, 0])
    begin, bend = ASIDE * (2.0 * lots[:, 1] - 1.0), BEND * (2.0 * lots[:, 2] - 1.0)
    pieces = rows - 2
    found, flat = [], roots.astype(np.float64)
    for k in range(pieces + 1):
        way = k / pieces
        bare, up = flat, normals
        if np.isfinite(chart.radius):
            up = flat / np.linalg.norm(flat, axis=1)[:, None]
            bare = chart.radius * up
        height = OFF * lots[:, 3] ** 3 * length * way * way + over(bare, up)
        found.append(bare + height[:, None] * up)
        turn = begin + bend * (way + 0.5 / pieces)
        flat = flat + (length / pieces)[:, None] * (np.cos(turn)[:, None] * ahead + np.sin(turn)[:, None] * aside)
    return np.stack([2.0 * found[0] - found[1], *found], 1).astype(np.float32)
