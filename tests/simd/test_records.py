"""Vectors that are kept as records."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numba import njit

from strandcli.constants import VECTOR
from strandcli.simd import (
    deinterleave,
    deinterleaved,
    half_width_pointer,
    interleaved,
    lane_count,
    load,
    load_quadruples,
    load_triple,
    pointer,
    store,
    store_records,
)


@njit
def recorded(given, out):
    """Eight vectors as records."""
    rows = pointer(given)
    n = lane_count(rows)
    a, b, c, d = load(rows, 0), load(rows, n), load(rows, 2 * n), load(rows, 3 * n)
    e, f, g, h = load(rows, 4 * n), load(rows, 5 * n), load(rows, 6 * n), load(rows, 7 * n)
    store_records(pointer(out), 0, (a, b, c, d, e, f, g, h))


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_the_first_number_of_a_record_is_of_the_first_vector(dtype: Any) -> None:
    given = np.arange(8 * VECTOR // np.dtype(dtype).itemsize).astype(dtype)
    out = np.zeros_like(given)
    recorded(given, out)
    np.testing.assert_array_equal(out.reshape(-1, 8), given.reshape(8, -1).T)


@njit
def taken_in_turns(given, out):
    """Four vectors of numbers that take turns."""
    rows, kept = pointer(given), pointer(out)
    vectors = load_quadruples(rows, 1)
    for column in range(4):
        store(kept, column * lane_count(rows), vectors[column])


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_every_fourth_number_is_of_the_same_vector(dtype: Any) -> None:
    given = np.arange(4 * VECTOR // np.dtype(dtype).itemsize + 1).astype(dtype)
    out = np.zeros_like(given[1:])
    taken_in_turns(given, out)
    np.testing.assert_array_equal(out.reshape(4, -1), given[1:].reshape(-1, 4).T)


@njit
def apart_and_together(given, apart, together):
    """Even numbers and odd ones of a vector, and back from vectors that begin with those."""
    rows, half = pointer(given), half_width_pointer(apart)
    count = lane_count(rows)
    even, odd = deinterleaved(load(rows, 0))
    store(half, 0, even)
    store(half, count, odd)
    first, second = interleaved(load(pointer(apart), 0), load(pointer(apart), count))
    store(pointer(together), 0, first)
    store(pointer(together), count, second)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_even_numbers_come_before_odd_ones_and_go_back_between_them(dtype: Any) -> None:
    given = np.arange(VECTOR // np.dtype(dtype).itemsize).astype(dtype)
    apart, together = np.zeros((2, len(given)), dtype), np.ones((2, len(given)), dtype)
    apart_and_together(given, apart.reshape(-1), together.reshape(-1))
    np.testing.assert_array_equal(apart[:, : len(given) // 2], given.reshape(-1, 2).T)
    np.testing.assert_array_equal(together, [given, np.zeros_like(given)])


@njit
def deal_all(given, o, count, work, to, stride):
    """From one array to the other."""
    deinterleave(half_width_pointer(given), o, count, work, to, stride)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("count", [0, 1, 7, 8, 9, 21])
def test_triples_are_dealt_out_and_nothing_beyond_them(dtype: Any, count: int) -> None:
    given = np.arange(3 * count + 2, dtype=dtype)
    work = np.full(100, -1, dtype)
    deal_all(given, 2, count, work, 3, 30)
    expected = np.full(100, -1, dtype)
    for row in range(3):
        expected[3 + 30 * row :][:count] = given[2 + row :: 3][:count]
    np.testing.assert_array_equal(work, expected)


@njit
def triples(given, out):
    rows = pointer(given)
    for i, x in enumerate(load_triple(rows, 1)):
        store(pointer(out), i * lane_count(rows), x)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_three_numbers_take_turns_in_three_vectors(dtype: Any) -> None:
    out = np.zeros(3 * VECTOR // np.dtype(dtype).itemsize, dtype)
    triples(np.array([9.0, 1.0, 2.0, 3.0], dtype), out)
    np.testing.assert_array_equal(out, np.tile([1.0, 2.0, 3.0], len(out) // 3))
