"""Indices that compiled functions are given: for each integer literal Numba would compile the function again."""

import numpy as np

FIRST, SECOND, THIRD = np.int64(0), np.int64(1), np.int64(2)
