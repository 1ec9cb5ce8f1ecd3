"""Nearest depths of strands in the cells of opacity maps, and in ever larger squares of cells: by four of these numbers
a filter window is known that no strand shades (hierarchical depths: Greene, Kass and Miller 1993)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ...constants import VECTOR
from .kernels.minmax import NEAREST

NOTHING = np.full(VECTOR // 4, np.inf, np.float32)
"""Behind the last number: vectors are read from any place on."""


def nearest_depths(
    extents: Sequence[NDArray[np.float32]], layers: Sequence[int]
) -> tuple[NDArray[np.float32], NDArray[np.int64]]:
    """Return the `pyramid` of each opacity map, one after the other, and where each begins; extents, layers: of
    `ShadowMaps`, before `ShadowMaps.divide`."""
    starts = np.zeros(len(layers), np.int64)
    found: list[NDArray[np.float32]] = []
    at = 0
    for number, count in enumerate(layers):
        if count:
            found.append(pyramid(extents[number][:, NEAREST]))
            starts[number] = at
            at += len(found[-1])
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
