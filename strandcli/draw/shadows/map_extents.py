"""Nearest and farthest depths in the texels of min/max maps, and in the cells of opacity maps."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..common.scratch import Scratch
from .kernels import cell_extents, opacity

EMPTY_TEXEL = np.array([np.inf, -np.inf], np.float32).view(np.uint64)[0]  # one number: filled in one pass
STEEPEST = 4.0
"""Texels of depth by which strands in the cells about a cell widen its extents. What is farther before it, a stray
hair, stays in its own cells: soft shadows on solids are as wide as cells say that strands are far away."""


def allocate_extents(
    sizes: NDArray[np.int64], deep: NDArray[np.bool_], scratch: Scratch
) -> tuple[NDArray[np.int64], NDArray[np.float32] | None, list[NDArray[np.float32]]]:
    """Allocate empty extents of all maps; return `starts`, `texels` and `extents` of `ShadowMaps`."""
    counts = np.where(deep, sizes**2 // opacity.TEXELS, sizes**2)
    begin = np.concatenate([[0], np.cumsum(np.where(deep, 0, counts))]).astype(np.int64)
    every = scratch.borrow("texels", (int(counts.sum()), 2), np.float32)
    every.view(np.uint64).fill(EMPTY_TEXEL)
    extents: list[Any] = [None] * len(sizes)
    at = 0
    for number in np.argsort(deep, kind="stable"):  # min/max maps first, so that their texels are one array
        extents[number] = every[at : at + counts[number]]
        at += int(counts[number])
    return begin[:-1], None if deep.all() else every[: int(begin[-1])], extents


def spread_extents(extents: NDArray[np.float32], side: int, texel: float, scratch: Scratch) -> None:
    """Widen the extents of the cells of an opacity map, ``side`` × ``side``, by those of the cells about them; texel:
    metres."""
    found = scratch.borrow("spread_extents", cell_extents.room_of(side), np.float32)
    cell_extents.spread(extents, side, np.float32(STEEPEST * texel), found)
