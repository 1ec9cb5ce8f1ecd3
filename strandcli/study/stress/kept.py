"""Whole segments against spheres, with `segments: true`: neither they nor particles may be inside.

The matrix collides particle by particle, as presets do by default.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from ...scene.model import RuleUse
from ...simulate import solver_of
from ...simulate.rules import registry
from .axes import Case
from .drive import Meter
from .scenes import groom_of, scene_of, times_of
from .strand import Metrics

CONTACTS = ("inside", "through", "small", "moving")
STRANDS = "129"


def check_segments(solver: str, *, contact: str, n: int) -> Metrics:
    """Depths of random strands of n segments in a matrix's sphere, and all else that is measured there."""
    case = Case.of(solver, {"contact": contact, "n": str(n), "strands": STRANDS, "start": "random"})
    times = times_of(case)
    scene, groom = scene_of(case, times), groom_of([case])
    whole = RuleUse("collision", registry()["collision"].Parameters(segments=True), "collision")
    scene = replace(scene, rules=tuple(whole if use.name == "collision" else use for use in scene.rules))
    meter = Meter(scene, groom.lengths.astype(np.float64) / n, case.value("L"), touching=True)
    one: Any = solver_of(scene)(scene, groom)
    meter.follow(one, times)
    return meter.metrics(slice(None))
