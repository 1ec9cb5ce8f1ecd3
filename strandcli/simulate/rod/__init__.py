"""The solver of rods, and the precision in which it solves them, which plans ask for, too, and without NumPy."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from ...scene.checks import CLOSEST_PARTICLES

if TYPE_CHECKING:
    from ...scene.model import Emitter, Scene

CONTRAST = 1e5
"""Ratio of the stiffest joint to the softest above which single precision is not enough."""
THROW = 1e6
"""Free fall in a step, in segments, above which single precision leaves inertia too few digits."""
STEADIEST = 19
"""Greatest number of segments with which a sag-free strand moves by at most 1e-6 of it in single precision."""


def needs_double(scene: Scene, shortest: float) -> bool:
    """Return whether rods are solved in double precision, for single would not be enough. ``shortest``: of all
    segments, metres."""
    rod, n = scene.rod, scene.emitter.particles - 1
    pulls = [use.parameters.acceleration for use in scene.rules if use.name == "gravity"]
    fall = math.hypot(*map(sum, zip(*pulls, strict=True))) / (scene.time.fps * scene.time.substeps) ** 2  # in a step
    unsteady = rod.rest == "sag_free" and n > STEADIEST
    # rigidities as `material.matter_along` has them: they grow or shrink evenly after the root
    joints = 2.0, *((1 + (rod.tip - 1) * j / n) ** 4 for j in (1, n - 1) if 0 < j < n)
    return unsteady or max(joints) / min(joints) > CONTRAST or fall > THROW * shortest


def shortest_segment(emitter: Emitter) -> float:
    """Return a lower bound of the lengths of segments, metres, before strands are emitted or read from a file, of which
    those with closer particles are not simulated."""
    return emitter.shortest_segment if emitter.groom is None else CLOSEST_PARTICLES
