"""The sRGB transfer function as a table."""

from __future__ import annotations

import functools

import numpy as np
from numpy.typing import NDArray


@functools.cache
def srgb_curve() -> NDArray[np.uint8]:
    """(65536,) uint8: linear [0, 1] in even steps to 8-bit sRGB (IEC 61966-2-1). The steepest part, 12.92 at black, takes
    0.05 of a level a step, so the table is never off by more than rounding."""
    linear = np.arange(65536) / 65535
    encoded = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
    return np.rint(255 * encoded).astype(np.uint8)
