"""The contacts of a step, as arrays."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .kernels import contact_columns as columns

THROUGH = 0.5
"""Share of their distance at the begin, or of the thickness where that is less, below which strands that a step leaves
count as having come through each other."""
ROOM = 2.0
"""Strands that a segment may have inside of it before contacts yield, each counted by how deep it is, as a share of the
thickness."""
YIELD = 1.0
"""By how many times its own response a contact yields for each strand more."""
STUCK, MOST_URGENT = 0.5, 64.0
"""Share of its excess that a round leaves of a contact from which on its force goes twice as far in the next, and how
far in the end: linear responses do not know of friction on solids, which holds tips that press each other there until
forces are greater than it. Were it to grow evenly, rounds would end before, and tips come closer from step to step."""

Floats = NDArray[np.float64]


class Contacts(NamedTuple):
    """Contacts of a step, as `contact_columns` has them; m of them."""

    pairs: NDArray[np.int64]
    """(m, 4)"""
    numbers: Floats
    """(m, `NUMBERS`)"""
    vectors: Floats
    """(m, `VECTORS`)"""

    def excess(self) -> Floats:
        """Return (m,) by how much they are closer than they should be, metres."""
        return np.asarray(self.numbers[:, columns.WANTED] - self.numbers[:, columns.GAP])

    def penetration(self, when: int = columns.GAP) -> float:
        """Return by how much strands are closer than what roots leave to them, at the most, metres: at the step's end,
        or at its ``BEGIN``."""
        return max(0.0, float((self.numbers[:, columns.KEPT] - self.numbers[:, when]).max(initial=0.0)))

    def through(self, thickness: float) -> bool:
        """Whether strands have come through each other because they are fast."""
        least = THROUGH * np.minimum(self.numbers[:, columns.BEGIN], thickness)
        ways = np.linalg.norm(
            self.vectors[:, columns.END : columns.END + 3] - self.vectors[:, columns.START : columns.START + 3], axis=1
        )
        return bool(((self.numbers[:, columns.GAP] < least) & (ways > thickness)).any())

    def update(self, start: Floats, end: Floats) -> None:
        """Set ways and distances at the same places."""
        i, a, j, b = self.pairs.T
        alpha, beta = self.numbers[:, columns.ALPHA, None], self.numbers[:, columns.BETA, None]
        for place, x in ((columns.START, start), (columns.END, end)):
            one = x[i, a] + alpha * (x[i, a + 1] - x[i, a])
            self.vectors[:, place : place + 3] = x[j, b] + beta * (x[j, b + 1] - x[j, b]) - one
        self.numbers[:, columns.GAP] = np.einsum(
            "ic,ic->i", self.vectors[:, :3], self.vectors[:, columns.END : columns.END + 3]
        )

    def urge(self, past: Floats, least: float) -> None:
        """Set how far forces go in the next round: twice as far as in the last where that has left most of the ``past``
        excess (m,), if it was more than ``least``, metres."""
        stuck = (past > least) & (self.excess() > STUCK * past) & (self.numbers[:, columns.YIELDING] == 0)
        more = np.minimum(2 * np.maximum(self.numbers[:, columns.URGENCY], 1), MOST_URGENT)
        self.numbers[:, columns.URGENCY] = np.where(stuck, more, 0)

    def yielding(self) -> bool:
        """Whether any yields to its force."""
        return bool(self.numbers[:, columns.YIELDING].any())

    def let_crowds_yield(self, thickness: float, ease: float, strands: int, segments: int) -> None:
        """Let contacts yield to their forces where more strands begin inside of each other than can be held apart:
        there are more contacts there than ways to move, and their forces would grow without limit. So that they do not
        give way step by step, they come apart by ``ease`` a step, metres, near roots too."""
        deep = np.maximum(1 - self.numbers[:, columns.BEGIN] / thickness, 0)
        one = self.pairs[:, columns.FIRST] * segments + self.pairs[:, columns.FIRST_SEGMENT]
        other = self.pairs[:, columns.SECOND] * segments + self.pairs[:, columns.SECOND_SEGMENT]
        count = strands * segments
        inside = np.bincount(one, deep, count) + np.bincount(other, deep, count)
        self.numbers[:, columns.YIELDING] = YIELD * np.maximum(np.maximum(inside[one], inside[other]) - ROOM, 0)
        eased = np.minimum(self.numbers[:, columns.KEPT], self.numbers[:, columns.BEGIN] + ease)
        self.numbers[:, columns.WANTED] = np.where(
            self.numbers[:, columns.YIELDING] > 0, eased, self.numbers[:, columns.WANTED]
        )

    def where(self, some: NDArray[np.bool_]) -> Contacts:
        """Return some of them."""
        return Contacts(self.pairs[some], self.numbers[some], self.vectors[some])


NOTHING = Contacts(np.zeros((0, 4), np.int64), np.zeros((0, columns.NUMBERS)), np.zeros((0, columns.VECTORS)))
"""No contacts."""
