"""Strands in an order in which those near each other follow each other.

They add to the same cells of a map, which then are in the processor's cache. Sums are rounded otherwise in another
order, so the order is that of places on the map, and does not depend on the bands.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..common.scratch import Scratch
from ..zbuffer.raster import Bands, sort_into_bands
from .kernels.opacity_maps import PART, PARTS

BITS = 8
"""Of a place, of each coordinate: 256 × 256 tiles, of two to eight texels, sort as 16-bit numbers."""


def sort_by_place(
    first: NDArray[np.int64], screen: NDArray[np.float32], side: int, margin: float, workers: int, scratch: Scratch
) -> Bands:
    """Return `sort_into_bands` of a map with ``side`` texels a side, the strands of each band in the order of a Z-curve
    through their middle vertices.

    first (S + 1,): vertex offsets; screen (V, 3): x and y in texels, and the depth number; margin: texels.
    """
    bands = sort_into_bands(first, screen, side, margin, workers, scratch)
    if len(screen) == 0:
        return bands._replace(begin=np.zeros_like(bands.begin))  # nothing to draw
    segments = np.maximum(np.diff(first) - 1, 0)[:, None]
    begin = PART * np.arange(PARTS)
    there = begin < np.maximum(segments, 1)
    middle = first[:-1, None] + np.minimum(begin + PART // 2, (begin + segments) // 2)
    middle = np.nan_to_num(screen[np.minimum(middle, len(screen) - 1).ravel(), :2])  # strands may have no vertices
    places = np.clip(middle * np.float32(2**BITS / side), 0, 2**BITS - 1).astype(np.uint16)
    keys = (_apart(places[:, 0]) | _apart(places[:, 1]) << 1).reshape(there.shape)
    numbers = np.arange(keys.size, dtype=np.int32).reshape(keys.shape)
    members, ends = [], [0]
    for first_of_band, end in pairwise(bands.begin):
        own = bands.members[first_of_band:end]
        parts = numbers[own][there[own]]
        members.append(parts[np.argsort(keys.ravel()[parts], kind="stable")])
        ends.append(ends[-1] + len(parts))
    return bands._replace(members=np.concatenate(members), begin=np.array(ends))


def _apart(x: NDArray[np.uint16]) -> NDArray[np.uint16]:
    """Return numbers of eight bits with a zero bit after each."""
    found: NDArray[Any] = x
    for shift, mask in ((4, 0x0F0F), (2, 0x3333), (1, 0x5555)):
        found = (found | found << shift) & mask
    return found.astype(np.uint16)
