"""Keys of the z-buffer, 64 bits: the depth number, complemented so that nearer is smaller, above an identity."""

from __future__ import annotations

import numpy as np

EMPTY = np.uint64(0xFFFFFFFFFFFFFFFF)
"""Key of a sample that shows nothing."""
LOW = np.uint64(0xFFFFFFFF)
"""Mask of the identity."""
SHIFT = np.uint64(32)
"""Bits of the identity."""
FIRST = np.uint64(0xFFF00000)
"""First identity of solids, of which there are up to a million; smaller identities are those of segments."""
