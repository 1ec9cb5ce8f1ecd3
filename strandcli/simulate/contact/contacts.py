"""The contacts of a step, as arrays, and the impacts among them: of strands that meet within a step of BDF2."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...groom.blocks import lanes
from ...groom.record import Groom
from ..rod.kernels.arrays import PACK
from ..rod.kernels.begin import GAIN
from .kernels import contact_pairs as columns

THROUGH = 0.5
"""Share of their distance at the begin, at most of the thickness, below which strands have come through."""
ROOM = 2.0
"""Strands that a segment may have inside of it before contacts yield, each counted by its depth as a share."""
YIELD = 1.0
"""By how many times its own response a contact yields for each strand more."""
STUCK, MOST_URGENT = 0.5, 64.0
"""Share of its excess left in a round from which on a force doubles, for friction on solids; and how far."""
STEPS = 2
"""Steps on end in which strands that press each other may have impacts; with more, sliding gains energy."""
EXACT = 0.02
"""Share of their distance by which strands at rest on each other may begin a step too close: rounds leave that."""
TINY = 1e-30

Floats = NDArray[np.float64]


class Contacts(NamedTuple):
    """Contacts of a step, as `contact_pairs` has them; m of them."""

    pairs: NDArray[np.int64]
    """(m, 4)"""
    numbers: Floats
    """(m, `NUMBERS`)"""
    vectors: Floats
    """(m, `VECTORS`)"""

    def excess(self) -> Floats:
        """Return (m,) by how much they are closer than they should be, metres."""
        return np.asarray(self.numbers[:, columns.WANTED] - self.numbers[:, columns.GAP])

    def penetration(self) -> float:
        """Return by how much strands are closer than what roots leave to them, at the most, metres."""
        return max(0.0, float((self.numbers[:, columns.KEPT] - self.numbers[:, columns.GAP]).max(initial=0.0)))

    def through(self, thickness: float) -> bool:
        """Whether strands have come through each other because they are fast."""
        least = THROUGH * np.minimum(self.numbers[:, columns.BEGIN], thickness)
        distances = np.linalg.norm(
            self.vectors[:, columns.END : columns.END + 3] - self.vectors[:, columns.START : columns.START + 3], axis=1
        )
        return bool(((self.numbers[:, columns.GAP] < least) & (distances > thickness)).any())

    def update(self, start: Floats, end: Floats) -> None:
        """Set vectors and distances at the same places."""
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
        """Let contacts yield to their forces where more strands begin inside of each other than can be kept apart:
        there are more contacts there than directions to move in, and their forces would grow without limit. So that
        they do not yield step by step, they come apart by ``ease`` a step, metres, near roots too."""
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


class Impacts:
    """Tells the impacts among the contacts of a groom's strands with a ``thickness``, metres, and sets velocities after
    them.

    A force that enters a step of BDF2 with its h of velocities makes a velocity of 3/2 c / Δt by a displacement c,
    and BDF2 goes on with it. That is right of forces that last; from an impact strands would spring back with half
    of the velocity that they come with. So where strands have met anew, what moves a particle by c changes its
    velocity by c / Δt, and BDF2 goes on as though it had always been so much different. c is the linear response to
    the forces."""

    def __init__(self, groom: Groom, thickness: float) -> None:
        self._groom, self._thickness = groom, thickness
        self.past = np.zeros((0, 2), np.int64)
        """(k, 2) pairs of strands that pressed each other in the last step, as one number each, in ascending order, and
        in how many steps on end."""
        self._now = self.past

    def begin(self) -> None:
        """Begin a step."""
        self._now = self.past[:0]

    def shares(self, contacts: Contacts, velocities: Floats, dt: float) -> Floats:
        """Return (m,) which share of what keeps strands apart in a step of ``dt`` seconds is an impact: of what they
        come too close by, that with their ``velocities`` (S, N + 1, 3) when it begins, m/s, and what leads apart those
        that begin too close, which does not last, either."""
        i, a, j, b = contacts.pairs.T
        alpha, beta = contacts.numbers[:, columns.ALPHA, None], contacts.numbers[:, columns.BETA, None]
        one = velocities[i, a] + alpha * (velocities[i, a + 1] - velocities[i, a])
        other = velocities[j, b] + beta * (velocities[j, b + 1] - velocities[j, b])
        normals, wanted = contacts.vectors[:, columns.NORMAL : columns.NORMAL + 3], contacts.numbers[:, columns.WANTED]
        eased = wanted - np.einsum("ic,ic->i", normals, contacts.vectors[:, columns.START : columns.START + 3])
        depth = eased - dt * np.einsum("ic,ic->i", normals, other - one)
        depth = np.where(
            self._steps(self._codes(contacts)) < STEPS, depth, eased - EXACT * contacts.numbers[:, columns.KEPT]
        )
        return np.clip(depth / np.maximum(contacts.excess(), TINY), 0, 1)

    def note(self, contacts: Contacts, forces: Floats) -> None:
        """Take the forces (m, 3) of a round."""
        codes = np.unique(self._codes(contacts)[forces.any(1)])
        self._now = np.stack([codes, self._steps(codes) + 1], 1)

    def finish(self, solver: Any, moves: Floats, dt: float) -> None:
        """Set velocities of a ``solver`` at the end of a step of ``dt`` seconds, in which impacts have moved particles
        by ``moves`` (S, N, 3) metres."""
        self.past = self._now
        state = solver.state
        if not (solver.now.bdf2 and moves.any()):  # Euler's method makes c / Δt of itself
            return
        rate, own = 1.5 / dt, 1 / dt
        rows = self._groom.placed(moves)
        c = np.stack([lanes(rows[:, j], np.float64, PACK) for j in range(rows.shape[1])], 1)
        # forces that no step can carry would by a linear response move without limit; before: when the step began
        most = _greatest(state.moved) + dt * _greatest(state.before) + self._thickness
        c *= np.tile(np.minimum(1, most / np.maximum(_greatest(c), TINY)), 3)[:, None]
        c[state.before == state.velocity] = 0  # with what has met a solid BDF2 starts anew from u / Δt
        shares = (state.before, own), (state.velocity, own - rate), (state.ahead, own - rate - rate * GAIN)
        for one, share in shares:
            one += (share * c).astype(one.dtype)

    def _codes(self, contacts: Contacts) -> NDArray[np.int64]:
        return np.asarray(contacts.pairs[:, columns.FIRST] * self._groom.strands + contacts.pairs[:, columns.SECOND])

    def _steps(self, codes: NDArray[np.int64]) -> NDArray[np.int64]:
        """Return in how many steps on end pairs of strands have pressed each other."""
        if len(self.past) == 0:
            return np.zeros(len(codes), np.int64)
        at = np.minimum(np.searchsorted(self.past[:, 0], codes), len(self.past) - 1)
        return np.where(self.past[at, 0] == codes, self.past[at, 1], 0)


def _greatest(rows: NDArray[Any]) -> Floats:
    """Return (P, S) the length of the longest vector of each strand's, (P, N, 3 S)."""
    squares = (rows.reshape(*rows.shape[:2], 3, PACK).astype(np.float64) ** 2).sum(2)
    return np.asarray(np.sqrt(squares.max(1)))
