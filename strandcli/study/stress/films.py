"""Checks of a shipped preset's film: seconds of contact, which few steps are too short for."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from ...groom.emit import emit
from ...scene import load
from ...simulate import solver_of
from ...simulate.rules import registry
from .drive import Meter
from .strand import Metrics, NotRepresented

UNTIED = "a preset written for rods lists no rule that keeps its lengths"
STRANDS = 256
SECONDS = 1.0
"""Of the film, after its pre-roll."""


def check_film(solver: str, *, preset: str, particles: int, substeps: int) -> Metrics:
    """All that is measured of the matrix's scenes, but for depths: the presets' solids overlap."""
    settings: dict[str, Any] = {"emitter.particles": particles, "time.substeps": substeps, "emitter.strands": STRANDS}
    scene = replace(load(preset, rules=registry(), settings=settings), solver=solver)
    if solver != "rod" and all(use.name != "elasticity" for use in scene.rules):
        raise NotRepresented(UNTIED)
    groom = emit(scene.emitter, scene.seed, STRANDS)
    meter = Meter(scene, groom.lengths.astype(np.float64) / (particles - 1), scene.emitter.length, touching=False)
    run = solver_of(scene)(scene, groom)
    dt = 1 / (scene.time.fps * substeps)
    before = round(scene.time.preroll / dt)
    with np.errstate(all="ignore"):
        for step in range(before + round(SECONDS / dt)):
            time = (step + 1 - before) * dt
            run.step(time, dt)
            meter.look(run.particles(), time, run.strand_residuals())
    return meter.metrics(slice(None))
