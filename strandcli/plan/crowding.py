"""How many pairs of segments the rule contact looks at in a step: counted for a sample of the strands as they are
emitted, since the number grows with the square of strands and with how dense they stand."""

from __future__ import annotations

import dataclasses
from functools import lru_cache
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ..scene.model import Emitter, Rod, Scene

GUESS = 3.0
"""Pairs of a particle of strands from a file, which is not read for it."""
STRANDS, SAMPLE = 5000, 256
"""Strands that are emitted for it at the most, and segments whose neighbours are counted."""
GRAVITY = 9.81
"""m/s². Boxes hold a segment's way in a step, which at the start is that of a fall."""
FAR = 1e6
"""Metres; boxes need not be larger to meet."""


def pairs_of(scene: Scene, strands: int) -> float:
    """Return the pairs of segments of so many strands; 0 without the rule."""
    thickness = next((use.parameters.thickness for use in scene.rules if use.name == "contact"), 0.0)
    if thickness == 0.0 or scene.solver != "rod" or strands < 2:
        return 0.0
    emitter = scene.emitter
    if emitter.groom is not None:
        return GUESS * strands * emitter.particles
    few = dataclasses.replace(emitter, strands=min(strands, STRANDS))
    fall = min(GRAVITY / (scene.time.fps * scene.time.substeps) ** 2, FAR)
    return _counted(few, scene.seed, thickness, scene.rod, fall) * (strands / few.strands) ** 2


@lru_cache(maxsize=4)
def _counted(emitter: Emitter, seed: int, thickness: float | None, rod: Rod, fall: float) -> float:
    """Pairs of the emitted strands' segments whose boxes meet."""
    import numpy as np

    from ..groom.emit import emit
    from ..simulate.material import MARGIN, matter

    groom = emit(emitter, seed)
    reach = min((1 + MARGIN) * (thickness or 2 * matter(rod)[1]), FAR)
    along = groom.lengths[:, None] * np.linspace(0, 1, emitter.particles, dtype=np.float32)
    low, high = [], []
    for axis in range(3):
        x = groom.roots[:, axis, None] + groom.directions[:, axis, None] * along
        low.append((np.minimum(x[:, :-1], x[:, 1:]) - reach / 2 - (fall if axis == 1 else 0)).ravel())
        high.append((np.maximum(x[:, :-1], x[:, 1:]) + reach / 2).ravel())
    total, each = len(low[0]), emitter.particles - 1
    some: Any = np.linspace(0, total - 1, min(SAMPLE, total)).astype(np.int64)
    found = 0
    for place in some:
        meets = np.ones(total, np.bool_)
        for least, most in zip(low, high, strict=True):
            meets &= (least <= most[place]) & (most >= least[place])
        own = place // each * each
        meets[own : own + each] = False
        found += int(np.count_nonzero(meets))
    return 0.5 * found / len(some) * total
