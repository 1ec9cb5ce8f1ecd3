"""What the kernel is told of a step's method and length (`kernels.records.Forcing.numbers`), and masses with drag."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .kernels.records import DRAG, FRICTION, LED, ROOT_MASS, VELOCITY_STEP, Forcing, Material
from .kernels.rod_scratch import PACK
from .kernels.rod_start import VELOCITY_RATE
from .material import firmness, stretch_rates, torsion
from .rod_pinned import HEAVY
from .section import oval

if TYPE_CHECKING:
    from ..scene.model import Rod

ROOT_SHARE = 0.5
"""Relative mass of a free root."""
TINY = 1e-9
"""Of rates and angles, what counts as none."""
MOMENT = 1e-6
"""Seconds in which nothing moves but what is put elsewhere."""
OVAL_DAMPING = 0.25
"""Share of a step that inner damping of coils with oval sections is at least: without any they hover by a tenth of a
metre a second, with a tenth it takes them ten seconds to calm down."""


FIRM_FROM = 0.3
"""Steps over the frequency at which a coil stretches from which its edges are kept with all of `firmness`. Shorter ones
need less of it, the square; in these it would be an error."""
LED_UP_TO, STAY_FROM = 0.3, 0.6
"""The same up to which edges are led all the way that they move, and from which they are kept where they are: such
steps cannot follow how coils stretch, and rounding would make these hover."""


def stretching(material: Material, torsion: float) -> NDArray[np.float64]:
    """Return (P, S) the angular frequencies, rad/s, at which curled strands stretch as springs do."""
    packs, rows, _ = material.bends.shape
    bends = material.bends[:, 2:, PACK:].reshape(packs, rows - 2, 2, PACK)
    square = np.einsum("pncs,pncs->ps", bends, bends, dtype=np.float64) / max(rows - 2, 1)
    return stretch_rates(torsion, material.stiffness, square, rows - 1)


class StepNumbers:
    """Writes the numbers of steps, and nothing where they are those of the step before. ``mass`` (N,) is that of
    particles without what drag adds; ``coiled``: whether some strand is a coil. Where strands
    yield, rest shapes are those that they begin with."""

    def __init__(
        self, rod: Rod, material: Material, forcing: Forcing, mass: NDArray[Any], gravity: tuple[float, ...],
        coiled: bool,
    ) -> None:  # fmt: skip
        self._mass = mass
        self._rod, self._material, self._forcing = rod, material, forcing
        self._gravity = gravity
        self._least_damping = OVAL_DAMPING if coiled and oval(rod) else 0.0
        self._firmness, self._rates = 0.0, None
        if len(forcing.led) == len(material.lengths):
            self._firmness = firmness(rod, coiled)
            self._rates = stretching(material, torsion(rod, coiled))
        self._last: tuple[float, bool, bool] | None = None
        self._dragged: float | None = None

    def set(self, dt: float, bdf2: bool, pinned: bool) -> None:
        """Write those of a step of ``dt`` seconds, but for the air. ``pinned``: whether tips are."""
        if self._last == (dt, bdf2, pinned):
            return
        rod = self._rod
        h, velocity_step = (2 * dt / 3, dt / VELOCITY_RATE) if bdf2 else (dt, dt)
        damping, share = max(rod.damping, self._least_damping * dt) * (h / dt), 1 / 3 if bdf2 else 0.0
        self._write(velocity_step, pinned, h, *self._gravity, 0.0, 0.0, 0.0, rod.drag, damping, share, rod.friction)
        self._forcing.numbers[LED] = bdf2 or oval(rod)
        self._keep_edges(dt)
        self._last = dt, bdf2, pinned

    def _keep_edges(self, dt: float) -> None:
        """Set how far edges of curled strands are led in steps of ``dt`` seconds, and how firmly they are kept."""
        if self._rates is None:
            return
        steps = self._rates * dt
        self._forcing.firmness[...] = self._firmness * np.minimum(1.0, (steps / FIRM_FROM) ** 2)
        self._forcing.led[...] = np.clip((STAY_FROM - steps) / (STAY_FROM - LED_UP_TO), 0.0, 1.0)

    def set_moment(self, pinned: bool) -> None:
        """Write those of `MOMENT`, without any load."""
        self._write(MOMENT, pinned, MOMENT, *[0.0] * FRICTION)

    def _write(self, velocity_step: float, pinned: bool, *up_to_friction: Any) -> None:
        numbers: NDArray[Any] = self._forcing.numbers
        self._last = None
        numbers[VELOCITY_STEP] = velocity_step
        numbers[: FRICTION + 1] = up_to_friction
        dragged = numbers[VELOCITY_STEP] * up_to_friction[DRAG]
        if dragged != self._dragged:
            np.multiply(self._mass, 1 + dragged, out=self._material.mass)
            numbers[ROOT_MASS] = ROOT_SHARE * (1 + dragged)
            if pinned:
                self._material.mass[-1] *= HEAVY
            self._dragged = dragged
