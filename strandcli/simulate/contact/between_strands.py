"""Contact with friction between the strands of a rod solver: the rule `contact` (`docs/solvers.md`).

Newton's method on step and contact together: a step is made without contact, and anew from its begin with the forces
that are found by linearised responses. All of it is done in the order of emission, on one thread.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ...constants import W
from ...groom.record import Groom
from ..health import RESIDUAL_MOST
from ..rod.kernels.arrays import State
from ..rod.material import MARGIN, contact_thickness
from .contacts import NOTHING, Contacts, Impacts
from .forces import Forces
from .kernels import contact_approach
from .kernels.contact_pairs import COUNTS, FIRST, GAP, IMPACT, NUMBERS, SAME, SECOND, VECTORS, Nearby

if TYPE_CHECKING:
    from ...scene.model import Scene

EASE, MOST_EASE = 5.0, 0.25
"""Share of the thickness by which strands that begin closer come apart a second, and in a step at the most."""
TOLERANCE, ENOUGH = 2e-3, 2e-2
"""Of distances at the end of a step, over the thickness: what rounds go on for, and what is enough after `ROUNDS`."""
ROUNDS = 6
LEFT = 0.05
"""The same after the last round, beyond which the step is made in two halves, but where contacts yield."""
HALVINGS = 7
"""Times that a step is cut in two at the most."""
ALIKE = 0.7
"""Cosine between normals at the begin and the end of a step from which on they are on the same side."""

AT_ONCE = 1 << 16
"""Pairs of segments that are looked at at once: of most of them nothing is stored."""
ANEW = 0.02
"""Excess over the thickness from which on a contact is looked for anew, if it is more than twice that at its place."""
SETTLED, GAIN = 3, 0.9
"""Rounds after which a yielding crowd is left as it is, and the gain of a round on its excess by then."""

Floats = NDArray[np.float64]


class StrandContact:
    """Contact between the strands of a groom. Raises `UsageError` for a thickness that does not fit the groom."""

    def __init__(self, scene: Scene, groom: Groom, parameters: Any) -> None:
        self.iterations = parameters.iterations
        self.thickness = contact_thickness(scene, groom, parameters.thickness)
        self.groom = groom
        self.segments = scene.emitter.particles - 1
        self.lengths = groom.emitted(groom.lengths.astype(np.float64)) / self.segments
        apart = 1 + math.ceil(2 * self.thickness / float(self.lengths.min()))
        self._forces = Forces(groom, self.lengths, self.segments, self.thickness, parameters.friction)
        self._nearby = Nearby(self.segments, min(apart, self.segments))
        self._impacts = Impacts(groom, self.thickness)
        self.penetration = 0.0
        """How much closer strands were at the end of the last step than their thickness, or near their roots than these
        leave to them, metres."""

    def step(self, run: Callable[[], None], dt: float, solver: Any) -> bool:
        """Make a step of ``dt`` seconds by ``run``, again where strands touch. ``solver``: the rod solver whose step it
        is. Return False where rounds do not converge or some strand has come through another, for the step is too
        long."""
        self._forces.begin(dt, solver)
        self._impacts.begin()
        self._moves = np.zeros((len(self.lengths), self.segments, 3))  # by impacts
        converged = self._rounds(run, dt, solver)
        self._impacts.finish(solver, self._moves, dt)
        return converged

    def state_arrays(self) -> dict[str, NDArray[Any]]:
        """Return what lasts from a step to the next."""
        return {
            "found": np.array([self.penetration]),
            "free touching": self._impacts.past.reshape(-1),
        }

    def restore(self, state: Mapping[str, NDArray[Any]]) -> None:
        """Go on from that."""
        self._impacts.past = np.array(state["free touching"]).reshape(-1, 2)
        self.penetration = float(state["found"][0])

    def _rounds(self, run: Callable[[], None], dt: float, solver: Any) -> bool:
        """As `step`, but for velocities after impacts."""
        state: State = solver.state
        if solver.grid is not None:
            # its change of velocity, so that BDF2 goes on without: the kernel has `State.acceleration` for contact
            change = state.acceleration.dtype.type(dt) * state.acceleration
            for one in (state.velocity, state.before, state.ahead):
                one += change
        state.acceleration[...] = 0
        before = {name: one.copy() for name, one in state._asdict().items()}
        start = self._particles(state)
        velocities = np.pad(self._forces.emitted(state.velocity), ((0, 0), (1, 0), (0, 0)))  # those of roots follow
        contacts, forces, past = NOTHING, np.zeros((0, 3)), math.inf
        for iteration in range(self.iterations + 1):
            run()
            wild = bool(len(forces)) and self._tame(run, (contacts, forces), before, solver)
            end = self._particles(state)
            found = self._look(start, end, dt)
            if found is None:
                return True
            velocities[:, 0] = (end[:, 0] - start[:, 0]) / dt
            found.numbers[:, IMPACT] = self._impacts.shares(found, velocities, dt)
            self.penetration = found.penetration()
            tolerance = (TOLERANCE if iteration < ROUNDS else ENOUGH) * self.thickness
            excess = float(found.excess().max(initial=0.0))
            wanted = excess > tolerance
            settled = iteration >= SETTLED and excess > GAIN * past and found.yielding()
            if iteration == self.iterations or settled:
                left = not found.yielding() and excess > LEFT * self.thickness
                return not (wild or left or found.through(self.thickness))
            past = excess
            if not wanted and (iteration >= ROUNDS or not len(forces)):
                return True
            contacts, forces = self._merged(contacts, forces, found, start, end)
            changed = self._forces.solve(contacts, forces, solver)
            if not wanted and changed < 2 * tolerance:
                return True
            for name, one in state._asdict().items():
                one[...] = before[name]
            self._load(contacts, forces, solver)
        return True

    def _load(self, contacts: Contacts, forces: Floats, solver: Any) -> None:
        """Have the next round made with these forces."""
        self._forces.load(contacts, forces, solver)
        self._moves = self._forces.impacts(contacts, forces)
        self._impacts.note(contacts, forces)

    def _tame(
        self, run: Callable[[], None], given: tuple[Contacts, Floats], before: dict[str, NDArray[Any]], solver: Any
    ) -> bool:
        """Where a round's forces are more than a strand's step can carry, which those of jammed contacts may become,
        take them from that strand, or from all if that is not enough, and make the step anew. Return whether that
        was so."""
        contacts, forces = given
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
        self, contacts: Contacts, forces: Floats, found: Contacts, start: Floats, end: Floats
    ) -> tuple[Contacts, Floats]:
        """Return the contacts of a round and their forces: those of the rounds before at the places where they were
        found, and those that are ``found`` now. Places that moved from round to round would let rounds not converge."""
        past = contacts.excess()
        contacts.update(start, end)
        contacts.urge(past, TOLERANCE * self.thickness)
        # the normal of the rest is that of the end, which is on the wrong side where they have passed each other
        some = (found.excess() > 0) | (found.numbers[:, SAME] > ALIKE)
        new, old = self._codes(found.pairs), self._codes(contacts.pairs)
        _, one, other = np.intersect1d(new, old, assume_unique=True, return_indices=True)
        now, then = found.excess()[one], contacts.excess()[other]
        anew = some[one] & (now > ANEW * self.thickness) & (now > 2 * then)
        given = np.zeros((len(new), 3))
        given[one] = forces[other]
        some[one[~anew]] = False
        stay = np.ones(len(old), bool)
        stay[other[anew]] = False
        parts = zip(contacts.where(stay), found.where(some), strict=True)
        return Contacts(*(np.concatenate(pair) for pair in parts)), np.concatenate([forces[stay], given[some]])

    def _look(self, start: Floats, end: Floats, dt: float) -> Contacts | None:
        """Return the contacts that are near at the end of a step; None where a coordinate is not finite."""
        if not np.isfinite(end).all():
            return None
        pairs = self._nearby.find(start, end, (1 + MARGIN) * self.thickness)
        sizes = self.thickness, min(EASE * dt, MOST_EASE), (1 + MARGIN) * self.thickness
        parts = [self._near(start, end, pairs[i : i + AT_ONCE], sizes) for i in range(0, len(pairs) or 1, AT_ONCE)]
        found = Contacts(*(np.concatenate(one) for one in zip(*parts, strict=True)))
        found.let_crowds_yield(self.thickness, sizes[1] * self.thickness, len(self.lengths), self.segments)
        return found

    def _near(self, start: Floats, end: Floats, pairs: NDArray[np.int64], sizes: tuple[float, ...]) -> Contacts:
        """Return the contacts among some pairs that are near at the end of a step."""
        numbers, vectors = np.zeros((len(pairs), NUMBERS)), np.zeros((len(pairs), VECTORS))
        contact_approach.look(start, end, self.lengths, pairs, sizes, numbers, vectors)
        near = (numbers[:, COUNTS] > 0) & (numbers[:, GAP] < sizes[2])
        return Contacts(pairs, numbers, vectors).where(near)

    def _particles(self, state: State) -> Floats:
        """Return (S, N + 1, 3) particles with their roots."""
        return self._forces.emitted(state.positions[:, 1:], W)


def in_parts(solver: Any, step: Callable[[float, float], bool], time: float, dt: float, halvings: int = 0) -> None:
    """Make a ``step`` of a solver, or where it is too long two of half its length, and so on."""
    saved = {name: one.copy() for name, one in solver.state_arrays().items()} if halvings < HALVINGS else {}
    if step(time, dt) or not saved:
        return
    solver.restore(saved)
    saved.clear()  # each of the halves keeps its own
    in_parts(solver, step, time - dt / 2, dt / 2, halvings + 1)
    in_parts(solver, step, time, dt / 2, halvings + 1)
