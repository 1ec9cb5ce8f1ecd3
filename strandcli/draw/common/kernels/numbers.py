"""Plain numbers in single precision: literals of kernels would be of double precision."""

from __future__ import annotations

import math

import numpy as np

ZERO, HALF, ONE, TWO, THREE = (np.float32(number) for number in (0.0, 0.5, 1.0, 2.0, 3.0))
INF = np.float32(np.inf)
INV_PI = np.float32(1.0 / math.pi)
STEPS = np.arange(128, dtype=np.float32)
"""0, 1, …: the numbers of lanes, or of places along a row."""
