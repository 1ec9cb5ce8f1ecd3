"""Pairs of segments that may touch in a step, and the columns of arrays that kernels of contact between strands share.

S strands with N segments each, in the order of emission; lengths in metres. Particle 0 is the root. Pairs are those
whose boxes meet, by sweep and prune: boxes are sorted along the axis along which they spread most.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ....jit import function

Floats = NDArray[np.float64]

FIRST, FIRST_SEGMENT, SECOND, SECOND_SEGMENT = range(4)
"""Of a pair (int64): a strand and which of its segments, another (or the same) and which of its."""
ALPHA, BETA, GAP, WANTED, BEGIN, SAME, COUNTS, KEPT, YIELDING, IMPACT, URGENCY = range(11)
"""Of a contact (float64): places on both segments as shares from their beginnings; distance along the normal at the end
of the step, and the one that is wanted there; distance of the segments when the step begins; cosine between
the normal and that when the step begins; 1 where the place is nearest on both strands; the distance that
roots leave to the pair, at most the thickness; by how many times its own response it yields to its force; the share
of that which is an impact; and how many times as far its force goes in a round as the response says, 0 as 1."""
NUMBERS = 11
NORMAL, START, END = 0, 3, 6
VECTORS = 9
"""Of a contact (float64): unit normal to the second strand; vector between both places at begin and end of a step."""
LOW, HIGH = 0, 1
"""Of a box: its least and its greatest corner."""
AXES = 3
ROOM = 1.3
"""Pairs that arrays have room for, over those found the last time."""


@function
def find_pairs(boxes, order, segments, apart, pairs):
    """Set ``pairs`` (m, 4) int64 while there is room, and return how many there are: of ``boxes`` (k, 2, 3) in the
    order of their lowest place along the first axis, whose numbers are ``order``. ``segments``: of a strand; those of
    one strand count where they are further ``apart`` than so many segments."""
    count = 0
    for k in range(len(boxes)):
        for m in range(k + 1, len(boxes)):
            if boxes[m, LOW, 0] > boxes[k, HIGH, 0]:
                break
            if boxes[m, LOW, 1] > boxes[k, HIGH, 1] or boxes[k, LOW, 1] > boxes[m, HIGH, 1]:
                continue
            if boxes[m, LOW, 2] > boxes[k, HIGH, 2] or boxes[k, LOW, 2] > boxes[m, HIGH, 2]:
                continue
            i, j = min(order[k], order[m]), max(order[k], order[m])
            if i // segments == j // segments and j - i <= apart:
                continue
            if count < len(pairs):
                pairs[count, FIRST], pairs[count, FIRST_SEGMENT] = i // segments, i % segments
                pairs[count, SECOND], pairs[count, SECOND_SEGMENT] = j // segments, j % segments
            count += 1
    return count


class Nearby:
    """Finds pairs of segments whose boxes meet. ``apart``: segments of one strand count only further apart than so
    many."""

    def __init__(self, segments: int, apart: int) -> None:
        self._segments, self._apart = segments, apart
        self._pairs = np.empty((256, 4), np.int64)

    def find(self, start: Floats, end: Floats, reach: float) -> NDArray[np.int64]:
        """Return (m, 4) pairs, as `contact_pairs` has them, by strands and segments in ascending order, of segments
        of which some points come closer than ``reach`` on straight paths from ``start`` to ``end`` (S, N + 1, 3). They
        are valid until the next call."""
        boxes = _boxes(start, end, reach)
        boxes = np.roll(boxes, -int(np.argmax(np.ptp(boxes[:, LOW], axis=0))), axis=2)
        order = np.argsort(boxes[:, LOW, 0], kind="stable")
        boxes = boxes[order]
        while True:
            count = find_pairs(boxes, order, self._segments, self._apart, self._pairs)
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
    """Return (m, 2, 3) boxes that segments stay in on their paths, wider by half of a reach."""
    ends = np.stack([start[:, :-1], start[:, 1:], end[:, :-1], end[:, 1:]])
    return np.stack([ends.min(0) - reach / 2, ends.max(0) + reach / 2], 2).reshape(-1, 2, 3)
