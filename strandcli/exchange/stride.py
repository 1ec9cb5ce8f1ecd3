"""How many points a strand has where a file does not say it: what its jumps tell."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from .strands import CHUNK, Mask, Points

JUMP = 3.0
"""A step to another strand is longer than its neighbours, by this factor."""
FOUND = 0.9
"""Share of the ends of strands that must show as jumps."""
ELSEWHERE = 0.02
"""Share of the jumps that may be elsewhere, at most."""
WITHIN = 1.5
"""A step of at most so many times the smaller one of its neighbours may be within a strand."""
LEAST_STRANDS = 8
"""With fewer, nothing is certain."""
MOST_POINTS = 4096


def divisors(count: int) -> list[int]:
    """The numbers of points a strand that divide ``count``, 2 to `MOST_POINTS`."""
    return [one for one in range(2, min(count, MOST_POINTS) + 1) if count % one == 0]


def guess(points: Points) -> int:
    """The number of points of every strand, 0 where the jumps leave a doubt.

    A jump is a step longer than `JUMP` times both of its neighbours; a number is right where strands end in jumps, and
    jumps are nowhere else. Numbers that divide the right one find too few, its multiples too many elsewhere. Where some
    strands have more points than the rest, it would end within these.
    """
    jump = jumps(points)
    total = np.count_nonzero(jump)
    for one in divisors(points.shape[0]):
        ends = points.shape[0] // one - 1
        if ends + 1 < LEAST_STRANDS:
            break
        there = np.count_nonzero(jump[::one])
        if there >= FOUND * ends and there >= (1 - ELSEWHERE) * total:
            return 0 if _within(points, one) else one
    return 0


def _within(points: Points, count: int) -> bool:
    """Whether strands of so many points each would begin where a strand may go on."""
    for low in range(count, points.shape[0], CHUNK * count):
        begins = np.arange(low, min(low + CHUNK * count, points.shape[0]), count)
        near = [points[begins + one].astype(np.float64) for one in (-2, -1, 0, 1)]
        with np.errstate(invalid="ignore"):  # of points that are not finite
            before, step, after = (np.linalg.norm(b - a, axis=1) for a, b in pairwise(near))
        if (step <= WITHIN * np.minimum(before, after)).any():
            return True
    return False


def jumps(points: Points) -> Mask:
    """Before which points (P,) there is a jump."""
    found = np.zeros(points.shape[0], np.bool_)
    for begin in range(0, points.shape[0], CHUNK):
        low, high = max(0, begin - 1), min(points.shape[0], begin + CHUNK + 2)
        with np.errstate(invalid="ignore"):  # of points that are not finite
            step = np.linalg.norm(np.diff(points[low:high].astype(np.float64), axis=0), axis=1)
        found[low + 2 : high - 1] |= (step[1:-1] > JUMP * step[:-2]) & (step[1:-1] > JUMP * step[2:])
    return found
