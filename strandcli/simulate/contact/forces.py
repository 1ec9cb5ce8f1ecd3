"""Forces of contact within a step: each strand's response to them, and the solve."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ...blocks import lanes
from ...groom.record import Groom
from ..kernels.records import DAMPING, STEP, State
from ..kernels.rod_scratch import PACK
from .kernels import contact_response, contact_solve
from .kernels.contact_columns import ALPHA, BETA, FIRST, FIRST_SEGMENT, SECOND, SECOND_SEGMENT
from .kernels.contact_response import BAND, BLOCK

if TYPE_CHECKING:
    from .contacts import Contacts

SWEEPS, LEAST_SWEEPS, UPDATES = 200, 30, 100_000
"""Sweeps of a contact solve at the most: the first where contacts are few, the second at the least, and else as many as
make so many updates of a contact."""
CROWD_SWEEPS = 10
"""The same where contacts yield: more change nothing."""
PRECISION = 1e-4
"""Of ways in the contact solve, over the thickness."""
TRUST = 3.0
"""Greatest displacement that a round is trusted with, over the thickness or what strands are too close by, whichever
is greater."""
TINY = 1e-30
IMMOBILE = 1e-9
"""Response, over that of a free particle, below which a contact cannot move anything."""

Floats = NDArray[np.float64]


class Forces:
    """Forces between the strands of a groom whose segments have ``lengths`` (S,), metres, ``segments`` a strand."""

    def __init__(self, groom: Groom, lengths: Floats, segments: int, thickness: float, friction: float) -> None:
        self.groom, self.lengths, self.segments = groom, lengths, segments
        self.thickness, self.friction = thickness, friction

    def solve(self, found: Contacts, forces: Floats, solver: Any) -> float:
        """Change ``forces`` (m, 3) so that contacts hold; return by how much particles move by that, metres."""
        n = self.segments
        responses, own = np.empty((len(forces), 2, n, 3, 3)), np.empty((len(forces), 3, 3))
        strands = np.unique(found.pairs[:, [FIRST, SECOND]])
        places = np.zeros(len(self.lengths), np.int64)
        places[strands] = np.arange(len(strands))
        bands = self._factors(strands, solver)
        contact_response.respond(
            found.pairs, found.numbers, bands, places, self.lengths, responses, np.empty((BLOCK * n, 3))
        )
        contact_solve.own_responses(found.pairs, found.numbers, responses, own)
        moves, after = np.zeros((len(self.lengths), n, 3)), forces.copy()
        sweeps = min(SWEEPS, max(LEAST_SWEEPS, UPDATES // len(forces)))
        if found.yielding():
            sweeps = CROWD_SWEEPS
        settings = self.friction, sweeps, PRECISION * self.thickness, IMMOBILE / float(self.lengths.max())
        contacts, rows = (found.numbers, found.vectors), np.zeros((7, 3))
        contact_solve.solve(found.pairs, contacts, (responses, own), settings, after, moves, rows)
        moved = float(np.abs(moves).max())
        share = min(1.0, TRUST * max(float(found.excess().max()), self.thickness) / max(moved, TINY))
        forces += share * (after - forces)
        return moved

    def _factors(self, strands: NDArray[np.int64], solver: Any) -> Floats:
        """Return the factors of some strands' responses."""
        material, numbers = solver.material, solver.forcing.numbers
        h, state = float(numbers[STEP]), solver.state
        stiffness = self.emitted(material.stiffness[:, None])[:, 0, 0] * h * h * (1 + float(numbers[DAMPING]) / h)
        tension = self.emitted(state.tension)[:, :, 0] * h * h
        bands = np.empty((len(strands), BLOCK * self.segments, BAND))
        mass, joint = material.mass.astype(np.float64), material.joint.astype(np.float64)
        loads = stiffness, tension, self._held(state)
        contact_response.factorise(strands, self.emitted(state.edges), loads, mass, joint, bands)
        return bands

    def load(self, found: Contacts, forces: Floats, solver: Any) -> None:
        """Add the accelerations of particles by the forces of contacts to those by the strands around."""
        count, n = len(self.lengths), self.segments
        added = np.zeros((count * (n + 1), 3))
        alpha, beta = found.numbers[:, ALPHA, None], found.numbers[:, BETA, None]
        for strand, segment, share, force in (
            (found.pairs[:, FIRST], found.pairs[:, FIRST_SEGMENT], alpha, -forces),
            (found.pairs[:, SECOND], found.pairs[:, SECOND_SEGMENT], beta, forces),
        ):
            at = strand * (n + 1) + segment
            for place, part in ((at, (1 - share) * force), (at + 1, share * force)):
                for c in range(3):
                    added[:, c] += np.bincount(place, part[:, c], len(added))
        h = float(solver.forcing.numbers[STEP])
        rows = added.reshape(count, n + 1, 3)[:, 1:]
        rows = rows / (self.lengths[:, None, None] * solver.mass.astype(np.float64)[:, None] * h * h)
        crowd, rows = solver.state.crowd, self.groom.placed(rows)
        for j in range(n):
            crowd[:, j] += lanes(rows[:, j], crowd.dtype, PACK)

    def _held(self, state: State) -> Floats:
        """Return (S, N, 3) the unit normals of solids that particles touch, or 0."""
        if len(state.push) != len(state.edges):
            return np.zeros((len(self.lengths), self.segments, 3))
        push = self.emitted(state.push)
        size = np.linalg.norm(push, axis=2, keepdims=True)
        return np.asarray(push / np.where(size > 0, size, 1))

    def emitted(self, rows: NDArray[Any], width: int = PACK) -> Floats:
        """Return (S, rows, columns) of values in packs or blocks of a ``width``, in the order of emission."""
        wide = rows.reshape(*rows.shape[:2], -1, width).transpose(0, 3, 1, 2).astype(np.float64)
        return np.ascontiguousarray(self.groom.emitted(wide.reshape(-1, *wide.shape[2:])[: len(self.lengths)]))
