"""The record of strands at rest, which solvers, children and drawing share."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Groom:
    """Strands at rest in the emitter's own frame."""

    roots: NDArray[np.float32]
    """(strands, 3) metres."""
    directions: NDArray[np.float32]
    """(strands, 3) unit vectors."""
    lengths: NDArray[np.float32]
    """(strands,) metres from root to tip."""
    tones: NDArray[np.float32]
    """(strands,) in [-1, 1): how each strand's colour departs from the mean."""

    curl: tuple[float, float] = (0.0, 0.0)
    """Angle in radians between a strand and its own axis, and the turns about it from root to tip."""
    places: NDArray[np.int32] | None = None
    """(strands,) of each its place in the order of emission; None: they stand in it."""
    grown: NDArray[np.float64] | None = None
    """(strands, 3) metres: where strands grow that are tied, whose `roots` are where they are bound; else None."""
    points: NDArray[np.float32] | None = None
    """(blocks, n + 1, 3 W) metres: strands that are given point by point, as `strandcli.blocks` has them; else None."""
    widths: NDArray[np.float32] | None = None
    """(strands,) factor of each strand's width; None: 1."""

    def edge(self, j: int, edges: int) -> NDArray[np.float64]:
        """(strands, 3) unit vectors: the direction at the middle of edge j of so many, root to tip. Curled strands are
        helices, each turned about its axis by its tone."""
        angle, turns = self.curl
        axes = self.directions.astype(np.float64)
        if angle == 0:
            return axes
        first, second = frame(axes)
        around = 2 * np.pi * (turns * (j + 0.5) / edges + self.tones)[:, None]
        return np.asarray(np.cos(angle) * axes + np.sin(angle) * (np.cos(around) * first + np.sin(around) * second))

    @property
    def strands(self) -> int:
        """How many."""
        return len(self.lengths)

    def emitted(self, values: NDArray[Any]) -> NDArray[Any]:
        """What belongs to the strands as they stand here, (strands, …), in the order of emission."""
        if self.places is None:
            return values
        out = np.empty_like(values)
        out[self.places] = values
        return out

    def placed(self, values: NDArray[Any]) -> NDArray[Any]:
        """What belongs to the strands in the order of emission, (strands, …), as they stand here."""
        return values if self.places is None else values[self.places]


def frame(axes: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Two unit vectors across each axis and each other, (strands, 3), without a singular case (Duff et al. 2017,
    "Building an Orthonormal Basis, Revisited")."""
    x, y, z = axes.T
    sign = np.where(z >= 0, 1.0, -1.0)
    a = -1.0 / (sign + z)
    b = x * y * a
    return np.stack([1.0 + sign * x * x * a, sign * b, -sign * x], 1), np.stack([b, sign + y * y * a, -y], 1)
