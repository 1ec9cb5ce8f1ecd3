"""Widths that a file has for its strands."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..exchange.strands import Strands
from .measure import box_of

LEAST, MOST = 0.02, 200.0
"""How often strands of a believable width cover the box about them, on average."""


@dataclass(frozen=True, eq=False)
class Widths:
    """Diameters near the root, metres: their mean, and of each strand (S,) its factor to that."""

    mean: float
    scale: NDArray[np.float32]


def widths_of(strands: Strands, factor: float, lengths: NDArray[np.float64], notes: list[str]) -> Widths | None:
    """The widths of strands, which are so long each (S,), metres; ``factor``: metres a unit of the file's widths. None
    where the file has none, or none that could be meant, which is noted."""
    found = strands.attributes.get("width")
    if found is None:
        return None
    values = factor * found.values.astype(np.float64).reshape(-1)
    first = strands.first[:-1]
    if found.domain == "groom":
        each = np.full(strands.count, float(values[0]) if values.size else 0.0)
    else:
        each = np.maximum.reduceat(values, first) if found.domain == "point" else values
    mean = float(each.mean()) if np.isfinite(each).all() and (each >= 0).all() else 0.0
    low, high = box_of(strands.points)
    x, y, z = high - low
    side = (x * y + y * z + z * x) / 3
    times = mean * float(lengths.sum()) / max(side, 1e-30)
    if not LEAST <= times <= MOST:
        notes.append(f"widths of the file are left out: at {mean:.3g} m strands would be a blob, or nothing")
        return None
    return Widths(mean, (each / mean).astype(np.float32))
