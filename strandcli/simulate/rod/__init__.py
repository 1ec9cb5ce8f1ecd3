"""The solver of rods, and the precision in which it solves them, which plans ask for, too, and without NumPy."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from ...scene.checks import CLOSEST_PARTICLES

if TYPE_CHECKING:
    from ...scene.model import Emitter, Rod, Scene

CONTRAST = 1e5
"""Ratio of the stiffest joint to the softest above which single precision is not enough: rounding errors of the first
are a load on the second. Reached by a tip some twenty times as thick as the root."""
THROW = 1e6
"""Free fall in a step, in segments, above which single precision is not enough: tension exceeds inertia by this factor,
which leaves inertia too few digits."""
STEADIEST = 19
"""Greatest number of segments with which a sag-free strand moves at most by 1e-6 of its length in single precision,
in steps cut for coils, too. Rounding of the moments moves longer ones more: by 1e-5 with 1,000 segments."""


def needs_double(scene: Scene, shortest: float) -> bool:
    """Return whether rods are solved in double precision, for single would not be enough. ``shortest``: of all
    segments, metres."""
    rod, n = scene.rod, scene.emitter.particles - 1
    pulls = [use.parameters.acceleration for use in scene.rules if use.name == "gravity"]
    fall = math.hypot(*map(sum, zip(*pulls, strict=True))) / (scene.time.fps * scene.time.substeps) ** 2  # in a step
    unsteady = rod.rest == "sag_free" and n > STEADIEST
    return unsteady or contrast(rod, n) > CONTRAST or fall > THROW * shortest


def contrast(rod: Rod, n: int) -> float:
    """Return the rigidity of the stiffest of ``n`` joints over that of the softest, as `material.matter_along` has
    them: 2 at the root, and after it the fourth power of the radius where a segment begins, which grows or shrinks
    evenly."""
    along = ((1 + (rod.tip - 1) * j / n) ** 4 for j in (1, n - 1) if 0 < j < n)
    joints = 2.0, *along
    return max(joints) / min(joints)


def shortest_segment(emitter: Emitter) -> float:
    """Return a lower bound of the lengths of segments, metres, before strands are emitted or read from a file, of which
    those with closer particles are not simulated."""
    return emitter.shortest_segment if emitter.groom is None else CLOSEST_PARTICLES
