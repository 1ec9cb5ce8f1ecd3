"""Colours that a file has for its strands, as a palette of a few."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..exchange.strands import Strands

MOST = 256
"""Colours of a palette."""
GAMMA = 2.2
"""Of the encoding in which colours are told apart."""


@dataclass(frozen=True, eq=False)
class Colours:
    """Linear colours of strands: a palette (k, 3), k ≥ 2, and of each strand (S,) its tone in [−1, 1], at which the
    palette's colours stand evenly."""

    palette: NDArray[np.float32]
    tones: NDArray[np.float32]

    @property
    def mean(self) -> tuple[float, float, float]:
        """The colour of all strands together."""
        rows = np.rint((self.tones + 1) * 0.5 * (len(self.palette) - 1)).astype(np.int64)
        red, green, blue = self.palette[rows].mean(axis=0, dtype=np.float64).tolist()
        return red, green, blue


def colours_of(strands: Strands) -> Colours | None:
    """The colours of strands, each the mean of its points'; None where the file has none, one grey for all that stands
    for none, or some that are none."""
    found = strands.attributes.get("colour")
    if found is None or found.domain == "groom" or found.values.ndim != 2 or found.values.shape[1] < 3:
        return None
    values = found.values[:, :3].astype(np.float32)
    if found.values.dtype == np.uint8:
        values /= 255
    if not values.size or (values == values[0, 0]).all() or not (np.isfinite(values) & (values >= 0)).all():
        return None
    if found.domain == "point":
        sums = np.add.reduceat(values, strands.first[:-1], axis=0)
        values = (sums / strands.counts()[:, None]).astype(np.float32)
    palette, rows = _palette(np.minimum(values, 1))
    if len(palette) == 1:
        palette = np.repeat(palette, 2, axis=0)
    return Colours(palette, (2 * rows / (len(palette) - 1) - 1).astype(np.float32))


def _palette(values: NDArray[np.float32]) -> tuple[NDArray[np.float32], NDArray[np.int64]]:
    """At most `MOST` colours (k, 3) for (S, 3), and of each strand (S,) the row of its own."""
    palette, rows = np.unique(values, axis=0, return_inverse=True)
    if len(palette) <= MOST:
        return palette, rows.reshape(-1)
    from PIL import Image

    encoded = np.rint(255 * values ** (1 / GAMMA)).astype(np.uint8)
    picked = Image.fromarray(encoded[None]).quantize(MOST, method=Image.Quantize.MEDIANCUT)
    used, rows = np.unique(np.asarray(picked).reshape(-1), return_inverse=True)
    counts = np.bincount(rows)
    means = np.stack([np.bincount(rows, values[:, c]) / counts for c in range(3)], axis=1)
    return means[: len(used)].astype(np.float32), rows.reshape(-1)
