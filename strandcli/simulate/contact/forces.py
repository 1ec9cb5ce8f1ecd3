"""Forces of contact within a step: each strand's response to them, and the solve."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...groom.blocks import lanes
from ...groom.record import Groom
from ..rod.kernels.arrays import PACK, State
from ..rod.kernels.begin import VELOCITY_RATE
from .kernels import contact_response, contact_solve
from .kernels.contact_pairs import ALPHA, BETA, FIRST, FIRST_SEGMENT, IMPACT, NORMAL, SECOND, SECOND_SEGMENT, URGENCY
from .kernels.contact_response import BAND, BLOCK

if TYPE_CHECKING:
    from .contacts import Contacts

SWEEPS, LEAST_SWEEPS, UPDATES = 200, 30, 100_000
"""Sweeps of a contact solve at the most and at the least; between them as many as make so many updates."""
CROWD_SWEEPS = 10
"""The same where contacts yield: more change nothing."""
PRECISION = 1e-4
"""Of displacements in the contact solve, over the thickness."""
TRUST = 3.0
"""Greatest displacement that a round is trusted with, over the thickness or the greatest excess."""
TINY = 1e-30
IMMOBILE = 1e-9
"""Response, over that of a free particle, below which a contact cannot move anything."""

Floats = NDArray[np.float64]


class Method(NamedTuple):
    """How strands take a step, each by BDF2 or by Euler's method."""

    euler: NDArray[np.bool_]
    """(S,) which go by Euler's method though the rest may go by BDF2."""
    square: Floats
    """(S,) h² by which forces enter it, s²."""
    reach: Floats
    """(S,) what a force of contact moves a free particle by, over what it would by Euler's method."""
    gain: Floats
    """(S,) by how much more that of an impact counts, for it does not go on: as by Euler's method."""


