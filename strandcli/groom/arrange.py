"""Reordering of strands, so that neighbours are adjacent in memory.

Every prefix of the order of emission covers the emitter, so sixteen consecutive strands are far apart. A kernel
processes so many at once, and does for all what one requires: another iteration, contact with a solid. Neighbours
require the same, and affect the same pixels and texels.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from .record import Groom

LEAF = 16
"""Strands of a leaf of the tree: those of a vector."""


def arranged(groom: Groom, ends: Sequence[int] = ()) -> Groom:
    """Return the same strands in an order by position; ``places`` are their numbers in the old order. ``ends``: of
    tiers in that, whose strands stay apart, so that the first of them are the same without the others."""
    cuts = sorted({0, *(end for end in ends if end < groom.strands), groom.strands})
    parts = [begin + spatial_order(groom.roots[begin:end]) for begin, end in pairwise(cuts)]
    order = np.concatenate(parts).astype(np.int32)
    return replace(
        groom,
        roots=groom.roots[order],
        directions=groom.directions[order],
        lengths=groom.lengths[order],
        tones=groom.tones[order],
        bend=None if groom.bend is None else groom.bend._replace(inward=groom.bend.inward[order]),
        phases=None if groom.phases is None else groom.phases[order],
        grown=None if groom.grown is None else groom.grown[order],
        anchors=None if groom.anchors is None else groom.anchors.of(order),
        places=order if groom.places is None else groom.places[order],
    )


def spatial_order(points: NDArray[np.floating]) -> NDArray[np.int32]:
    """Return an order of points (N, D) in which each `LEAF` consecutive ones, and each twice, four times … as many, are
    near each other: the leaves, left to right, of a k-d tree split across the longest side (Friedman, Bentley & Finkel
    1977). Ties keep their order."""
    count = len(points)
    order = np.arange(count, dtype=np.int32)
    columns = [np.array(points[:, axis]) for axis in range(points.shape[1])]
    del points  # which nobody else may hold
    size = LEAF
    while size < count:
        size *= 2
    while size > LEAF:
        full = count - count % size
        for begin, end, row in ((0, full, size), (full, count, count - full)):
            if begin < end and row > LEAF:
                boxes = [column[begin:end].reshape(-1, row) for column in columns]
                turn = _along_longest(boxes)
                turn += np.arange(begin, end, row)[:, None]
                for values in (order, *columns):
                    values[begin:end] = values[turn.reshape(-1)]
        size //= 2
    return order


def _along_longest(boxes: list[NDArray[np.floating]]) -> NDArray[np.int64]:
    """Return the order of the points of each row along the longest side of its bounding box, (rows, points); boxes:
    their x, y and z, (rows, points) each."""
    longest = np.argmax([np.ptp(box, axis=1) for box in boxes], axis=0)
    along = np.choose(longest[:, None], boxes)
    return np.argsort(along, axis=1, kind="stable")
