"""Vectors of lanes against NumPy, number by number, in both precisions."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from numba import njit
from numba.core.registry import cpu_target

from strandcli.constants import VECTOR
from strandcli.simd import (
    ask3,
    deal_out,
    fuses,
    get,
    get3,
    greatest,
    heap,
    heap_at,
    lay,
    lay_at,
    pattern,
    pick,
    put,
    put3,
    root,
    rounded,
    some,
    spread,
    strip,
    tally,
    three,
    where,
    whole,
    width,
)  # fmt: skip
from strandcli.simulate.kernels.tickets import take


@njit(error_model="numpy")
def kernel(given, out):
    """out: a row for each of the things that vectors can do."""
    rows, to = lay(given), heap(out)
    count = width(rows)
    x, y, z = get3(rows, 0, count)
    x += 1
    put(to, 0, x * y - z / 2.0)
    put3(to, 1, 1, -x, abs(z), root(abs(y)))
    put(to, 4, max(x, y))
    put(to, 5, min(y, x))
    put(to, 6, where((x < y) & ~(y <= 0.5) | (x != x), y, 7.0))
    put(to, 7, 1)
    put(to, 8, spread(x, rows[2]))
    put(to, 9, max(min(x, 0.25), -0.25))
    return some(x > 1e9), some(z > 0.0), greatest(where(x > y, x, y)), get(rows, 3)


@njit
def sums(given):
    """A vector from a place that is not a multiple of its length."""
    rows = lay(given)
    return greatest(get(rows, 3)), width(rows)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_lanes_are_numbers(dtype: Any) -> None:
    count = VECTOR // np.dtype(dtype).itemsize
    given = np.random.default_rng(3).normal(size=(3, count)).astype(dtype)
    out = np.zeros((10, count), dtype)
    high, some_positive, most = without_vector(given, out)
    x, y, z = given[0] + dtype(1), given[1], given[2]
    expected = [
        x * y - z / dtype(2), -x, abs(z), np.sqrt(abs(y)), np.maximum(x, y), np.minimum(x, y),
        np.where((x < y) & (y > 0.5), y, dtype(7)), np.ones_like(x), np.full_like(x, given.flat[2]),
        np.clip(x, dtype(-0.25), dtype(0.25)),
    ]  # fmt: skip
    np.testing.assert_array_equal(out, np.array(expected))
    assert not high
    assert some_positive == (z > 0).any()
    assert most == np.maximum(x, y).max()
    assert sums(given) == (given.ravel()[3 : 3 + count].max(), count)


@njit(error_model="numpy")
def without_vector(given, out):
    """`kernel`, without the vector, which has no way out to Python."""
    a, b, c, _ = kernel(given, out)
    return a, b, c


@njit
def halves(given, numbers, out):
    """Half a vector: its whole numbers, and one of these in all lanes; where it is positive."""
    rows, to = strip(given), strip(numbers)
    x = get(rows, 1)
    put(strip(out), 0, whole(x))
    put(to, 2, get(to, 0))
    put(to, 0, np.int64(-7))
    return pattern(x > 0.0), width(rows)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_half_a_vector_has_half_the_lanes(dtype: Any) -> None:
    count = VECTOR // np.dtype(dtype).itemsize // 2
    given = 4 * np.random.default_rng(5).normal(size=2 * count).astype(dtype)
    given[1] = -3.0  # a whole number stays what it is
    out = np.full(2 * count, 99, dtype)
    numbers = np.arange(2 * count, dtype=np.int32)
    bits, wide = halves(given, numbers, out)
    assert wide == count
    np.testing.assert_array_equal(out, [*np.floor(given[1 : count + 1]), *[99] * count])
    assert [bits >> lane & 1 for lane in range(count)] == (given[1 : count + 1] > 0).tolist()
    assert bits < 1 << count
    lanes = VECTOR // 4 // 2
    expected = np.arange(2 * count)
    expected[2 : 2 + lanes] = np.arange(lanes)[: 2 * count - 2]
    expected[:lanes] = -7
    np.testing.assert_array_equal(numbers, expected)


@njit
def picked(given, first, second, out):
    """Numbers from anywhere: by two vectors, and by one and a number."""
    rows, to = lay(given), lay(out)
    x, y = get(lay(first), 0), get(lay(second), 0)
    put(to, 0, pick(rows, 5, x, 7, y))
    put(to, width(to), pick(rows, np.int64(0), x, 3, 2.0))
    return tally(x > y)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_numbers_are_picked_from_where_they_are_said_to_be(dtype: Any) -> None:
    count = VECTOR // np.dtype(dtype).itemsize
    rng = np.random.default_rng(6)
    given, out = rng.normal(size=400).astype(dtype), np.zeros(2 * count, dtype)
    first, second = (rng.integers(0, 40, count).astype(dtype) for _ in range(2))
    assert picked(given, first, second, out) == np.count_nonzero(first > second)
    places = np.concatenate([5 + 7 * first + second, 3 * first + 2]).astype(int)
    np.testing.assert_array_equal(out, given[places])


@njit
def tripled(given, out):
    """Twice three numbers."""
    put(three(out), 1, 2.0 * get(three(given), 1))
    return width(three(out))


def test_three_numbers_are_a_vector() -> None:
    given, out = np.arange(5, dtype=np.float32), np.full(5, 9, np.float32)
    assert tripled(given, out) == 3
    np.testing.assert_array_equal(out, [9, 2, 4, 6, 9])


@njit(error_model="numpy")
def at_an_address(kind, address):
    """The second vector becomes twice what lies one number after the first begins; lanes of both."""
    rows, pile = lay_at(kind, address), heap_at(kind, address)
    put(pile, 1, 2.0 * get(rows, 1))
    return width(rows), width(pile)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_vectors_begin_where_they_are_said_to(dtype: Any) -> None:
    count = VECTOR // np.dtype(dtype).itemsize
    numbers = np.arange(3 * count, dtype=dtype)
    assert at_an_address(dtype, numbers.ctypes.data) == (count, count)
    expected = np.arange(3 * count)
    expected[count : 2 * count] = 2 * (1 + np.arange(count))
    np.testing.assert_array_equal(numbers, expected)


@njit(error_model="numpy")
def fused(kind, address):
    """In place of six vectors, sums and differences of products of the first three."""
    pile = heap_at(kind, address)
    x, y, z = get3(pile, 0, 1)
    put(pile, 0, x * y + z)
    put(pile, 1, z - x * y)
    put(pile, 2, x * y - z)
    put(pile, 3, x * x + y * y)
    put(pile, 4, rounded(x * y) + z)
    z += x * y
    put(pile, 5, z)


@pytest.mark.skipif(not fuses(cpu_target.target_context), reason="all are rounded there")
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_products_of_numbers_at_an_address_are_not_rounded(dtype: Any) -> None:
    count = VECTOR // np.dtype(dtype).itemsize
    given = np.random.default_rng(7).normal(size=(6, count)).astype(dtype)
    given[2] = -given[0] * given[1]  # nothing is left but what rounding took
    out = given.copy()
    fused(dtype, out.ctypes.data)
    x, y, z = ([Fraction(float(value)) for value in row] for row in given[:3])
    square = given[0] * given[0]
    expected = [
        [float(a * b + c) for a, b, c in zip(x, y, z, strict=True)],
        [float(c - a * b) for a, b, c in zip(x, y, z, strict=True)],
        [float(a * b - c) for a, b, c in zip(x, y, z, strict=True)],
        [float(Fraction(float(q)) + b * b) for q, b in zip(square, y, strict=True)],
        [0.0] * count,
    ]
    np.testing.assert_array_equal(out[:5], np.array(expected, dtype))
    np.testing.assert_array_equal(out[5], out[0])
    assert (out[0] != 0).any()


@njit
def deal_all(given, o, count, work, to, stride):
    """From one array to the other."""
    deal_out(strip(given), o, count, work, to, stride)


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


def test_a_number_that_is_none_comes_out_where_it_comes_first() -> None:
    count = VECTOR // 8
    given = np.full((3, count), 2.0)
    out = np.zeros((10, count))
    given[1, 0] = np.nan
    without_vector(given, out)
    assert out[4, 0] == 3.0  # max(x, NaN)
    assert np.isnan(out[5, 0])  # min(NaN, x)


@njit
def asked(given, o, stride):
    """The first number; three places are asked for before."""
    rows = lay(given)
    ask3(rows, o, stride)
    return rows[0]


def test_places_that_are_none_can_be_asked_for() -> None:
    given = np.array([3.0, 4.0])
    for o, stride in ((0, 1), (-(2**50), 2**40), (2**50, 1)):
        assert asked(given, o, stride) == 3.0
    np.testing.assert_array_equal(given, [3.0, 4.0])
    assert "prefetch" in next(iter(asked.inspect_llvm().values()))


@njit
def draw(tickets, times):
    """The last of so many tickets."""
    last = -1
    for _ in range(times):
        last = take(tickets)
    return last


def test_tickets_are_taken_one_by_one() -> None:
    tickets = np.array([5, 100])
    assert draw(tickets, 3) == 7
    assert tickets.tolist() == [8, 100]


def test_vectors_on_the_stack_are_aligned() -> None:
    """LLVM leaves them where they fall otherwise, and code that has many takes twice as long in every other process."""
    sums(np.zeros(VECTOR))
    assert f"alignstack={VECTOR}" in sums.inspect_llvm(sums.signatures[-1])
