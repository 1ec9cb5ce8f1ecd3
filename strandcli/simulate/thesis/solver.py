"""The source's solver: the rules in the preset's order, once a step (thesis §2).

It has no velocity, so nothing has inertia; a rule's strength depends on the step; collision is per point; the shape
depends on the number of particles. These flaws of the source are kept, so that they can be seen and measured.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ... import solids
from ...compiling import runtime
from ...groom.blocks import lanes
from ...groom.record import Groom
from ..rules import Moment, passes_of
from ..solver import Solver
from .compose import step_for

if TYPE_CHECKING:
    from ...scene.model import Scene

GOLDEN = (math.sqrt(5) - 1) / 2
"""Whose multiples are spread evenly over 0 to 1, modulo 1."""


class ThesisSolver(Solver):
    """Strands that the rules of a scene move, fused into one step."""

    def __init__(self, scene: Scene, groom: Groom) -> None:
        super().__init__(scene, groom)
        self.passes = [one for _, one in passes_of(scene)]
        self._step = step_for(tuple(self.passes), runtime.cache_folder()) if self.passes else None
        self._distinct = list({id(one): one for one in self.passes}.values())
        places = {id(one): place for place, one in enumerate(self._distinct)}
        self._places = [places[id(one)] for one in self.passes]
        self._steady = not (any(one.state for one in self._distinct) or solids.others(scene.solids))
        """Whether the numbers of all passes follow from the moment alone, and are few."""
        self._known: dict[tuple[float, float], list[Any]] = {}

    def announce(self, ends: Sequence[float], dt: float) -> None:
        """As for any solver."""
        if self._steady:
            self._known = {(time, dt): [kept(one) for one in self._prepared(time, dt)] for time in ends}

    def step(self, time: float, dt: float) -> None:
        """Simulate a step of ``dt`` seconds that ends at ``time``."""
        if self._step is not None and dt > 0:
            self._deform(time)
            prepared = self._known.get((time, dt)) or self._prepared(time, dt)
            self._step(self.positions, self.lengths, self.rest, *prepared)

    def _prepared(self, time: float, dt: float) -> list[Any]:
        """Return the numbers of all passes for a step of ``dt`` seconds that ends at ``time``."""
        moment = Moment(time, dt * self._stretched(time, dt), self.scene)
        prepared = [one.prepare(moment) for one in self._distinct]
        return [prepared[place] for place in self._places]

    def _stretched(self, time: float, dt: float) -> float:
        """Return how many times as long as the others the step that ends at ``time`` is, by ``time.jitter``: evenly
        spread over 1 - jitter to 1 + jitter, whatever the seed."""
        jitter = self.scene.time.jitter
        return 1 + jitter * (2 * (round(time / dt) * GOLDEN % 1) - 1) if jitter > 0 else 1.0

    def state_arrays(self) -> dict[str, NDArray[Any]]:
        """Return the positions, and what rules keep from step to step."""
        kept = {f"pass {i}, {j}": one for i, p in enumerate(self._distinct) for j, one in enumerate(p.state)}
        return {**super().state_arrays(), **kept}

    def restore(self, state: Mapping[str, NDArray[Any]]) -> None:
        """Go on from such a state."""
        super().restore(state)
        for i, one in enumerate(self._distinct):
            for j, array in enumerate(one.state):
                array[...] = state[f"pass {i}, {j}"]

    def place_roots(self, frame: int) -> None:
        """Set the roots by the rules that move them, as `advance` does."""
        roots = [one for one in self.passes if one.stage == "root"]
        if roots and (frame > 1 or self.scene.time.preroll > 0):
            time = self.scene.time
            moment = Moment((frame - 1) / time.fps, 1.0 / (time.fps * time.substeps), self.scene)
            self._deform((frame - 1) / time.fps)
            step = step_for(tuple(roots), runtime.cache_folder())
            step(self.positions, self.lengths, self.rest, *[one.prepare(moment) for one in roots])

    def _deform(self, time: float) -> None:
        """Set the roots in the emitter's frame where they move there."""
        if self.deforming is None:
            return
        roots, directions = self.deforming.at(time)
        lengths = self.lengths.reshape(-1)[: self.strands, None]
        self.rest[:, 0] = lanes(roots - lengths * directions)
        self.rest[:, 1] = lanes(roots)


def kept(prepared: Any) -> Any:
    """Numbers of a pass that its rule may write over at the next moment."""
    return prepared.copy() if isinstance(prepared, np.ndarray) else prepared
