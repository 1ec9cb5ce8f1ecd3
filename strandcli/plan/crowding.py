"""What rods that meet take: pairs of segments for the rule contact, cells of the grid for the rule interaction.

Strands are taken to stand apart evenly on what they grow on, as they are emitted.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from ..scene.model import SphereShape
from .sizes import reach_of, surface

if TYPE_CHECKING:
    from ..scene.model import Scene

GUESS = 3.0
"""Pairs of a particle of strands from a file."""
ALIKE = 0.45
"""Share of the boxes that meet of those that would if neighbours went in any direction."""
GRAVITY, FAR = 9.81, 1e6
"""m/s²: boxes hold what a segment falls in its first step, metres; they need not be larger than the second to meet."""
EACH = 180
"""Bytes of a cell: 101 of its own, and 32 in each box of a part of the strands that reaches it, 2.4 on average as
measured with `hair`."""
USUAL = 64_000_000
"""Bytes of a grid up to which other figures of `memory` hold it."""
LANES, MOST = 16, 4_000_000
"""Rows have so many cells, or a multiple of it; with more in all no run begins."""


def pairs_of(scene: Scene, strands: int) -> float:
    """Return how many pairs of segments of so many strands have boxes that meet in a step; 0 without the rule
    contact."""
    thickness = next((use.parameters.thickness for use in scene.rules if use.name == "contact"), 0.0)
    if thickness == 0.0 or scene.solver != "rod" or strands < 2:
        return 0.0
    emitter = scene.emitter
    particles = strands * emitter.particles
    if emitter.groom is not None:
        return GUESS * particles
    from ..simulate.rod.material import MARGIN, matter  # NumPy comes with it

    each = emitter.length / (emitter.particles - 1)
    reach = min((1 + MARGIN) * (thickness or 2 * matter(scene.rod)[1]), FAR)
    fall = min(GRAVITY / (scene.time.fps * scene.time.substeps) ** 2, FAR)
    box = (each + 2 * reach) ** 2 * (each + 2 * reach + 2 * fall)
    area, extent = surface(scene)
    if emitter.tie is not None:
        area = math.pi * emitter.tie.radius**2
    parts = isinstance(emitter.shape, SphereShape) and emitter.comb is None and emitter.direction is None
    spread = emitter.length / max(extent, 1e-9) if parts and emitter.tie is None else 0.0
    # of strands that part as they leave a ball, 1 / (1 + spread h)² on average over their height h
    pairs = ALIKE / 2 * strands * particles * box / (max(area, 1e-12) * each * (1 + spread))
    return min(pairs, particles * float(strands))


def grid_bytes(scene: Scene, strands: int) -> int:
    """Return the bytes of the grid of so many rods, 0 without the rule or for usual cells. Of strands from a file,
    which is not read for it, 0."""
    cell = next((use.parameters.cell for use in scene.rules if use.name == "interaction"), None)
    if cell is None or scene.solver != "rod" or strands < 1 or scene.emitter.groom is not None:
        return 0
    side = min(math.ceil(2 * reach_of(scene) / cell) + 2, 1e6)
    taken = EACH * int(min(-(-side // LANES) * LANES * side**2, MOST))
    return taken if taken >= USUAL else 0
