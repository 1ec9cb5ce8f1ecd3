"""Roots that are shaken along, across and aslant of their strand: whether iterations come to an end.

The matrix shakes across strands. Along them they are pushed together faster than inertia and stiffness resist, which is
what iterations find hardest.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import product
from typing import Any

import numpy as np

from ...scene.model import PoseKey
from ...simulate import solver_of
from .axes import AXES, Case
from .scenes import groom_of, scene_of
from .strand import STEPS, Metrics, only

WAYS = {"along": (1.0, 0.0, 0.0), "aslant": (0.5**0.5, 0.5**0.5, 0.0), "across": (0.0, 1.0, 0.0)}
"""Directions of shaking of a strand that is clamped along +x."""
RATES = ("240Hz", "60Hz", "24Hz")
RIGIDITIES = ("0", "1e-2", "1", "1e2")
PULLS = ("0", "7.7", "100")
TIMES = 100


def check_shake(
    solver: str, *, way: str, n: int, rates: tuple[str, ...] = RATES, pulls: tuple[str, ...] = PULLS
) -> Metrics:
    """The greatest residual of strands of n segments from every start, at all those rates, rigidities and pulls, in a
    hundred steps of a 50 Hz shake of .1 L."""
    only(solver, "rod", "it does not iterate")
    worst = 0.0
    for rate, B, gamma in product(rates, RIGIDITIES, pulls):
        labels = {"dt": rate, "B": B, "gamma": gamma, "emitter": "shake", "n": str(n)}
        times = STEPS[rate] * np.arange(1.0, TIMES + 1, dtype=np.float64)
        cases = [Case.of(solver, {**labels, "start": start}) for start in AXES["start"]]
        scene = scene_of(cases[0], times)
        keys = tuple(_turned(key, WAYS[way]) for key in scene.emitter.keys)
        scene = replace(scene, emitter=replace(scene.emitter, keys=keys))
        one: Any = solver_of(scene)(scene, groom_of(cases))
        for time in times:
            one.step(float(time), STEPS[rate])
            worst = max(worst, one.residual())
    return {"residual": worst}


def _turned(key: PoseKey, way: tuple[float, ...]) -> PoseKey:
    """A displacement along y as one along a direction."""
    x, y, z = (key.position[1] * part for part in way)
    return replace(key, position=(x, y, z))
