"""Loose strands that fly so far off that no grid could be about all of them.

What is far from all others has no neighbours: it goes without a grid. So where the box about all strands would have too
many cells, they are parted into groups with empty cells between them, and those groups that a box has room for are in
it, the one of most strands first. Groups are found from places alone, in the order of strands, on one thread.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import crowd_box
from .kernels.crowd_records import Moving
from .kernels.rod_scratch import PACK

Boxes = tuple[float, int, bool]
"""What `crowd_boxes.find_boxes` returns."""
CLEAR = 2.0
"""Cells between those of strands, from which on neither meets the other: a strand counts for its own ones, and pressure
acts on their faces."""


class Apart:
    """Which of so many strands are in no step's grid. ``metres``: `Moving.metres`; ``loose``: whether roots are free:
    others are not left out, for what they take too many cells by is the preset's."""

    def __init__(self, metres: NDArray[np.float32], strands: int, loose: bool, dtype: Any) -> None:
        self._metres, self._strands, self._loose, self._kind = metres, strands, loose, dtype
        self.left_out: NDArray[Any] | None = None
        """As `Moving.left_out`."""

    @property
    def count(self) -> int:
        """Strands that are left out of the last step."""
        return 0 if self.left_out is None else int(self.left_out.reshape(-1)[: self._strands].sum())

    def lay(
        self, find: Callable[[NDArray[Any], float], Boxes], ends: NDArray[Any], positions: NDArray[Any],
        lattice: tuple[float, float, int],
    ) -> Boxes:  # fmt: skip
        """Return what ``find`` returns of the ends of packs, which lays boxes about them if they take no more than so
        many cells: where they do, of those without strands that are left out. ``lattice``: cell, reach and margin as
        `crowd_boxes.find_boxes` takes them."""
        self.left_out = None
        found = find(ends, float(crowd_box.MOST_CELLS))
        if self._loose and found[0] > crowd_box.MOST_CELLS:
            fewer = self._choose(positions, *lattice)
            if fewer is not None:
                return find(fewer, float(crowd_box.MOST_CELLS))
        return found

    def _choose(self, positions: NDArray[Any], cell: float, reach: float, margin: int) -> NDArray[Any] | None:
        """Choose what is left out, and return the ends of packs without it, as `Moving.ends`; None where nothing can
        be."""
        low, high = ends_of(positions)
        cells = cells_of(low[: self._strands], high[: self._strands], cell, reach)
        kept = chosen(groups_of(*cells), *cells, margin)
        if kept.all():
            return None
        kept = np.append(kept, np.full(self._metres.size - len(kept), kept[-1]))  # padding: copies of the last
        self.left_out = np.where(kept, 0, 1).reshape(self._metres.shape).astype(self._kind)
        first = int(np.argmax(kept))
        each = np.concatenate([-low, high], 1)[: len(kept)]
        each[~kept] = each[first]
        return np.ascontiguousarray(each.reshape(-1, PACK, 6).max(1))

    def taken(self, moving: Moving) -> Moving:
        """Return what kernels take of strands."""
        if self.left_out is None:
            return moving
        return moving._replace(left_out=self.left_out, metres=np.where(self.left_out > 0, 0, self._metres))


def ends_of(positions: NDArray[Any]) -> tuple[NDArray[Any], NDArray[Any]]:
    """Return (strands, 3) the least and the greatest coordinates of strands in blocks, those that pad the last, too."""
    rows = positions[:, 1:].reshape(len(positions), -1, 3, positions.shape[2] // 3)
    low, high = (np.moveaxis(each, 1, 2).reshape(-1, 3) for each in (rows.min(1), rows.max(1)))
    return low, high


def cells_of(
    low: NDArray[Any], high: NDArray[Any], cell: float, reach: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return (strands, 3) the lowest and the highest cells of strands, as `crowd_boxes.find_boxes` has them."""
    below = np.floor(low.astype(np.float64) / cell - 0.5 - reach)
    return below, np.floor(high.astype(np.float64) / cell - 0.5 + reach) + 1


def groups_of(low: NDArray[np.float64], high: NDArray[np.float64]) -> NDArray[np.int64]:
    """Return (strands,) numbers of groups of which none is within `CLEAR` cells of another. ``low`` to ``high``
    (strands, 3): the cells of each strand. Sorted into cubes as wide as the longest reaches, with what is to be clear,
    strands that are near each other begin in the same cube or in neighbouring ones: such cubes make a group."""
    side = float((high - low).max()) + CLEAR + 1
    at = np.stack([_numbered(np.floor(low[:, axis] / side)) for axis in range(3)], 1) + 1
    row = int(at.max()) + 2
    steps = np.array([row**2, row, 1])
    cubes, of_strand = np.unique(at @ steps, return_inverse=True)
    pairs = []
    for near in product((-1, 0, 1), repeat=3):
        if near > (0, 0, 0):
            wanted = cubes + np.array(near) @ steps
            found = np.searchsorted(cubes, wanted).clip(max=len(cubes) - 1)
            first = np.flatnonzero(cubes[found] == wanted)
            pairs.append(np.stack([first, found[first]]))
    return joined(len(cubes), *np.concatenate(pairs, 1))[of_strand.reshape(-1)]


def _numbered(values: NDArray[np.float64]) -> NDArray[np.int64]:
    """Return whole numbers that are as far apart as ``values`` where that is 0 or 1, else 2: far ones stay small."""
    known, place = np.unique(values, return_inverse=True)
    return np.append(0, np.cumsum(np.minimum(np.diff(known), 2))).astype(np.int64)[place.reshape(-1)]


def joined(count: int, first: NDArray[np.int64], second: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return (count,) of each thing the number of all that pairs, ``first`` and ``second``, connect it with."""
    lowest = np.arange(count)
    while True:
        least = np.minimum(lowest[first], lowest[second])
        before = lowest.copy()
        np.minimum.at(lowest, before[first], least)
        np.minimum.at(lowest, before[second], least)
        lowest = lowest[lowest]
        if (lowest == before).all():
            return np.unique(lowest, return_inverse=True)[1].reshape(-1)


def chosen(
    groups: NDArray[np.int64], low: NDArray[np.float64], high: NDArray[np.float64], margin: int
) -> NDArray[np.bool_]:
    """Return (strands,) which are in the groups that a box has room for, those of most strands first, and of as many
    that of the first strand. The first group is in it in any case."""
    order = np.argsort(groups, kind="stable")
    begins = np.flatnonzero(np.append(True, np.diff(groups[order]) > 0))
    least, most = np.minimum.reduceat(low[order], begins), np.maximum.reduceat(high[order], begins)
    sizes = np.diff(np.append(begins, len(order)))
    ranked = np.lexsort((order[begins], -sizes))
    kept = np.zeros(len(sizes), np.bool_)
    kept[ranked[0]], below, above = True, least[ranked[0]], most[ranked[0]]
    for group in ranked[1:]:
        wider = np.minimum(below, least[group]), np.maximum(above, most[group])
        if np.prod(wider[1] - wider[0] + 1 + 2 * margin) <= crowd_box.MOST_CELLS:
            kept[group], (below, above) = True, wider
    return np.asarray(kept[groups])
