"""Wind: p_i' = p_i + w Δt² |w × d_i| / |w|, d_i = p_i − p_{i−1} (thesis §2): strands across the wind catch more of it.

As printed the acceleration grows with the length of a segment; ``per_length: false`` divides that length out. The
source has w "change a little over time"; here gusts are a sum of three smooth waves of unrelated periods, with seeded
phases, and may travel over the strands with a wavelength, as over a field of grass. The waves are piecewise cubic, so
that every machine computes the same bits.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from ...scene.fields import Vector, boolean, number, vector
from ...scene.motion import sine_cosine
from .rule import Moment, Pass

if TYPE_CHECKING:
    from ...scene.model import Scene

name = "wind"
order = 20.0

PULL_X, PULL_Y, PULL_Z, DIRECTION_X, DIRECTION_Y, DIRECTION_Z = range(6)
"""Columns of p: w Δt², and w / |w|."""
# Periods in units of the gust period, and amplitudes that add up to one.
WAVES = ((1.0, 0.55), (0.4142, 0.3), (0.1716, 0.15))


@dataclass(frozen=True, slots=True)
class Parameters:
    """A wind w of a direction, a strength and gusts."""

    direction: Vector = vector((1.0, 0.0, 0.0), unit="1", nonzero=True, doc="direction in which the wind blows")
    strength: float = number(
        10.0, low=0, unit="1/s²", doc="|w|; in m/s² without per_length; for rods the air speed in m/s"
    )
    per_length: bool = boolean(True, doc="acceleration grows with segment length, as the thesis prints it")
    gust: float = number(0.0, low=0, high=1, doc="fraction of the strength that varies")
    sway: float = number(0.0, low=0, high=90, unit="deg", doc="amplitude of the direction's swing")
    period: float = number(2.0, above=0, unit="s", doc="period of the longest gust")
    wavelength: float = number(0.0, low=0, unit="m", doc="wavelength of the longest gust; 0: uniform")


def fitted(period: float, loop: float) -> float:
    """The period nearest to one that fits a whole number of times into a ``loop``, by frequency; 0: there is none."""
    return loop / max(round(loop / period), 1) if loop > 0 else period


def gusts(time: float, period: float, phases: Any, loop: float = 0.0, along: Any = 0.0) -> Any:
    """Gust factor between -1 and 1 at a time, of smooth waves that are cubic in each half; ``phases`` holds one number
    in [0, 1) a wave. Repeats after ``loop`` seconds, where that is not 0; comes later by the place ``along`` the wind,
    in wavelengths."""
    total = 0.0
    for (scale, a), phase in zip(WAVES, phases, strict=True):
        u = time / fitted(period * scale, loop) + phase - along / scale
        t = abs(2.0 * (u - u // 1.0) - 1.0)
        total = total + a * (1.0 - 2.0 * t * t * (3.0 - 2.0 * t))
    return total


def phases(seed: int) -> Any:
    """(6,) numbers in [0, 1): where the three waves of the strength and those of the sway begin."""
    import numpy as np

    return np.random.Generator(np.random.Philox(key=(seed, 101))).random(6)


def travels(parameters: Parameters) -> bool:
    """Whether gusts travel downwind, and differ from strand to strand."""
    return parameters.wavelength > 0 and parameters.gust > 0


def apply(a: Any, b: Any, c: Any, length: Any, p: Any) -> Any:
    """Return a particle's place after the wind as printed; p: columns above."""
    dx = a[0] - b[0]
    dy = a[1] - b[1]
    dz = a[2] - b[2]
    cx = p[DIRECTION_Y] * dz - p[DIRECTION_Z] * dy
    cy = p[DIRECTION_Z] * dx - p[DIRECTION_X] * dz
    cz = p[DIRECTION_X] * dy - p[DIRECTION_Y] * dx
    m = math.sqrt(cx * cx + cy * cy + cz * cz)
    return a[0] + p[PULL_X] * m, a[1] + p[PULL_Y] * m, a[2] + p[PULL_Z] * m


def apply_by_angle(a: Any, b: Any, c: Any, length: Any, p: Any) -> Any:
    """Return the place as `apply`, with the segment's rest length divided out: only its angle to the wind counts."""
    dx = a[0] - b[0]
    dy = a[1] - b[1]
    dz = a[2] - b[2]
    cx = p[DIRECTION_Y] * dz - p[DIRECTION_Z] * dy
    cy = p[DIRECTION_Z] * dx - p[DIRECTION_X] * dz
    cz = p[DIRECTION_X] * dy - p[DIRECTION_Y] * dx
    m = math.sqrt(cx * cx + cy * cy + cz * cz) / length
    return a[0] + p[PULL_X] * m, a[1] + p[PULL_Y] * m, a[2] + p[PULL_Z] * m


def downwind(parameters: Parameters, time: float, phases: Any, loop: float = 0.0) -> tuple[float, float, float]:
    """Unit direction of the wind, swung about +y by the sway of this moment."""
    x, y, z = parameters.direction
    size = math.sqrt(x * x + y * y + z * z)
    s, c = sine_cosine(parameters.sway * gusts(time, 1.618 * parameters.period, phases, loop))
    return (c * x + s * z) / size, y / size, (c * z - s * x) / size


def idle(parameters: Parameters, scene: Scene) -> str:
    """Why this rule has nothing to do, or nothing."""
    return "" if parameters.strength > 0 else "its strength is zero"


def passes(parameters: Parameters, scene: Scene) -> list[Pass]:
    """One pass, the simplest that the parameters allow."""
    import numpy as np

    from . import wind_travelling

    shift = phases(scene.seed).tolist()
    travelling = travels(parameters)
    loop = scene.time.period

    def prepare(moment: Moment) -> Any:
        d = downwind(parameters, moment.time, shift[3:], loop)
        strength = parameters.strength * moment.step**2
        if not travelling:
            strength *= 1.0 - parameters.gust * 0.5 * (1.0 - gusts(moment.time, parameters.period, shift[:3], loop))
            return np.array([strength * d[0], strength * d[1], strength * d[2], *d], np.float32)
        waves = [
            part
            for (scale, a), phase in zip(WAVES, shift[:3], strict=True)
            for part in (1 / scale, a, (moment.time / fitted(parameters.period * scale, loop) + phase) % 1.0)
        ]
        by = (1.0, 0.0) if parameters.per_length else (0.0, 1.0)
        # waves travel along the mean direction: with the swaying one, far from the origin, they would race sideways
        mean = np.array(parameters.direction) / np.linalg.norm(parameters.direction)
        head = [*(strength * np.array(d)), *d, parameters.gust, *(mean / parameters.wavelength)]
        return np.array([*head, *waves, *by], np.float32)

    if travelling:
        return [Pass(wind_travelling.apply, prepare)]
    return [Pass(apply if parameters.per_length else apply_by_angle, prepare, "lane", 6)]
