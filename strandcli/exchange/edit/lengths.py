"""Strands within bounds of length."""

from __future__ import annotations

import numpy as np

from ...counted import counted
from ..change import Change
from ..strands import Strands


def between(strands: Strands, least: float, most: float) -> tuple[Strands, Change]:
    """The strands of a length from ``least`` to ``most``, in units of the points."""
    keep, short, long = np.empty(strands.count, np.bool_), 0, 0
    for rows, (lengths,) in strands.sums(lambda rows, points, segments: segments.astype(np.float64)[None]):
        keep[rows] = (lengths >= least) & (lengths <= most)
        short += int(np.count_nonzero(lengths < least))
        long += int(np.count_nonzero(lengths > most))
    changed = strands.select(keep)
    text = f"{counted(short + long, 'strand')} left out by length: {short:,} too short, {long:,} too long"
    return changed, Change("length", text, {"too_short": short, "too_long": long, "kept": changed.count})
