"""Wisps: strands along the hairline that are too short for the tie, and stand off at their tips.

Their share is `wisps` at the hairline, and falls to 1/e over `wisp_length`. They do not hang: they are computed once,
in the emitter's frame, and move with it.
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
"""Greatest angle, radians, between the path to the tie and a wisp's direction at its root."""
BEND = 1.2
"""Greatest angle by which a wisp turns from root to tip, radians."""
OFF = 0.4
"""Greatest distance of tips from the surface as a share of the length; half of them have less than an eighth of it."""
SHORTEST = 0.4
"""Least length as a share of `wisp_length`."""

LENGTH, DIRECTION, TURN, TIP = range(4)
"""Columns of the random numbers of wisps."""


def chosen(emitter: Emitter, groom: Groom, lots: Floats) -> NDArray[np.int64]:
    """Return (K,) the numbers of the strands that are wisps; lots (strands,): uniform random numbers in [0, 1)."""
    tie, chart = emitter.tie, chart_of(emitter)
    assert tie is not None
    assert groom.grown is not None
    d, ways = chart.polar(groom.grown)
    inside = np.maximum(chart.rim(ways) - d, 0.0)
    return np.flatnonzero(lots < tie.wisps * np.exp(-inside / tie.wisp_length))


def wisps(emitter: Emitter, roots: Floats, lots: Floats, rows: int, over: Over) -> NDArray[np.float32]:
    """Return wisps with ``roots`` (K, 3): (K, rows, 3) metres in the emitter's frame, the point before the root first.
    lots (K, 4): uniform random numbers in [0, 1) for length, direction, bend and distance of the tip; over: as in
    `tie.paths`."""
    tie, chart = emitter.tie, chart_of(emitter)
    assert tie is not None
    d, ways = chart.polar(roots)
    none = np.zeros(len(roots))
    ahead = chart.point(d - 1e-4 * tie.wisp_length, ways, none)[0] - chart.point(d, ways, none)[0]
    ahead /= np.linalg.norm(ahead, axis=1)[:, None]
    normals = chart.point(d, ways, none)[1]
    aside = np.cross(normals, ahead)
    length = tie.wisp_length * (SHORTEST + (1.0 - SHORTEST) * lots[:, LENGTH])
    begin, bend = ASIDE * (2.0 * lots[:, DIRECTION] - 1.0), BEND * (2.0 * lots[:, TURN] - 1.0)
    pieces = rows - 2
    found, flat = [], roots.astype(np.float64)
    for k in range(pieces + 1):
        way = k / pieces
        bare, up = flat, normals
        if np.isfinite(chart.radius):
            up = flat / np.linalg.norm(flat, axis=1)[:, None]
            bare = chart.radius * up
        height = OFF * lots[:, TIP] ** 3 * length * way * way + over(bare, up)
        found.append(bare + height[:, None] * up)
        turn = begin + bend * (way + 0.5 / pieces)
        flat = flat + (length / pieces)[:, None] * (np.cos(turn)[:, None] * ahead + np.sin(turn)[:, None] * aside)
    return np.stack([2.0 * found[0] - found[1], *found], 1).astype(np.float32)
