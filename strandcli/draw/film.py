"""What the film needs beside its kernels: the sRGB transfer function as a table, and the background."""

from __future__ import annotations

import functools

import numpy as np
from numpy.typing import NDArray


@functools.cache
def srgb_curve() -> NDArray[np.uint8]:
    """(65536,) uint8: linear [0, 1] in even steps to 8-bit sRGB (IEC 61966-2-1). The steepest part, 12.92 at black,
    takes 0.05 of a level a step, so the table is never off by more than rounding."""
    linear = np.arange(65536) / 65535
    encoded = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
    return np.rint(255 * encoded).astype(np.uint8)


def gradient(top: NDArray[np.float32], bottom: NDArray[np.float32], height: int) -> NDArray[np.float32]:
    """(height, 3): the background's colour in each row, from that of the top to that of the bottom."""
    t = (np.arange(height, dtype=np.float32)[:, None] + np.float32(0.5)) / np.float32(height)
    return np.asarray(top + t * (bottom - top))
