"""What a polyline with square ends and mitred joints covers, by points: no analytic area anywhere."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def covered(line: Array, widths: Array, width: int, height: int, samples: int = 16) -> Array:
    """(height, width): the share of each pixel's samples × samples points that lie within half the width of the line.

    line (n, 2) pixels, widths (n,) pixels at its vertices. A point belongs to a piece between the two lines that halve
    the angles at its ends.
    """
    at = (np.arange(samples) + 0.5) / samples
    x = (np.arange(width)[:, None] + at).ravel()
    y = (np.arange(height)[:, None] + at).ravel()
    points = np.stack(np.meshgrid(x, y), -1)
    inside = np.zeros(points.shape[:2], bool)
    ways = np.diff(line, axis=0)
    ways /= np.linalg.norm(ways, axis=1)[:, None]
    for i, way in enumerate(ways):
        before = way if i == 0 else ways[i - 1] + way
        after = way if i == len(ways) - 1 else way + ways[i + 1]
        past = points - line[i]
        along = past @ way
        length = np.linalg.norm(line[i + 1] - line[i])
        share = np.clip(along / length, 0, 1)
        half = (widths[i] + share * (widths[i + 1] - widths[i])) / 2
        across = np.abs(past @ np.array([-way[1], way[0]]))
        inside |= (past @ before >= 0) & ((points - line[i + 1]) @ after < 0) & (across <= half)
    return inside.reshape(height, samples, width, samples).mean((1, 3))
