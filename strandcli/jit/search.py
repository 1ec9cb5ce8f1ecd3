"""Binary search. With `np.searchsorted` a cached kernel has Numba import its linear algebra before it is run, and that
SciPy's: a fifth of a second."""

from __future__ import annotations

from typing import Any

import numpy as np

from . import device


@device
def first_not_below(ascending: Any, x: Any) -> Any:
    """Return how many numbers are less than x."""
    low, high = np.int64(0), np.int64(ascending.shape[0])
    while low < high:
        middle = (low + high) >> 1
        if ascending[middle] < x:
            low = middle + 1
        else:
            high = middle
    return low


@device
def first_above(ascending: Any, x: Any) -> Any:
    """Return how many numbers are not greater than x."""
    low, high = np.int64(0), np.int64(ascending.shape[0])
    while low < high:
        middle = (low + high) >> 1
        if ascending[middle] <= x:
            low = middle + 1
        else:
            high = middle
    return low
