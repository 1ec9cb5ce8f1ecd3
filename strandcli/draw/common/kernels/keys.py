"""Keys of the z-buffer, 64 bits: the depth number, complemented so that nearer is smaller, above an identity."""

from __future__ import annotations

import sys

import numpy as np
from numpy.typing import NDArray

EMPTY = np.uint64(0xFFFFFFFFFFFFFFFF)
"""Key of a sample that shows nothing."""
LOW = np.uint64(0xFFFFFFFF)
"""Mask of the identity."""
SHIFT = np.uint64(32)
"""Bits of the identity."""
FIRST = np.uint64(0xFFF00000)
"""First identity of solids, of which there are up to a million; smaller identities are those of segments."""
HIGH_HALF = int(sys.byteorder == "little")


def depths_of(keys: NDArray[np.uint64], out: NDArray[np.float32] | None = None) -> NDArray[np.float32]:
    """Return the depth numbers of keys (n,), 0 of empty ones; written to ``out`` (n,) where it is given."""
    found = np.empty(len(keys), np.float32) if out is None else out
    np.invert(keys.view(np.uint32)[HIGH_HALF::2], out=found.view(np.uint32))
    return found


def identities_of(keys: NDArray[np.uint64]) -> NDArray[np.uint32]:
    """Return the identities of keys (n,)."""
    return keys.view(np.uint32)[1 - HIGH_HALF :: 2]