class Forces:
    """Forces between the strands of a groom whose segments have ``lengths`` (S,), metres, ``segments`` a strand."""

    def __init__(self, groom: Groom, lengths: Floats, segments: int, thickness: float, friction: float) -> None:
        self.groom, self.lengths, self.segments = groom, lengths, segments
        self.thickness, self.friction = thickness, friction

    def begin(self, dt: float, solver: Any) -> None:
        """Begin a step of ``dt`` seconds of the ``solver``."""
        self.method, self._step = self._method(dt, solver), dt

    def solve(self, found: Contacts, forces: Floats, solver: Any) -> float:
        """Change ``forces`` (m, 3) so that contacts hold; return by how much particles move by that, metres."""
        n = self.segments
        responses, own = np.empty((len(forces), 2, n, 3, 3)), np.empty((len(forces), 3, 3))
        strands = np.unique(found.pairs[:, [FIRST, SECOND]])
        places = np.zeros(len(self.lengths), np.int64)
        places[strands] = np.arange(len(strands))
        bands = self._factors(strands, self.method, solver)
        contact_response.respond(
            found.pairs, found.numbers, bands, places, self.lengths / self.method.reach, responses,
            np.empty((BLOCK * n, 3)),
        )  # fmt: skip
        responses *= self._gains(found)[:, :, None, None, None]
        self._responses = responses
        contact_solve.own_responses(found.pairs, found.numbers, responses, own)
        moves, after = np.zeros((len(self.lengths), n, 3)), forces.copy()
        sweeps = min(SWEEPS, max(LEAST_SWEEPS, UPDATES // len(forces)))
        if found.yielding():
            sweeps = CROWD_SWEEPS
        settings = self.friction, sweeps, PRECISION * self.thickness, IMMOBILE / float(self.lengths.max())
        contacts = found.numbers, found.vectors
        contact_solve.solve(found.pairs, contacts, (responses, own), settings, after, moves)
        moved = float(np.abs(moves).max())
        share = min(1.0, TRUST * max(float(found.excess().max()), self.thickness) / max(moved, TINY))
        leans = np.asarray(self._clamped(solver.state).any((1, 2)))
        found.numbers[:, URGENCY] *= leans[found.pairs[:, FIRST]] | leans[found.pairs[:, SECOND]]
        urgent = found.numbers[:, URGENCY] > 0
        forces += share * np.maximum(found.numbers[:, URGENCY, None], 1) * (after - forces)
        forces[urgent] = self._in_cone(forces[urgent], found.vectors[urgent, NORMAL : NORMAL + 3])
        return moved

    def _in_cone(self, forces: Floats, normals: Floats) -> Floats:
        """Return forces (m, 3) that press, and of which what is across their normals is no more than friction."""
        along = np.maximum(np.einsum("ic,ic->i", forces, normals), 0)[:, None]
        across = forces - np.einsum("ic,ic->i", forces, normals)[:, None] * normals
        size = np.linalg.norm(across, axis=1, keepdims=True)
        return np.asarray(along * normals + across * np.minimum(1, self.friction * along / np.maximum(size, TINY)))

    def _method(self, dt: float, solver: Any) -> Method:
        """What `begin.coefficients_of` makes of a step of ``dt`` seconds."""
        drag, bdf2 = solver.now.drag, solver.now.bdf2
        h, g = (2 * dt / 3, dt / VELOCITY_RATE) if bdf2 else (dt, dt)
        mass, count = (1 + drag * g) / (1 + drag * dt), len(self.lengths)
        square, reach, gain = np.full(count, h * g), np.full(count, h * g / dt**2), np.full(count, dt**2 / (h * g))
        euler = self.emitted(solver.state.restart[:, None])[:, 0, 0] > 0
        square[euler], reach[euler], gain[euler] = dt * dt * mass, mass, 1
        return Method(euler, square, reach, gain)

    def _gains(self, found: Contacts) -> Floats:
        """Return (m, 2) by how much more the forces of contacts count, for both strands."""
        impact = found.numbers[:, IMPACT, None]
        return np.asarray(1 / (1 - impact + impact / self.method.gain[found.pairs[:, [FIRST, SECOND]]]))

    def impacts(self, found: Contacts, forces: Floats) -> Floats:
        """Return (S, N, 3) by how much impacts among the forces of contacts that were last solved for move particles of
        strands that go by BDF2, metres."""
        moves, impacts = np.zeros((len(self.lengths), self.segments, 3)), forces * found.numbers[:, IMPACT, None]
        if impacts.any():
            contact_solve.move(found.pairs, self._responses, impacts, moves)
            moves[self.method.euler] = 0
        return moves

    def _factors(self, strands: NDArray[np.int64], method: Method, solver: Any) -> Floats:
        """Return the factors of some strands' responses."""
        material, now, state, square = solver.material, solver.now, solver.state, method.square
        damping = now.damping / now.duration
        drag = 1 + now.drag * now.duration / (VELOCITY_RATE if now.bdf2 else 1.0)
        stiffness = self.emitted(material.stiffness[:, None])[:, 0, 0] * square * (1 + damping)
        tension = self.emitted(state.tension)[:, :, 0] * square[:, None]
        bands = np.empty((len(strands), BLOCK * self.segments, BAND))
        mass, joint = drag * material.mass.astype(np.float64), material.joint.astype(np.float64)
        loads = stiffness, tension, self._clamped(state)
        edges, parts = self.emitted(state.edges), np.empty((3, 3, 3))
        contact_response.factorise(strands, edges, loads, mass, joint, solver.curled, bands, parts)
        return bands

    def load(self, found: Contacts, forces: Floats, solver: Any) -> None:
        """Have a step made with the forces of contacts, as `solve` takes them: as accelerations of particles."""
        count, n = len(self.lengths), self.segments
        added = np.zeros((count * (n + 1), 3))
        alpha, beta = found.numbers[:, ALPHA, None], found.numbers[:, BETA, None]
        one, other = self._gains(found).T[:, :, None]
        for strand, segment, share, force in (
            (found.pairs[:, FIRST], found.pairs[:, FIRST_SEGMENT], alpha, -one * forces),
            (found.pairs[:, SECOND], found.pairs[:, SECOND_SEGMENT], beta, other * forces),
        ):
            at = strand * (n + 1) + segment
            for place, part in ((at, (1 - share) * force), (at + 1, share * force)):
                for c in range(3):
                    added[:, c] += np.bincount(place, part[:, c], len(added))
        acceleration = solver.state.acceleration
        masses = self.lengths[:, None, None] * solver.mass.astype(np.float64)[:, None]
        rows = self.groom.placed(added.reshape(count, n + 1, 3)[:, 1:] / (masses * self._step**2))
        for j in range(n):
            acceleration[:, j] = lanes(rows[:, j], acceleration.dtype, PACK)

    def _clamped(self, state: State) -> Floats:
        """Return (S, N, 3) the unit normals of solids that particles touch, or 0."""
        if len(state.force) != len(state.edges):
            return np.zeros((len(self.lengths), self.segments, 3))
        push = self.emitted(state.force)
        size = np.linalg.norm(push, axis=2, keepdims=True)
        return np.asarray(push / np.where(size > 0, size, 1))

    def emitted(self, rows: NDArray[Any], width: int = PACK) -> Floats:
        """Return (S, rows, columns) of values in packs or blocks of a ``width``, in the order of emission."""
        wide = rows.reshape(*rows.shape[:2], -1, width).transpose(0, 3, 1, 2).astype(np.float64)
        return np.ascontiguousarray(self.groom.emitted(wide.reshape(-1, *wide.shape[2:])[: len(self.lengths)]))
