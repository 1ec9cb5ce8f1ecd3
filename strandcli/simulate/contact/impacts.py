"""Impacts: what strands that meet within a step of BDF2 do to each other's velocities.

A force that enters a step of BDF2 with its h of velocities, as gravity does, makes a velocity of 3/2 c / Δt by a
displacement c, and BDF2 goes on with it. That is right of forces that last; from an impact strands would spring back
with half of the velocity that they come with. So where strands have met anew, what moves a particle by c because they
came toward each other when the step began changes its velocity by c / Δt, and BDF2 goes on as though it had always been
so much different. By Euler's method the whole strands would lose of their swing. c is the linear response to the
forces; positions of the step do not depend on it.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...groom.blocks import lanes
from ...groom.record import Groom
from ..rod.kernels.arrays import PACK
from ..rod.kernels.begin import GAIN
from .contacts import Contacts
from .kernels.contact_columns import ALPHA, BETA, FIRST, KEPT, NORMAL, SECOND, START, WANTED

STEPS = 2
"""Steps on end in which strands that press each other may have impacts: after the first they still come toward each
other. With three or more, strands that slide along each other gain energy."""
EXACT = 0.02
"""Share of their distance by which strands at rest on each other may begin a step too close: rounds leave that."""
TINY = 1e-30

Floats = NDArray[np.float64]


class Impacts:
    """Tells the impacts among the contacts of a groom's strands with a ``thickness``, metres, and sets velocities after
    them."""

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
        alpha, beta = contacts.numbers[:, ALPHA, None], contacts.numbers[:, BETA, None]
        one = velocities[i, a] + alpha * (velocities[i, a + 1] - velocities[i, a])
        other = velocities[j, b] + beta * (velocities[j, b + 1] - velocities[j, b])
        normals, wanted = contacts.vectors[:, NORMAL : NORMAL + 3], contacts.numbers[:, WANTED]
        eased = wanted - np.einsum("ic,ic->i", normals, contacts.vectors[:, START : START + 3])
        depth = eased - dt * np.einsum("ic,ic->i", normals, other - one)
        depth = np.where(self._steps(self._codes(contacts)) < STEPS, depth, eased - EXACT * contacts.numbers[:, KEPT])
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
        return np.asarray(contacts.pairs[:, FIRST] * self._groom.strands + contacts.pairs[:, SECOND])

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
