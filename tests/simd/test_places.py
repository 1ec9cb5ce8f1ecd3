"""Places in rows as whole numbers, in the bits of a vector of floats."""

from __future__ import annotations

import numpy as np
from numba import njit

from strandcli.constants import VECTOR
from strandcli.simd import bits_of_places, lane_count, load, pointer, store


@njit
def placed(given, out):
    """Places of two rows of numbers, each beside the other."""
    rows = pointer(given)
    store(pointer(out), 0, bits_of_places(1 << 28, load(rows, 0), 1000, load(rows, lane_count(rows))))


def test_places_have_all_bits_of_whole_numbers() -> None:
    lanes = VECTOR // 4
    rows, columns = np.arange(lanes) * 7 + 2**20, np.arange(lanes)[::-1] - 3
    out = np.empty(lanes, np.float32)
    placed(np.concatenate([rows, columns]).astype(np.float32), out)
    np.testing.assert_array_equal(out.view(np.int32), (1 << 28) + 1000 * rows + columns)
