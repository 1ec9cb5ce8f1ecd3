"""Strands within bounds of length."""

from __future__ import annotations

from ...counted import counted
from ..change import Change
from ..strands import Strands


def between(strands: Strands, least: float, most: float) -> tuple[Strands, Change]:
    """The strands of a length from ``least`` to ``most``, in units of the points."""
    lengths = strands.lengths()
    short, long = int((lengths < least).sum()), int((lengths > most).sum())
    changed = strands.select((lengths >= least) & (lengths <= most))
    text = f"{counted(short + long, 'strand')} left out by length: {short:,} too short, {long:,} too long"
    return changed, Change("length", text, {"too_short": short, "too_long": long, "kept": changed.count})
