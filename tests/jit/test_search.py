"""Binary search, against NumPy's."""

from __future__ import annotations

from typing import Any

import numpy as np

from strandcli.jit import search


def test_places_are_those_of_numpy() -> None:
    below: Any = search.first_not_below
    above: Any = search.first_above
    rng = np.random.default_rng(1)
    for size in (0, 1, 2, 7, 64, 101):
        numbers = np.sort(rng.integers(0, 20, size)).astype(np.float32)
        for x in np.arange(-1, 22, 0.5, np.float32):
            assert below.py_func(numbers, x) == np.searchsorted(numbers, x)
            assert above.py_func(numbers, x) == np.searchsorted(numbers, x, side="right")
