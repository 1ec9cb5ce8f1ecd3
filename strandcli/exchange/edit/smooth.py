"""Smooth strands."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...counted import counted
from ..change import Change
from ..strands import CHUNK, Strands


def smoothed(strands: Strands, passes: int) -> tuple[Strands, Change]:
    """Strands after so many passes of (1, 2, 1)/4 along each; roots and tips stay where they are."""
    points = strands.points.copy()
    ends = np.zeros(points.shape[0], np.bool_)
    ends[strands.first[:-1]] = True
    ends[strands.first[1:] - 1] = True
    for _ in range(passes):
        before = points[:1].copy()
        for begin in range(1, points.shape[0] - 1, CHUNK):
            part = points[begin : min(begin + CHUNK, points.shape[0] - 1)]
            behind = np.concatenate([before, part[:-1]])
            before = part[-1:].copy()
            new = (behind + 2 * part + points[begin + 1 : begin + 1 + part.shape[0]]) * np.float32(0.25)
            fixed = ends[begin : begin + part.shape[0], None]
            part[:] = np.where(fixed, part, new)
    worst = 0.0
    for begin in range(0, points.shape[0], CHUNK):
        step = points[begin : begin + CHUNK] - strands.points[begin : begin + CHUNK]
        worst = max(worst, float(np.sqrt(np.einsum("ij,ij->i", step, step).max(initial=0))))
    text = f"smoothed in {counted(passes, 'pass', 'passes')}, points moved by at most {worst:.4g}"
    return replace(strands, points=points), Change("smooth", text, {"passes": passes, "moved_max": worst})
