"""Contact with friction between the strands of a rod solver: the rule `contact`.

A step is made without contact. Where strands would come too close or pass through each other, forces of contact are
found with each strand's response linearised (`kernels.contact_response`, `kernels.contact_solve`), and the step is made
anew from its begin with these forces among its loads, until it keeps strands apart: Newton's method on step and contact
together. Lengths are exact and bending takes part, as in any step. Nothing but the strands' own state lasts from a step
to the next. What is done here is done in the order of emission, on one thread.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...blocks import lanes
from ...constants import W
from ...groom.record import Groom
from ..health import RESIDUAL_MOST
from ..kernels.records import DAMPING, STEP, State
from ..kernels.rod_scratch import PACK
from ..material import MARGIN, contact_thickness
from .kernels import contact_approach, contact_response, contact_solve
from .kernels.contact_columns import (
    ALPHA,
    BEGIN,
    BETA,
    COUNTS,
    END,
    FIRST,
    FIRST_SEGMENT,
    GAP,
    KEPT,
    NUMBERS,
    SAME,
    SECOND,
    START,
    VECTORS,
    WANTED,
)
from .kernels.contact_response import BAND, BLOCK
from .nearby import Nearby

if TYPE_CHECKING:
    from ...scene.model import Scene

EASE, MOST_EASE = 5.0, 0.25
"""Share of the thickness by which strands that begin closer come apart a second, and in a step at the most."""
SWEEPS, LEAST_SWEEPS, UPDATES = 200, 30, 100_000
"""Sweeps of a contact solve at the most: the first where contacts are few, the second at the least, and else as many as
make so many updates of a contact."""
TOLERANCE, ENOUGH = 2e-3, 2e-2
"""Of distances at the end of a step, over the thickness: what rounds go on for, and what is enough after `ROUNDS`."""
PRECISION = 1e-4
"""Of ways in the contact solve, over the thickness."""
ROUNDS = 6
HALVINGS = 7
"""Times that a step is cut in two at the most."""
THROUGH = 0.5
"""Share of their distance at the begin, or of the thickness where that is less, below which strands that a step leaves
count as having come through each other."""
ALIKE = 0.7
"""Cosine between normals at the begin and the end of a step from which on they are on the same side."""
TRUST = 3.0
"""Greatest displacement that a round is trusted with, over the thickness or what strands are too close by, whichever
is greater."""
TINY = 1e-30
IMMOBILE = 1e-9
"""Response, over that of a free particle, below which a contact cannot move anything."""

Floats = NDArray[np.float64]
NONE = (0.0, 0.0, 0.0)


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
        return np.asarray(self.numbers[:, WANTED] - self.numbers[:, GAP])

    def penetration(self) -> float:
        """Return by how much strands are closer than what roots leave to them, at the most, metres."""
        return max(0.0, float((self.numbers[:, KEPT] - self.numbers[:, GAP]).max(initial=0.0)))

    def through(self, thickness: float) -> bool:
        """Whether strands have come through each other because they are fast."""
        least = THROUGH * np.minimum(self.numbers[:, BEGIN], thickness)
        ways = np.linalg.norm(self.vectors[:, END : END + 3] - self.vectors[:, START : START + 3], axis=1)
        return bool(((self.numbers[:, GAP] < least) & (ways > thickness)).any())

    def update(self, start: Floats, end: Floats) -> None:
        """Set ways and distances at the same places."""
        i, a, j, b = self.pairs.T
        alpha, beta = self.numbers[:, ALPHA, None], self.numbers[:, BETA, None]
        for place, x in ((START, start), (END, end)):
            one = x[i, a] + alpha * (x[i, a + 1] - x[i, a])
            self.vectors[:, place : place + 3] = x[j, b] + beta * (x[j, b + 1] - x[j, b]) - one
        self.numbers[:, GAP] = np.einsum("ic,ic->i", self.vectors[:, :3], self.vectors[:, END : END + 3])

    def where(self, some: NDArray[np.bool_]) -> Contacts:
        """Return some of them."""
        return Contacts(self.pairs[some], self.numbers[some], self.vectors[some])


NOTHING = Contacts(np.zeros((0, 4), np.int64), np.zeros((0, NUMBERS)), np.zeros((0, VECTORS)))
ANEW = 0.02
"""Excess over the thickness from which on a contact is looked for anew, if it is more than twice that at its place."""


class StrandContact:
    """Contact between the strands of a groom. Raises `UsageError` for a thickness that does not fit the groom."""

    def __init__(self, scene: Scene, groom: Groom, parameters: Any) -> None:
        self.friction, self.iterations = parameters.friction, parameters.iterations
        self.thickness = contact_thickness(scene, groom, parameters.thickness)
        self.groom = groom
        self.segments = scene.emitter.particles - 1
        self.lengths = groom.emitted(groom.lengths.astype(np.float64)) / self.segments
        apart = 1 + math.ceil(2 * self.thickness / float(self.lengths.min()))
        self._nearby = Nearby(self.segments, min(apart, self.segments))
        self.penetration = 0.0
        """How much closer strands were at the end of the last step than their thickness, or near their roots than these
        leave to them, metres."""

    def step(self, run: Callable[[], None], solver: Any) -> bool:
        """Make a step by ``run``, again where strands touch. ``solver``: the rod solver whose step it is. Return False
        where some strand has come through another, for the step is too long."""
        state: State = solver.state
        if solver.crowd is None:
            state.crowd[...] = 0
        before = {name: one.copy() for name, one in state._asdict().items()}
        start = self._particles(state)
        held, forces = NOTHING, np.zeros((0, 3))
        for iteration in range(self.iterations + 1):
            run()
            wild = bool(len(forces)) and self._tame(run, (held, forces), before, solver)
            end = self._particles(state)
            found = self._look(start, end, float(solver.forcing.numbers[STEP]))
            if found is None:
                return True
            self.penetration = found.penetration()
            tolerance = (TOLERANCE if iteration < ROUNDS else ENOUGH) * self.thickness
            wanted = found.excess().max(initial=0.0) > tolerance
            if iteration == self.iterations:
                return not wild and not found.through(self.thickness)
            if not wanted and (iteration >= ROUNDS or not len(forces)):
                return True
            held, forces = self._merged(held, forces, found, start, end)
            changed = self._solve(held, forces, solver)
            if not wanted and changed < 2 * tolerance:
                return True
            for name, one in state._asdict().items():
                one[...] = before[name]
            self._load(held, forces, solver)
        return True

    def _tame(
        self, run: Callable[[], None], held: tuple[Contacts, Floats], before: dict[str, NDArray[Any]], solver: Any
    ) -> bool:
        """Where a round's forces are more than a strand's step can carry, which those of jammed contacts may become,
        take them from that strand, or from all if that is not enough, and make the step anew. Return whether that
        was so."""
        contacts, forces = held
        for some in (True, False):
            wild = ~(solver.strand_residuals() <= RESIDUAL_MOST)
            if not wild.any():
                return not some
            mine = wild[contacts.pairs[:, FIRST]] | wild[contacts.pairs[:, SECOND]]
            forces[mine if some else slice(None)] = 0
            for name, one in solver.state._asdict().items():
                one[...] = before[name]
            self._load(contacts, forces, solver)
            run()
        return True

    def _codes(self, pairs: NDArray[np.int64]) -> NDArray[np.int64]:
        n, count = self.segments, len(self.lengths)
        return ((pairs[:, 0] * n + pairs[:, 1]) * count + pairs[:, 2]) * n + pairs[:, 3]

    def _merged(
        self, held: Contacts, forces: Floats, found: Contacts, start: Floats, end: Floats
    ) -> tuple[Contacts, Floats]:
        """Return the contacts of a round and their forces: those of the rounds before at the places where they were
        found, and those that are ``found`` now. Places that moved from round to round would let rounds not converge."""
        held.update(start, end)
        # the normal of others is that of the end, which is on the wrong side where they have passed each other
        some = (found.excess() > 0) | (found.numbers[:, SAME] > ALIKE)
        new, old = self._codes(found.pairs), self._codes(held.pairs)
        _, one, other = np.intersect1d(new, old, assume_unique=True, return_indices=True)
        now, then = found.excess()[one], held.excess()[other]
        anew = some[one] & (now > ANEW * self.thickness) & (now > 2 * then)
        given = np.zeros((len(new), 3))
        given[one] = forces[other]
        some[one[~anew]] = False
        stay = np.ones(len(old), bool)
        stay[other[anew]] = False
        parts = zip(held.where(stay), found.where(some), strict=True)
        return Contacts(*(np.concatenate(pair) for pair in parts)), np.concatenate([forces[stay], given[some]])

    def _look(self, start: Floats, end: Floats, dt: float) -> Contacts | None:
        """Return the contacts that are near at the end of a step; None where a coordinate is not finite."""
        if not np.isfinite(end).all():
            return None
        pairs = self._nearby.find(start, end, (1 + MARGIN) * self.thickness)
        numbers, vectors = np.zeros((len(pairs), NUMBERS)), np.zeros((len(pairs), VECTORS))
        sizes = self.thickness, min(EASE * dt, MOST_EASE)
        contact_approach.look(start, end, self.lengths, pairs, sizes, numbers, vectors, np.zeros((3, 2, 3)))
        near = (numbers[:, COUNTS] > 0) & (numbers[:, GAP] < (1 + MARGIN) * self.thickness)
        return Contacts(pairs, numbers, vectors).where(near)

    def _solve(self, found: Contacts, forces: Floats, solver: Any) -> float:
        """Change ``forces`` (m, 3) so that contacts hold; return by how much particles move by that, metres."""
        material, numbers = solver.material, solver.forcing.numbers
        h = float(numbers[STEP])
        strands, n = np.unique(found.pairs[:, [FIRST, SECOND]]), self.segments
        places = np.zeros(len(self.lengths), np.int64)
        places[strands] = np.arange(len(strands))
        stiffness = self._emitted(material.stiffness[:, None])[:, 0, 0] * h * h * (1 + float(numbers[DAMPING]) / h)
        tension = self._emitted(solver.state.tension)[:, :, 0] * h * h
        bands = np.empty((len(strands), BLOCK * n, BAND))
        mass, joint = material.mass.astype(np.float64), material.joint.astype(np.float64)
        edges, normals = self._emitted(solver.state.edges), self._held(solver.state)
        contact_response.factorise(strands, edges, (stiffness, tension, normals), mass, joint, bands)
        responses = np.empty((len(forces), 2, n, 3, 3))
        own = np.empty((len(forces), 3, 3))
        contact_response.respond(
            found.pairs, found.numbers, bands, places, self.lengths, responses, np.empty((BLOCK * n, 3))
        )
        contact_solve.own_responses(found.pairs, found.numbers, responses, own)
        moves, after = np.zeros((len(self.lengths), n, 3)), forces.copy()
        sweeps = min(SWEEPS, max(LEAST_SWEEPS, UPDATES // len(forces)))
        settings = self.friction, sweeps, PRECISION * self.thickness, IMMOBILE / float(self.lengths.max())
        contact_solve.solve(
            found.pairs, (found.numbers, found.vectors), (responses, own), settings, after, moves, np.zeros((7, 3))
        )
        moved = float(np.abs(moves).max())
        share = min(1.0, TRUST * max(float(found.excess().max()), self.thickness) / max(moved, TINY))
        forces += share * (after - forces)
        return moved

    def _load(self, found: Contacts, forces: Floats, solver: Any) -> None:
        """Add the accelerations of particles by the forces of contacts to those by the strands around."""
        added = np.zeros((len(self.lengths), self.segments + 1, 3))
        alpha, beta = found.numbers[:, ALPHA, None], found.numbers[:, BETA, None]
        for strand, segment, share, force in (
            (found.pairs[:, FIRST], found.pairs[:, FIRST_SEGMENT], alpha, -forces),
            (found.pairs[:, SECOND], found.pairs[:, FIRST_SEGMENT + 2], beta, forces),
        ):
            np.add.at(added, (strand, segment), (1 - share) * force)
            np.add.at(added, (strand, segment + 1), share * force)
        h = float(solver.forcing.numbers[STEP])
        added = added[:, 1:] / (self.lengths[:, None, None] * solver.mass.astype(np.float64)[:, None] * h * h)
        crowd = solver.state.crowd
        rows = self.groom.placed(added)
        for j in range(self.segments):
            crowd[:, j] += lanes(rows[:, j], crowd.dtype, PACK)

    def _held(self, state: State) -> Floats:
        """Return (S, N, 3) the unit normals of solids that particles touch, or 0."""
        if len(state.push) != len(state.edges):
            return np.zeros((len(self.lengths), self.segments, 3))
        push = self._emitted(state.push)
        size = np.linalg.norm(push, axis=2, keepdims=True)
        return np.asarray(push / np.where(size > 0, size, 1))

    def _particles(self, state: State) -> Floats:
        """Return (S, N + 1, 3) particles with their roots."""
        return self._emitted(state.positions[:, 1:], W)

    def _emitted(self, rows: NDArray[Any], width: int = PACK) -> Floats:
        """Return (S, rows, columns) of values in packs or blocks of a ``width``, in the order of emission."""
        wide = rows.reshape(*rows.shape[:2], -1, width).transpose(0, 3, 1, 2).astype(np.float64)
        return np.ascontiguousarray(self.groom.emitted(wide.reshape(-1, *wide.shape[2:])[: len(self.lengths)]))


def in_parts(solver: Any, step: Callable[[float, float], bool], time: float, dt: float, halvings: int = 0) -> None:
    """Make a ``step`` of a solver, or where it is too long two of half its length, and so on."""
    saved = {name: one.copy() for name, one in solver.state_arrays().items()} if halvings < HALVINGS else {}
    if step(time, dt) or not saved:
        return
    solver.restore(saved)
    in_parts(solver, step, time - dt / 2, dt / 2, halvings + 1)
    in_parts(solver, step, time, dt / 2, halvings + 1)
