"""Pairs of segments that may touch in a step: the uniform grid of `kernels.contact_pairs`, its arrays and its cells."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .kernels.contact_columns import FIRST, FIRST_SEGMENT, SECOND, SECOND_SEGMENT

MOST_ENTRIES = 16
"""Cells a box lies in at the most, as a mean: larger cells are taken otherwise."""
ROOM = 1.3
"""Pairs that arrays have room for, over those found the last time."""

Floats = NDArray[np.float64]


class Nearby:
    """Finds pairs of segments whose boxes meet. ``apart``: segments of one strand count only further apart than so
    many."""

    def __init__(self, segments: int, apart: int) -> None:
        self._segments, self._apart = segments, apart
        self._pairs = np.empty((256, 4), np.int64)

    def find(self, start: Floats, end: Floats, reach: float) -> NDArray[np.int64]:
        """Return (m, 4) pairs, as `contact_columns` has them, by strands and segments in ascending order, of segments
        of which some points come closer than ``reach`` on straight ways from ``start`` to ``end`` (S, N + 1, 3). They
        are valid until the next call."""
        from .kernels import contact_pairs  # which `plan` does without, where it counts cells

        boxes = _boxes(start, end, reach)
        side = cell_side(boxes[:, :3], boxes[:, 3:])
        buckets = 1 << max(4, int(len(boxes) * 4).bit_length())
        starts = np.zeros(buckets + 2, np.int64)
        contact_pairs.fill_cells(boxes, side, starts, None, None)
        np.cumsum(starts, out=starts)
        entries, cells = np.empty(starts[-1], np.int64), np.empty((starts[-1], 3), np.int64)
        contact_pairs.fill_cells(boxes, side, starts, entries, cells)
        while True:
            table = starts, entries, cells
            count = contact_pairs.find_pairs(boxes, self._segments, self._apart, side, table, self._pairs)
            if count <= len(self._pairs):
                break
            self._pairs = np.empty((int(count * ROOM), 4), np.int64)
        return self._in_order(self._pairs[:count], len(boxes))

    def _in_order(self, pairs: NDArray[np.int64], total: int) -> NDArray[np.int64]:
        """Sort pairs of so many segments in place, by one number for each: there may be millions."""
        codes = pairs[:, FIRST] * self._segments + pairs[:, FIRST_SEGMENT]
        codes *= total
        codes += pairs[:, SECOND] * self._segments
        codes += pairs[:, SECOND_SEGMENT]
        codes.sort()
        firsts = codes // total
        codes %= total
        for strand, segment, number in ((FIRST, FIRST_SEGMENT, firsts), (SECOND, SECOND_SEGMENT, codes)):
            np.floor_divide(number, self._segments, out=pairs[:, strand])
            np.remainder(number, self._segments, out=pairs[:, segment])
        return pairs


def _boxes(start: Floats, end: Floats, reach: float) -> Floats:
    """Return (m, 6) boxes that segments stay in on their ways, wider by half of a reach."""
    ends = np.stack([start[:, :-1], start[:, 1:], end[:, :-1], end[:, 1:]])
    return np.concatenate([ends.min(0) - reach / 2, ends.max(0) + reach / 2], -1).reshape(-1, 6)


def cell_side(low: Floats, high: Floats) -> float:
    """Return the side of cells for boxes with such corners (m, 3), metres."""
    side = float((high - low).mean() * 1.5)
    while (np.floor(high / side) - np.floor(low / side) + 1).prod(1).mean() > MOST_ENTRIES:
        side *= 1.5
    return side
