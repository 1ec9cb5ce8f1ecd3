"""Widths that a file has for its strands."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..exchange.strands import WIDTHS, Strands
from ..groom.record import Widths
from .measure import box_of
from .rows import Rows, values_in

LEAST, MOST = 0.02, 200.0
"""How often strands of a believable width cover the box about them, on average."""
FINEST = 2e-5
"""Width over length from which on strands are believed that cover less of it, because they are few."""


@dataclass(frozen=True, eq=False)
class FileWidths:
    """Widths of a file's strands. S: strands."""

    greatest: NDArray[np.float64]
    """(S,) metres, of each strand where it is widest."""
    vary: bool
    """Whether any strand is not as wide at all its points."""

    @property
    def mean(self) -> float:
        """Of the greatest, metres."""
        return float(self.greatest.mean())

    def packed(self, strands: Strands, factor: float, rows: Rows | None, order: NDArray[np.int32], most: int) -> Widths:
        """As factors of the mean, in an ``order`` (S,), at ``most`` points of each strand. ``strands``, ``factor``: as
        of `widths_of`; ``rows``: of `rows_in`."""
        own = self.greatest[order]
        scale = (own / self.mean).astype(np.float32)
        if not self.vary:
            return Widths(scale)
        shares = values_in(strands.first, strands.attributes["width"].values, rows, order, most)
        per = np.divide(factor, own, out=np.zeros_like(own), where=own > 0).astype(np.float32)
        np.minimum(np.multiply(shares, per[:, None], out=shares), 1, out=shares)
        return Widths(scale, shares)


def widths_of(
    strands: Strands, factor: float, lengths: NDArray[np.float64], total: float, notes: list[str]
) -> FileWidths | None:
    """The widths of strands, which are so long each (S,) and, with those that they stand for, ``total`` together,
    metres; ``factor``: metres a unit of the file's widths. None where the file has none, or none that could be meant,
    which is noted."""
    found = strands.attributes.get("width")
    if found is None:
        if not WIDTHS.keys().isdisjoint(strands.source.facts.get("attributes_not_read", ())):
            notes.append("widths of the file are left out: not all of its curves have them, or not a number each")
        return None
    values, vary = found.values, False
    if found.domain == "point":
        each = np.maximum.reduceat(values, strands.first[:-1])
        vary = bool((values != np.repeat(each, strands.counts())).any())
        sound = bool(np.isfinite(each).all() and (values >= 0).all())
    else:
        each = np.broadcast_to(values, strands.count)
        sound = bool((np.isfinite(each) & (each >= 0)).all())
    greatest = factor * each.astype(np.float64)
    mean = float(greatest.mean()) if sound else 0.0
    if not sound or not _believable(strands, mean, float(lengths.mean()), total):
        why = f"at {mean:.3g} m strands would be a blob, or nothing" if sound else "some are negative or not finite"
        notes.append(f"widths of the file are left out: {why}")
        return None
    return FileWidths(greatest, vary)


def _believable(strands: Strands, width: float, length: float, total: float) -> bool:
    """Whether strands may be so wide, which are so long on average, and ``total`` together, metres."""
    low, high = box_of(strands.points)
    x, y, z = high - low + width
    times = 3 * width * total / max(x * y + y * z + z * x, 1e-30)
    return 0 < width <= length and times <= MOST and (times >= LEAST or width >= FINEST * length)
