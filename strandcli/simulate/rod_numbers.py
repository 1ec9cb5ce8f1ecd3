"""What the kernel is told of a step's method and length (`kernels.records.Forcing.numbers`), and masses with drag."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .kernels.records import DRAG, FRICTION, LED, ROOT_MASS, TORSION, VELOCITY_STEP, Flags, Forcing, Material
from .kernels.rod_scratch import PACK
from .kernels.rod_start import VELOCITY_RATE
from .material import LED_FLAT, LED_MOST, stretch_rates
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
LEAST_DAMPING = {False: 0.25, True: 0.5}
"""Share of a step that inner damping of grooms with coils is at least, by BDF2 where True. The reaction to rest shapes
on the edges that carry them is that before the step, which rocks tight curls without it."""
LED_DAMPING, LED_DAMPED = 0.75, 0.5
"""The same where BDF2 is led to the reaction, from the latter share of the longest such step on; less in shorter
ones, of which it is right to a higher order."""


def longest_led(
    rod: Rod, flags: Flags, material: Material, forcing: Forcing, edges: Sequence[NDArray[np.float64]]
) -> float:
    """The longest steps, in seconds, in which rest shapes are led by how strands move, by BDF2 or where sections are
    oval; in longer ones, which coils would not bear it in, a step's iterations follow them instead. ``edges``: N arrays
    (strands, 3) as the strands begin."""
    if not flags.curled or not (flags.second or flags.oval):
        return 0.0
    packs, rows, _ = material.bends.shape
    bends = material.bends[:, 2:].reshape(packs, rows - 2, 3, PACK)
    square = np.einsum("pncs,pncs->ps", bends, bends) / max(rows - 2, 1)
    rates = stretch_rates(float(forcing.numbers[TORSION]), material.stiffness, square, rows - 1)
    long = np.linalg.norm(np.mean(edges, axis=0), axis=1)
    turning = np.sqrt(square).reshape(-1)[: len(long)] * (rows - 1)
    most = np.minimum(LED_MOST, LED_FLAT * long / np.maximum(turning, TINY))
    return float((most / np.maximum(rates.reshape(-1)[: len(long)], TINY)).min())


class StepNumbers:
    """Writes the numbers of steps, and nothing where they are those of the step before. ``mass`` (N,) is that of
    particles without what drag adds; ``coiled``: whether some strand is a coil; ``longest_led``: what `longest_led`
    returns."""

    def __init__(
        self, rod: Rod, material: Material, forcing: Forcing, mass: NDArray[Any], gravity: tuple[float, ...],
        second: bool, coiled: bool, longest_led: float,
    ) -> None:  # fmt: skip
        self._mass = mass
        self._rod, self._material, self._forcing = rod, material, forcing
        self._gravity = gravity
        self._second, self._coiled, self.longest_led = second, coiled, longest_led
        self._last: tuple[float, bool, bool] | None = None
        self._dragged: float | None = None

    def set(self, dt: float, bdf2: bool, pinned: bool) -> None:
        """Write those of a step of ``dt`` seconds, but for the air. ``pinned``: whether tips are."""
        if self._last == (dt, bdf2, pinned):
            return
        rod = self._rod
        h, velocity_step = (2 * dt / 3, dt / VELOCITY_RATE) if bdf2 else (dt, dt)
        damping = max(rod.damping, self._least_damping(dt) * dt) * (h / dt)
        share = 1 / 3 if bdf2 else 0.0
        self._write(velocity_step, pinned, h, *self._gravity, 0.0, 0.0, 0.0, rod.drag, damping, share, rod.friction)
        self._forcing.numbers[LED] = dt <= self.longest_led and (bdf2 or oval(rod))
        self._last = dt, bdf2, pinned

    def _least_damping(self, dt: float) -> float:
        if not self._coiled:
            return 0.0
        if not self._second or dt > self.longest_led:
            return LEAST_DAMPING[self._second]
        return min(1.0, dt / (LED_DAMPED * self.longest_led)) * LED_DAMPING

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
