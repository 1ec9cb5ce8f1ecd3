"""How far motion leads the edges of curled strands in steps of a length, and how firmly they are kept there."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .kernels.records import TORSION, Forcing, Material
from .kernels.rod_scratch import PACK
from .material import firmness, stretch_rates

FIRM_FROM, FIRM_FLAT = 0.5, 10.0
"""Step over the frequency at which a coil stretches from which its edges are kept with all of `firmness`, and the same
times the radians by which all joints turn, of coils as long as their wire: flat ones need it in shorter steps. Shorter
steps need less of it, by the square, and it would be an error in them."""
LED_UP_TO, LATE_FROM, STAY_FROM, STAY = 0.3, 0.6, 1.0, 2.0
"""The same up to which edges are led all the way that strands move, from which by less, so that `CALM` holds, from
which by less still, and from which they stay where they are: coils that are as stiff hardly give way, and the more
slowly the less it costs to follow them."""
CALM = 1.4
"""Share of critical damping, times two, that being led by less gives how a coil stretches in steps that are too long to
follow it. Rests that stay behind by a share s of the way damp it by s E h of E h²: rest shapes that are led have a
coil move as if it had that mass, of the rigidity E of rests that do not follow, κ θ² times the square of how far the
frames before them turn."""
TINY = 1e-9
"""Radians and lengths that count as none."""


class CoilSteps:
    """Writes `Forcing.firmness` and `Forcing.led` of steps. ``edges`` (P, N, 3 S) are those that strands begin with, as
    their rest shapes are where they yield."""

    def __init__(self, material: Material, forcing: Forcing, edges: NDArray[Any]) -> None:
        self._forcing = forcing
        torsion = float(forcing.numbers[TORSION])
        self._firmness = firmness(torsion)
        packs, rows, _ = material.bends.shape
        bends = material.bends[:, 2:, PACK:].reshape(packs, rows - 2, 2, PACK)
        square = np.einsum("pncs,pncs->ps", bends, bends, dtype=np.float64) / max(rows - 2, 1)
        turning = np.maximum(np.sqrt(square) * (rows - 1), TINY)
        long = np.linalg.norm(edges.reshape(*edges.shape[:2], 3, PACK).mean(1, dtype=np.float64), axis=1)
        self.rates = stretch_rates(torsion, material.stiffness, square, rows - 1)
        """(P, S) angular frequencies, rad/s, at which strands stretch as springs do."""
        self._firm_from = np.minimum(FIRM_FROM, FIRM_FLAT * np.maximum(long, TINY) / turning)
        self._late = np.minimum(1.0, CALM * math.sqrt(3 * torsion) / turning)

    def set(self, dt: float) -> None:
        """Write those of a step of ``dt`` seconds."""
        steps = self.rates * dt
        self._forcing.firmness[...] = self._firmness * np.minimum(1.0, steps / self._firm_from) ** 2
        stay = np.clip((steps - STAY_FROM) / (STAY - STAY_FROM), 0.0, 1.0)
        late = np.clip((steps - LED_UP_TO) / (LATE_FROM - LED_UP_TO), 0.0, 1.0)
        self._forcing.led[...] = 1.0 - late * (self._late + stay * (1.0 - self._late))
