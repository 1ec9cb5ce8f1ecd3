"""A shape with data, for tests: a tube about a polyline, which is a chain of capsules."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from strandcli.jit import device
from strandcli.scene.fields import choice, number
from strandcli.scene.model import SolidSettings

kind = "tube"


@dataclass(frozen=True, slots=True, repr=False)
class Settings(SolidSettings):
    """A tube in a zigzag along its own x axis."""

    kind: str = choice("tube", ("tube",))
    radius: float = number(0.1, above=0, unit="m", doc="of the tube")
    width: float = number(1.0, above=0, unit="m", doc="of all of it")


class Data(NamedTuple):
    """The polylines of all tubes."""

    first: NDArray[np.int64]
    """(tubes + 1,) first point of each."""
    points: NDArray[np.float32]
    """(P, 3) metres."""


def numbers(settings: Settings) -> tuple[float, ...]:
    return (settings.radius,)


def reach(settings: Settings) -> float:
    return settings.width + settings.radius


def data(tubes: Sequence[Settings], time: float) -> Data:
    lines = [line(one) for one in tubes]
    return Data(np.cumsum([0, *map(len, lines)]), np.concatenate(lines).astype(np.float32))


def line(settings: Settings) -> NDArray[np.float64]:
    """(5, 3) the corners of a zigzag."""
    x = np.linspace(-0.5, 0.5, 5) * settings.width
    return np.stack([x, 0.25 * settings.width * (-1.0) ** np.arange(5), np.zeros(5)], 1)


@device
def away(x, y, z, numbers, data):  # type: ignore[no-untyped-def]
    radius, place = numbers
    one = int(place)
    least = math.inf
    for i in range(data.first[one], data.first[one + 1] - 1):
        ax, ay, az = data.points[i, 0], data.points[i, 1], data.points[i, 2]
        bx, by, bz = data.points[i + 1, 0] - ax, data.points[i + 1, 1] - ay, data.points[i + 1, 2] - az
        t = ((x - ax) * bx + (y - ay) * by + (z - az) * bz) / (bx * bx + by * by + bz * bz)
        t = min(max(t, 0.0), 1.0)
        dx, dy, dz = x - ax - t * bx, y - ay - t * by, z - az - t * bz
        least = min(least, math.sqrt(dx * dx + dy * dy + dz * dz))
    return least - radius


def distance(x: Any, y: Any, z: Any, numbers: Any, data: Any) -> Any:
    return away(x, y, z, numbers, data)


def look(x: Any, y: Any, z: Any, eye: Any, width: Any, numbers: Any, data: Any) -> Any:
    """Green towards its own +y, red elsewhere; lifted by a thousandth."""
    h = 1e-3
    nx = away(x + h, y, z, numbers, data) - away(x - h, y, z, numbers, data)
    ny = away(x, y + h, z, numbers, data) - away(x, y - h, z, numbers, data)
    nz = away(x, y, z + h, numbers, data) - away(x, y, z - h, numbers, data)
    return (nx, ny, nz), (x, y, z), ((0.0, 1.0, 0.0) if ny > 0 else (1.0, 0.0, 0.0))
