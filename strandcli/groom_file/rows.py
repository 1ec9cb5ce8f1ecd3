"""Strands of a file in blocks of lanes, all with as many points: shorter ones get points on their segments."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..constants import W
from ..exchange.resample import resampled
from ..exchange.strands import CACHED, Offsets, Points, Strands
from ..groom.blocks import aligned
from .kernels import rows as kernel

PADDED = 2
"""Points that all strands together may have in memory, over those of the file, where they are more than `ENOUGH`."""
ENOUGH = 1 << 24
Rows = NDArray[np.signedinteger[Any]]
"""Numbers of rows, in 16 bits where these are enough."""


def most_points(strands: Strands) -> int:
    """Points that all strands get, and the lanes that fill their last block: as many as the longest has, or fewer
    where that and the row before the root would take too much memory."""
    lanes = -(-strands.count // W) * W
    longest = int(strands.counts(np.int32).max())
    return max(min(longest, max(PADDED * strands.points.shape[0] - lanes, ENOUGH) // lanes), 2)


def with_at_most(strands: Strands, most: int) -> tuple[Strands, float]:
    """Strands of at most so many points each: where one has more, all get that many at equal distances along them, and
    the attributes of points go with these. Returns how far they are off at most, too."""
    if strands.counts(np.int32).max() <= most:
        return strands, 0.0
    found, change = resampled(strands, most)
    return found, float(change.facts["deviation_max"])


def rows_in(first: Offsets, points: Points, most: int) -> Rows | None:
    """(P,) the rows that points of strands get where all have ``most``; None where all do. After point j of n the share
    of its arc length of the rows that are added has been placed, rounded."""
    if (np.diff(first) == most).all():
        return None
    found: Rows = np.empty(points.shape[0], np.int16 if most <= np.iinfo(np.int16).max else np.int32)
    kernel.place(first, points, most, found)
    return found


def packed(
    first: Offsets, points: Points, rows: Rows | None, order: NDArray[np.int32], most: int
) -> NDArray[np.float32]:
    """(blocks, most + 1, 3 W): strands in an ``order`` (S,), row 0 a segment before the root, as `groom.blocks` has
    it. Points have the ``rows`` of `rows_in`, in every bit; those between are on the straight segments."""
    strands = order.shape[0]
    blocks = -(-strands // W)
    out = aligned((blocks, most + 1, 3 * W))
    kernel.pack(first, points, rows, order, out)
    return out


def points_in(blocks: NDArray[np.float32], strands: int, rows: Rows | int) -> Points:
    """(S, 3): of each strand of `packed` ones the point in a row, or in one of its own (S,)."""
    wide = blocks.reshape(*blocks.shape[:2], 3, W)
    found, own = np.empty((strands, 3), np.float32), np.broadcast_to(rows, strands)
    for begin in range(0, strands, CACHED):
        here = np.arange(begin, min(begin + CACHED, strands))
        found[begin : begin + CACHED] = wide[here // W, 1 + own[begin : begin + CACHED], :, here % W]
    return found


def values_in(
    first: Offsets, values: NDArray[np.float32], rows: Rows | None, order: NDArray[np.int32], most: int
) -> NDArray[np.float32]:
    """(S, most): values (P,) of the points of strands in an ``order`` (S,), at the points that `packed` gives them."""
    if rows is None:
        return values.reshape(-1, most)[order].astype(np.float32, copy=False)
    out = np.empty((order.shape[0], most), np.float32)
    kernel.spread(first, values[:, None], rows, order, out)
    return out
