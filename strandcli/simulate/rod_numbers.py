"""What the kernel is told of a step's method and length (`kernels.records.Forcing.numbers`), and masses with drag."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .kernels.records import DRAG, FRICTION, VELOCITY_STEP, Forcing, Material
from .kernels.rod_pinned import HEAVY
from .kernels.rod_start import VELOCITY_RATE

if TYPE_CHECKING:
    from ..scene.model import Rod
    from .rod_coils import CoilSteps

TINY = 1e-9
"""Of rates and angles, what counts as none."""
MOMENT = 1e-6
"""Seconds in which nothing moves but what is put elsewhere."""


class StepNumbers:
    """Writes the numbers of steps, and nothing where they are those of the step before. ``mass`` (N,) is that of
    particles without what drag adds; ``coils``: None of strands that are not curled."""

    def __init__(
        self, rod: Rod, material: Material, forcing: Forcing, mass: NDArray[Any], gravity: tuple[float, ...],
        coils: CoilSteps | None,
    ) -> None:  # fmt: skip
        self._mass = mass
        self._rod, self._material, self._forcing = rod, material, forcing
        self._gravity, self.coils = gravity, coils
        self._last: tuple[float, bool, bool] | None = None
        self._dragged: float | None = None

    def set(self, dt: float, bdf2: bool, pinned: bool) -> None:
        """Write those of a step of ``dt`` seconds, but for the air. ``pinned``: whether tips are."""
        if self._last == (dt, bdf2, pinned):
            return
        rod = self._rod
        h, velocity_step = (2 * dt / 3, dt / VELOCITY_RATE) if bdf2 else (dt, dt)
        damping, share = rod.damping * (h / dt), 1 / 3 if bdf2 else 0.0
        self._write(velocity_step, pinned, h, *self._gravity, 0.0, 0.0, 0.0, rod.drag, damping, share, rod.friction)
        if self.coils is not None:
            self.coils.set(dt, bdf2)
        self._last = dt, bdf2, pinned

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
            if pinned:
                self._material.mass[-1] *= HEAVY
            self._dragged = dragged
