"""Strands in blocks: ``[block][row][xyz][lane]``, float32, W strands a block, one lane a strand.

Row 0 stands one segment before the root, along the strand's direction: with it the first segment needs no special case
(thesis §2, stiffness: for i = 1, d_1 = L d). Row 1 is the root. The last block is padded with copies of its last
strand, so that padding can neither fail nor differ.

Neighbours are put beside each other: every prefix of the order of emission covers the emitter, so sixteen consecutive
strands are far apart. A kernel processes so many at once, and does for all what one requires: another iteration,
contact with a solid. Neighbours require the same, and affect the same pixels and texels.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..constants import W
from .record import Groom

Array = NDArray[np.float32]


LINE = 64
"""Bytes that processors fetch at once."""
LARGE_PAGE = 1 << 21
"""Bytes of a large page."""
ADVISED = 1 << 22
"""Bytes of an array from which on NumPy asks the system for large pages."""
_made = itertools.count()
"""How many arrays there are on large pages."""


def aligned(shape: tuple[int, ...], dtype: Any = np.float32) -> NDArray[Any]:
    """Zeros that begin where a cache line does, so that no vector lies across two."""
    kind = np.dtype(dtype)
    raw = np.zeros(int(np.prod(shape)) * kind.itemsize + LINE, np.uint8)
    first = -raw.ctypes.data % LINE
    return raw[first : raw.size - LINE + first].view(kind).reshape(shape)


def on_large_pages(shape: tuple[int, ...], dtype: Any = np.float32) -> NDArray[Any]:
    """Zeros as of `aligned`, on pages of 2 MB where the system has them and the array fills half of one. What is read
    seldom is found sooner then: its places are no longer known to the processor, which keeps them page by page."""
    kind = np.dtype(dtype)
    size = int(np.prod(shape)) * kind.itemsize
    if size < LARGE_PAGE // 2:
        return aligned(shape, dtype)
    apart = next(_made) % 8 * 17 * LINE  # arrays that begin alike would share lines of the first-level cache
    raw = np.zeros(max(size + apart + LARGE_PAGE, ADVISED), np.uint8)
    first = -raw.ctypes.data % LARGE_PAGE + apart
    return raw[first : first + size].view(kind).reshape(shape)


def lanes(rows: NDArray[np.floating], dtype: Any = np.float32, width: int = W) -> NDArray[Any]:
    """(strands, k) values a strand -> (blocks, k * width): value 0 of every lane, then value 1, ..., in blocks of
    ``width`` strands."""
    strands, k = rows.shape
    blocks = -(-strands // width)
    padded = np.empty((blocks * width, k), dtype)
    padded[:strands] = rows
    padded[strands:] = rows[-1]
    out = aligned((blocks, k * width), dtype)
    out.reshape(blocks, k, width)[...] = padded.reshape(blocks, width, k).transpose(0, 2, 1)
    return out


def pack(positions: NDArray[np.floating]) -> Array:
    """(strands, rows, 3) -> (blocks, rows, 3 W)."""
    strands, rows, _ = positions.shape
    blocks = -(-strands // W)
    packed = np.empty((blocks, rows, 3 * W), np.float32)
    for row in range(rows):
        packed[:, row] = lanes(positions[:, row])
    return packed


def unpack(packed: Array, strands: int) -> Array:
    """(blocks, rows, 3 W) -> (strands, rows, 3), without the padding."""
    blocks, rows, _ = packed.shape
    wide = packed.reshape(blocks, rows, 3, W).transpose(0, 3, 1, 2)
    return np.ascontiguousarray(wide).reshape(blocks * W, rows, 3)[:strands]


LEAF = 16
"""Strands of a leaf of the tree: those of a vector."""


def arranged(groom: Groom, ends: Sequence[int] = ()) -> Groom:
    """Return the same strands in an order by position; ``places`` are their numbers in the old order. ``ends``: of
    tiers in that, whose strands stay apart, so that the first of them are the same without the rest."""
    cuts = sorted({0, *(end for end in ends if end < groom.strands), groom.strands})
    parts = [begin + spatial_order(groom.roots[begin:end]) for begin, end in pairwise(cuts)]
    order = np.concatenate(parts).astype(np.int32)
    return replace(groom.of(order), places=order if groom.places is None else groom.places[order])


def spatial_order(points: NDArray[np.floating]) -> NDArray[np.int32]:
    """Return an order of points (N, D) in which each `LEAF` consecutive ones, and each twice, four times … as many, are
    near each other: the leaves, left to right, of a k-d tree split across the longest side (Friedman, Bentley & Finkel
    1977). Ties keep their order."""
    count = len(points)
    order = np.arange(count, dtype=np.int32)
    columns = [np.array(points[:, axis]) for axis in range(points.shape[1])]
    del points  # of which there is no other reference
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
