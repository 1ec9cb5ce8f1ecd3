"""How far motion leads the edges of curled strands in steps of a length, and how firmly they are kept there."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .kernels.records import TORSION, Forcing, Material
from .kernels.rod_scratch import PACK
from .material import FINE_TURN, firmness, stretch_rates

FIRM, LOOSE, FLAT = 0.5, 10.0, 10.0
"""Step over the frequency at which a coil stretches in which `SHARES` of `firmness` keep its edges where they are led.
Strands whose joints turn by less than `LOOSE` radians in all need as much in steps that are as much longer; flat coils
in steps that are as much shorter as `FLAT` times the distance between their ends, over their length and these
radians."""
SHARES = 0.6, 1.6
"""Such a step from which firmness counts, which would be an error in shorter ones, and from which all of it does."""
LED_UP_TO, LATE_FROM, STAY_FROM, STAY = 0.3, 0.6, 1.0, 2.0
"""The same up to which edges are led all the way that strands move, from which by less, so that `CALM` holds, from
which by less still, and from which they stay where they are: coils that are as stiff hardly give way, and the more
slowly the less it costs to follow them."""
CALM = 1.4
"""Share of critical damping, times two, that being led by less gives coils in steps that are too long to follow how
they stretch. Rests that stay behind by a share s of the way damp it by s E h, and it moves as if it had the mass E h²
besides its own: E is the rigidity where rests do not follow, κ θ² times the square of how far the frames before them
turn, which is R = Θ² / (3 χ) of that of the coil."""
HEAVY = 4.0, 20.0
"""Those masses over a coil's own, R (ω Δt)², from which edges are led by less, and by all of that."""
EULER = 4.0
"""How much longer steps of Euler's method may be before they need firmness, which would damp what they do not lead."""
TINY = 1e-9
"""Radians and lengths that count as none."""


class CoilSteps:
    """Writes `Forcing.firmness` and `Forcing.led` of steps. ``edges`` (P, N, 3 S) are those that strands begin
    with."""

    def __init__(self, material: Material, forcing: Forcing, edges: NDArray[Any]) -> None:
        self._forcing, torsion = forcing, float(forcing.numbers[TORSION])
        packs, rows, _ = material.bends.shape
        bends = material.bends[:, 2:, PACK:].reshape(packs, rows - 2, 2, PACK)
        square = np.einsum("pncs,pncs->ps", bends, bends, dtype=np.float64) / max(rows - 2, 1)
        self._firmness = firmness(torsion) * np.maximum(1.0, np.sqrt(square) / FINE_TURN)
        turning = np.maximum(np.sqrt(square) * (rows - 1), TINY)
        long = np.linalg.norm(edges.reshape(*edges.shape[:2], 3, PACK).mean(1, dtype=np.float64), axis=1)
        self.rates = stretch_rates(torsion, material.stiffness, square, rows - 1)
        """(P, S) angular frequencies, rad/s, at which strands stretch as springs do."""
        flat = FLAT * np.maximum(long, TINY) / turning
        self._firm = np.minimum(FIRM * np.maximum(1.0, LOOSE / turning), flat)
        self._over = math.sqrt(3 * torsion) / turning  # 1 / sqrt(R)

    def set(self, dt: float, bdf2: bool) -> None:
        """Write those of a step of ``dt`` seconds."""
        firm = (1.0 if bdf2 else EULER) * self._firm
        steps = self.rates * dt
        self._forcing.firmness[...] = self._firmness * ramp(steps / firm, *SHARES)
        calm = np.minimum(1.0, CALM * self._over)
        calm += ramp(steps, STAY_FROM, STAY) * (1.0 - calm)
        late = ramp(steps, LED_UP_TO, LATE_FROM) * ramp((steps / self._over) ** 2, *HEAVY)
        self._forcing.led[...] = 1.0 - late * calm


def ramp(x: NDArray[np.float64], low: float, high: float) -> NDArray[np.float64]:
    """Return 0 up to ``low``, 1 from ``high`` on, and what is between them linearly."""
    return np.clip((x - low) / (high - low), 0.0, 1.0)
