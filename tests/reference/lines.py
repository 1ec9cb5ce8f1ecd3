"""Lines into a z-buffer, pixel by pixel: one sample a pixel along the longer axis, at the pixel's centre, for the
half-open range of centres between the ends; the nearest wins, equal depths go to the lower number."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class Samples:
    """What a line covers: ``x``, ``y`` pixels, ``q`` inverse depth, ``doubt`` distance of the sample to the nearest
    border between two pixels, where single precision may fall on the other side."""

    def __init__(self, x: Array, y: Array, q: Array, doubt: Array) -> None:
        self.x, self.y, self.q, self.doubt = x.astype(np.int64), y.astype(np.int64), q, doubt


def samples(a: Array, b: Array, width: int, height: int) -> Samples:
    """Samples of the line from a to b, each (x, y, q) with x, y in pixels."""
    along = 0 if abs(b[0] - a[0]) >= abs(b[1] - a[1]) else 1
    if b[along] < a[along]:
        a, b = b, a
    size = (width, height)
    first = max(int(np.ceil(a[along] - 0.5)), 0)
    last = min(int(np.ceil(b[along] - 0.5)), size[along])
    at = np.arange(first, max(last, first))
    share = (at + 0.5 - a[along]) / (b[along] - a[along]) if len(at) else np.zeros(0)
    across = a[1 - along] + share * (b[1 - along] - a[1 - along])
    cell = np.floor(across)
    keep = (cell >= 0) & (cell < size[1 - along])
    x, y = (at, cell) if along == 0 else (cell, at)
    doubt = np.abs(across - np.rint(across))
    return Samples(x[keep], y[keep], (a[2] + share * (b[2] - a[2]))[keep], doubt[keep])


def picture(segments: list[tuple[Array, Array]], width: int, height: int) -> tuple[NDArray[np.int64], Array, Array]:
    """Number of the segment that is seen in each pixel (-1: none), its q, and how far q is ahead of the next best; all
    (height, width). Pixels that some sample is in doubt about are given a lead of 0."""
    seen = np.full((height, width), -1)
    best = np.zeros((height, width))
    lead = np.full((height, width), np.inf)
    for number, (a, b) in enumerate(segments):
        found = samples(a, b, width, height)
        for x, y, q, doubt in zip(found.x, found.y, found.q, found.doubt, strict=True):
            if doubt < 1e-3:
                lead[max(y - 1, 0) : y + 2, max(x - 1, 0) : x + 2] = 0
            ahead = abs(q - best[y, x]) if seen[y, x] >= 0 else np.inf
            lead[y, x] = min(lead[y, x], ahead)
            if q > best[y, x]:
                seen[y, x], best[y, x] = number, q
    return seen, best, lead
