"""Strands that interact, through the extremes of the matrix: every two values of any two axes meet.

The matrix itself batches single strands, which interaction would make one groom of.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

from ...scene.model import RuleUse
from ...simulate import solver_of
from ...simulate.rules import registry
from .axes import DEFAULTS, Case
from .covering import covering
from .drive import Meter
from .scenes import groom_of, scene_of, times_of
from .strand import Metrics, only

STRANDS = "129"
DENSITY = {"10": 10.0, "1e3": 1e3, "1e9": 1e9}
"""Strands in L²; the grooms have about 20, and hundreds in front of solids."""
FRICTION = {"0": 0.0, "0.05": 0.05, "1": 1.0}
CELL = {"fine": 0.04, "coarse": 1.0}
"""In L."""
AXES = {
    "dt": ("1e-4", "240Hz", "60Hz", "24Hz", "0.5", "10", "noisy"),
    "B": ("0", "1e-2", "1", "1e6"),
    "gamma": ("0", "10", "1e4"),
    "wind": ("calm", "gale"),
    "emitter": ("still", "teleport", "flip", "shake"),
    "contact": ("none", "inside", "through", "overlap", "small", "moving"),
    "n": ("1", "2", "10", "32"),
    "start": ("straight", "zero", "coincident", "folded", "random"),
    "density": tuple(DENSITY),
    "friction": tuple(FRICTION),
    "cell": tuple(CELL),
}
OWN = ("density", "friction", "cell")
"""Axes that the matrix does not have."""


def check_crowd(solver: str, *, labels: dict[str, str]) -> Metrics:
    """All that is measured in the matrix, of a groom whose strands interact."""
    only(solver, "rod", "its strands have no velocity")
    shared = {axis: label for axis, label in labels.items() if axis not in OWN}
    case = Case.of(solver, {**shared, "strands": STRANDS})
    times = times_of(case)
    scene, groom = scene_of(case, times), groom_of([case])
    rule = registry()["interaction"].Parameters(
        density=DENSITY[labels["density"]], friction=FRICTION[labels["friction"]], cell=CELL[labels["cell"]]
    )
    # the matrix has strands of 2 L radius, which no cell could be smaller than
    rod = replace(scene.rod, radius=0.02, young=(scene.rod.young or 0.0) * 1e4)
    scene = replace(scene, rules=(*scene.rules, RuleUse("interaction", rule, "interaction")), rod=rod)
    meter = Meter(scene, groom.lengths.astype(float) / case.value("n"), 1.0, touching=labels["contact"] != "none")
    one: Any = solver_of(scene)(scene, groom)
    meter.follow(one, times)
    return meter.metrics(slice(None))


def _name(row: dict[str, str]) -> str:
    given = (f"{axis}={row[axis]}" for axis in AXES if axis in OWN or row[axis] != DEFAULTS[axis])
    return "/".join(("check=crowd", *given))


CHECKS: dict[str, Callable[[str], Metrics]] = {_name(row): partial(check_crowd, labels=row) for row in covering(AXES)}
