"""Keys of the z-buffer: the inverse depth, complemented so that nearer is smaller, above an identity."""

from __future__ import annotations

import numpy as np

EMPTY = np.uint64(0xFFFFFFFFFFFFFFFF)
LOW = np.uint64(0xFFFFFFFF)
"""Mask of the identity."""
SHIFT = np.uint64(32)
"""Bits of the identity."""
FIRST = np.uint64(0xFFF00000)
"""Identities from here on are solids', a million of them, the others segments'."""
