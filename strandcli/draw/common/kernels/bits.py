"""Bit counts of 64-bit words."""

from __future__ import annotations

import numpy as np

from ....jit import inlined


@inlined
def popcount(x):
    """Return the number of set bits of a uint64, by sums over pairs of bits, groups of four, bytes, and all bytes."""
    x -= (x >> np.uint64(1)) & np.uint64(0x5555555555555555)
    x = (x & np.uint64(0x3333333333333333)) + ((x >> np.uint64(2)) & np.uint64(0x3333333333333333))
    x = (x + (x >> np.uint64(4))) & np.uint64(0x0F0F0F0F0F0F0F0F)
    return (x * np.uint64(0x0101010101010101)) >> np.uint64(56)
