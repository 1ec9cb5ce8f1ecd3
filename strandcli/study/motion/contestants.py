"""The solvers that a study measures: what each can represent, its knobs, and one way to run any of them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...errors import UsageError
from ...groom.record import Groom
from ...scene.model import Rod, Scene
from ..references.base import NEEDS, Case, Track
from .strands import guides_of
from .watch import Stopwatch


@dataclass(frozen=True)
class Contestant:
    """One solver."""

    name: str
    represents: frozenset[str]
    """Keys of `NEEDS`."""
    offered: bool
    """Whether presets can ask for it; only such are recommended."""
    steps: tuple[float, ...]
    """Steps in seconds to try on a reference."""
    substeps: tuple[int, ...]
    """Steps a frame to try on a preset."""
    iterations: tuple[int, ...] = ()
    """Iterations a step to try; none where the solver does not iterate."""

    def lacks(self, needs: Sequence[str]) -> str:
        """What it cannot represent of some needs, in words; nothing where it can all."""
        return ", ".join(NEEDS[need] for need in needs if need not in self.represents)

    def start(self, scene: Scene, groom: Groom) -> Any:
        """The solver, ready for its first step. Raises `UsageError` for a scene that it does not take."""
        if self.name == "foil":
            from .foil import Foil

            return Foil(scene, groom)
        from ...simulate import solver_of

        return solver_of(scene)(scene, groom)

    def scene_solver(self) -> str:
        """The solver that a scene is validated with: the foil takes rods."""
        return self.name if self.offered else "rod"

    def refuses(self, scene: Scene) -> str:
        """Why it cannot run a scene, or nothing: asked by handing it a single strand, or a file's."""
        try:
            self.start(scene, guides_of(scene, 1))
        except UsageError as error:
            return str(error)
        return ""


CONTESTANTS = {
    one.name: one
    for one in (
        Contestant("thesis", frozenset(), True, (1 / 24, 1 / 60, 1 / 240), (1, 2, 4, 8)),
        Contestant(
            "rod",
            frozenset(
                {
                    "bending",
                    "inertia",
                    "tip mass",
                    "two ends",
                    "twist",
                    "contact",
                    "interaction",
                }
            ),
            True,
            (1 / 24, 1 / 60, 1 / 240),
            (1, 2, 4, 8),
            (2, Rod().iterations),
        ),
        Contestant(
            "foil",
            frozenset({"bending", "inertia", "tip mass", "two ends"}),
            False,
            (1 / 240, 1 / 480, 1 / 960, 1 / 1920),
            (8, 16, 32),
        ),
    )
}
"""By name."""


def prepare(contestant: Contestant, scene: Scene, case: Case) -> Any:
    """A solver for a reference's case, its extra conditions set."""
    solver = contestant.start(scene, case.groom)
    if case.tip_mass:
        # masses are kept relative to a segment's, of which a strand has as many as it has particles but the root
        solver.weight_tip(case.tip_mass * (scene.emitter.particles - 1))
    if case.tip_held_at is not None:
        solver.hold_tip(case.tip_held_at)
    return solver


def follow(make: Callable[[], Any], dt: float, span: float, moving: bool) -> tuple[Track, float]:
    """Run a solver from rest for a span of seconds in steps of ``dt``, recorded at every step where it is moving and
    at the end where not. Returns the track and the seconds that the steps took, compiling not counted."""
    warm_up(make, dt)
    solver = make()
    watch = Stopwatch(solver)
    steps = max(1, round(span / dt))
    times, positions = [0.0], [solver.particles().astype(np.float64)]
    for i in range(steps):
        solver.step((i + 1) * dt, dt)
        if moving or i == steps - 1:
            times.append((i + 1) * dt)
            positions.append(solver.particles().astype(np.float64))
    return Track(np.array(times), np.array(positions)), watch.seconds


def warm_up(make: Callable[[], Any], dt: float) -> None:
    """Two steps of a solver that is thrown away: what has to be compiled for this scene is compiled then."""
    solver = make()
    for i in range(2):
        solver.step((i + 1) * dt, dt)
