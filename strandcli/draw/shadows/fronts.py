"""Where strands begin in the cells of opacity maps, side by side and not in rows of layers, and in ever larger squares
of cells, by which filter windows know cells that shade nothing (hierarchical depths: Greene, Kass and Miller 1993)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ...constants import VECTOR
from .kernels.opacity import SCALE, START

NOTHING = np.full(VECTOR // 4, np.inf, np.float32)
"""Behind the last number: vectors are read from any place on."""


def tables_of_cells(
    extents: Sequence[NDArray[np.float32]], layers: Sequence[int]
) -> tuple[NDArray[np.float32], NDArray[np.int64]]:
    """Return for each opacity map `START` and `SCALE` of all cells and the `pyramid` of nearest depths, one after the
    other, and where each pyramid begins; extents, layers: of `ShadowMaps`, after `ShadowMaps.divide`."""
    starts = np.zeros(len(layers), np.int64)
    found: list[NDArray[np.float32]] = []
    at = 0
    for number, count in enumerate(layers):
        if count:
            heads = extents[number]
            found += [heads.reshape(-1), pyramid(np.where(heads[:, SCALE] > 0, heads[:, START], np.float32(np.inf)))]
            starts[number] = at + heads.size
            at = int(starts[number]) + len(found[-1])
    return np.concatenate([*found, NOTHING]), starts


def pyramid(depths: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return depths (n²,) of the cells of a square map, inf where there are none, followed by the least of each 2×2 of
    them, (⌈n / 2⌉²,), and so on up to a single one."""
    side = round(len(depths) ** 0.5)
    level = depths.reshape(side, side)
    levels = [depths]
    while side > 1:
        side = (side + 1) // 2
        odd = 2 * side - len(level)
        if odd:
            level = np.pad(level, (0, odd), constant_values=np.inf)
        rows = np.minimum(level[::2], level[1::2])
        level = np.minimum(rows[:, ::2], rows[:, 1::2])
        levels.append(level.reshape(-1))
    return np.concatenate(levels)
