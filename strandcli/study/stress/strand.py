"""One straight strand for a check, and ways to run it. All is free of dimensions: a metre, a mass of one a metre."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...scene.model import RuleUse, Scene
from ...simulate import solver_of
from ...simulate.rod.solver import RodSolver
from ...simulate.rules import registry
from .axes import Case
from .scenes import Started, groom_of, scene_of, times_of

Metrics = dict[str, float]
STEPS = {"24Hz": 1 / 24, "60Hz": 1 / 60, "240Hz": 1 / 240, "0.5": 0.5}
"""Seconds by the label that checks are called by."""


class NotRepresented(Exception):
    """The solver has nothing that could be checked; the text says why."""


class Refused(Exception):
    """The product refuses the scene, as it should; the text is what it says."""


def only(solver: str, which: str, why: str) -> None:
    """Raise `NotRepresented` for any other solver."""
    if solver != which:
        raise NotRepresented(why)


def prepared(
    solver: str, *, gamma: float = 10.0, B: float = 1.0, n: int = 10, way: tuple[float, float, float] = (1, 0, 0),
    **rod: Any,
) -> tuple[Scene, Started]:  # fmt: skip
    """A strand along ``way`` with n segments and changes to the rod's settings; gravity is gamma · B, or gamma where B
    is zero."""
    case = Case.of(solver)
    scene, groom = scene_of(case, times_of(case)), groom_of([case])
    unit = np.array([way], np.float64) / np.linalg.norm(way)
    groom = replace(groom, directions=unit.astype(np.float32), edges=np.repeat(unit[:, None], n, 1))
    emitter = replace(scene.emitter, particles=n + 1)
    return replace(
        scene, emitter=emitter, rules=pulled(scene.rules, gamma * (B or 1.0)), rod=replace(scene.rod, young=B, **rod)
    ), groom


def pulled(rules: tuple[RuleUse, ...], pull: float) -> tuple[RuleUse, ...]:
    """The same rules with another gravity."""
    gravity = registry()["gravity"].Parameters(acceleration=(0.0, -pull, 0.0))
    return tuple(replace(use, parameters=gravity) if use.name == "gravity" else use for use in rules)


def stepped(scene: Scene, groom: Started, dt: float, steps: int, double: bool = False) -> Any:
    """The solver after so many steps; ``double``: rods in double precision."""
    solver: Any = RodSolver(scene, groom, double) if double else solver_of(scene)(scene, groom)
    for step in range(steps):
        solver.step((step + 1) * dt, dt)
    return solver


def rest(scene: Scene, groom: Started, dt: float = 0.5, steps: int = 240) -> NDArray[np.float64]:
    """(particles, 3) after so many steps, by default two minutes."""
    return np.asarray(stepped(scene, groom, dt, steps).particles()[0], np.float64)
