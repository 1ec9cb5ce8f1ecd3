"""Where strands begin in the cells of opacity maps, side by side and not in rows of layers, and in ever larger squares
of cells, by which filter windows know cells that shade nothing (hierarchical depths: Greene, Kass and Miller 1993)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...constants import VECTOR
from ..common.scratch import Scratch
from .kernels import cell_extents, opacity
from .kernels.opacity import SCALE, START

NOTHING = np.full(VECTOR // 4, np.inf, np.float32)
"""Behind the last number: vectors are read from any place on."""
EMPTY_TEXEL = np.array([np.inf, -np.inf], np.float32).view(np.uint64)[0]  # one number: filled in one pass
STEEPEST = 4.0
"""Texels of depth by which strands in the cells about a cell widen its extents. What is farther before it, a stray
hair, stays in its own cells: soft shadows on solids are as wide as cells say that strands are far away."""


def tables_of_cells(
    extents: Sequence[NDArray[np.float32]], layers: Sequence[int], scratch: Scratch
) -> tuple[NDArray[np.float32], NDArray[np.int64]]:
    """Return for each opacity map `START` and `SCALE` of all cells and the `pyramid` of nearest depths, one after the
    other, and where each pyramid begins; extents, layers: of `ShadowMaps`, after `ShadowMaps.divide`."""
    starts = np.zeros(len(layers), np.int64)
    deep = [number for number, count in enumerate(layers) if count]
    total = sum(extents[number].size + sum(_squares(len(extents[number]))) for number in deep)
    out = scratch.borrow("fronts", total + len(NOTHING), np.float32)
    at = 0
    for number in deep:
        heads = extents[number]
        starts[number] = at + heads.size
        out[at : starts[number]] = heads.reshape(-1)
        cells = out[starts[number] :][: len(heads)]
        cells.fill(np.inf)
        np.copyto(cells, heads[:, START], where=heads[:, SCALE] > 0)
        at = int(starts[number]) + pyramid(out[starts[number] :], len(heads))
    out[at:] = NOTHING
    return out, starts


def pyramid(out: NDArray[np.float32], cells: int) -> int:
    """Write after the depths of the cells of a square map, inf where there are none, the least of each 2×2 of them, and
    so on up to a single one; return how many numbers that makes in all."""
    at = 0
    squares = _squares(cells)
    for large, small in pairwise(squares):
        level = out[at : at + large].reshape(math.isqrt(large), -1)
        above = out[at + large :][:small].reshape(math.isqrt(small), -1)
        rows = level[::2].copy()
        np.minimum(rows[: len(level) // 2], level[1::2], out=rows[: len(level) // 2])
        above[...] = rows[:, ::2]
        np.minimum(above[:, : len(level) // 2], rows[:, 1::2], out=above[:, : len(level) // 2])
        at += large
    return sum(squares)


def _squares(cells: int) -> list[int]:
    """The numbers of cells of a square map, of squares of 2×2 of them, and so on to 1."""
    found, side = [cells], math.isqrt(cells)
    while side > 1:
        side = (side + 1) // 2
        found.append(side * side)
    return found


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
