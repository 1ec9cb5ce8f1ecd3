"""Strands so placed that those that move and are drawn together are neighbours.

Strands are emitted in an order of which every prefix covers the emitter: of sixteen in a row no two are near each
other. Kernels take so many at a time, and do for all of them what one needs: another iteration, contact with a solid.
Neighbours need the same, and touch the same pixels and texels.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from .record import Groom

TOGETHER = 16
"""Strands that are as near each other as can be: those of a vector."""


def arranged(groom: Groom) -> Groom:
    """The same strands, neighbours together; ``places`` tells where each was."""
    order = near(groom.roots)
    return replace(
        groom,
        roots=groom.roots[order],
        directions=groom.directions[order],
        lengths=groom.lengths[order],
        tones=groom.tones[order],
        grown=None if groom.grown is None else groom.grown[order],
        places=order if groom.places is None else groom.places[order],
    )


def near(points: NDArray[np.floating]) -> NDArray[np.int32]:
    """An order of points (N, 3) in which every `TOGETHER` in a row, and twice, four times … as many, are near each
    other: the leaves of a tree whose boxes are halved across their longest side (Friedman, Bentley & Finkel 1977), from
    left to right. Points that tie keep their order."""
    count = len(points)
    order = np.arange(count, dtype=np.int32)
    columns = [np.array(points[:, axis]) for axis in range(3)]
    size = TOGETHER
    while size < count:
        size *= 2
    while size > TOGETHER:
        full = count - count % size
        for begin, end, row in ((0, full, size), (full, count, count - full)):
            if begin < end and row > TOGETHER:
                boxes = [column[begin:end].reshape(-1, row) for column in columns]
                turn = _along_longest(boxes) + np.arange(begin, end, row)[:, None]
                for values in (order, *columns):
                    values[begin:end] = values[turn.reshape(-1)]
        size //= 2
    return order


def _along_longest(boxes: list[NDArray[np.floating]]) -> NDArray[np.int64]:
    """For each row of points, whose coordinates are (rows, points) each, their order along its box's longest side."""
    longest = np.argmax([np.ptp(box, axis=1) for box in boxes], axis=0)
    along = np.choose(longest[:, None], boxes)
    return np.argsort(along, axis=1, kind="stable")
