"""Sections of rods that are oval: what they bend and twist like, and how they lie about strands."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from ..scene.model import Rod

Floats = NDArray[np.float64]

LEADS = {False: 0.8, True: 1.0}
"""Share of the way to the edges by which rests are set that follows velocities, of curled strands and of those with
oval sections that are straight at rest. By velocities alone motion keeps its amplitude best, but curls gain energy;
with half of it they lose twice as much."""
STEEP = 1e-3
"""Sine of the angle between a strand and x below which x says nothing about its section."""


def oval(rod: Rod) -> bool:
    """Whether strands bend less easily one way than the other."""
    return rod.section is not None and rod.section.wide != rod.section.thin


def axes_of(rod: Rod) -> tuple[float, float]:
    """Return the half axes of the section, wide and thin, over the radius."""
    return (rod.section.wide, rod.section.thin) if rod.section is not None else (1.0, 1.0)


def softness(rod: Rod) -> float:
    """Return the share by which rigidity is less where strands bend along the thin axis: I is π a b³ / 4 there, and
    π a³ b / 4 along the wide one, of half axes a and b."""
    wide, thin = axes_of(rod)
    return 1 - (thin / wide) ** 2


def lead(rod: Rod) -> float:
    """Return the share of the way to the edges by which rests are set that follows velocities, not the last step."""
    return LEADS[oval(rod) and rod.rest == "straight"]


def twisting(rod: Rod) -> float:
    """Return GJ over the greatest EI, over that of a round rod of the same matter: J is π a³ b³ / (a² + b²)."""
    wide, thin = axes_of(rod)
    return 2 * thin**2 / (wide**2 + thin**2)


def wide_axes(rod: Rod, directions: Floats, tones: NDArray[np.floating]) -> Floats | None:
    """Return (strands, 3) unit vectors across the strands' ``directions`` along the wide axes of their sections at the
    root, in the emitter's frame; None where sections are round. ``tones``: as in a groom, by which they are spread."""
    section = rod.section
    if section is None or not oval(rod):
        return None
    level = np.where(np.hypot(directions[:, 1], directions[:, 2])[:, None] < STEEP, (0.0, 0.0, 1.0), (1.0, 0.0, 0.0))
    level = level - (level * directions).sum(1, keepdims=True) * directions
    level /= np.linalg.norm(level, axis=1, keepdims=True)
    angles = np.radians(section.angle + section.spread * tones.astype(np.float64))[:, None]
    return np.asarray(np.cos(angles) * level + np.sin(angles) * np.cross(directions, level))
