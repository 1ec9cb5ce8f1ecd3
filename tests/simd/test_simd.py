"""Vectors of lanes against NumPy, number by number, in both precisions."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from numba import njit
from numba.core.registry import cpu_target

from strandcli.constants import VECTOR
from strandcli.simd import (  # fmt: skip
    any_lane,
    broadcast,
    floor,
    fused_vector_pointer,
    gather,
    gather2,
    gather4,
    gather8,
    half_width_pointer,
    has_fma,
    lane_count,
    line_pointer,
    load,
    load3,
    movemask,
    no_fma,
    pointer,
    prefetch3,
    quadruple_pointer,
    reduce_max,
    sqrt,
    store,
    store3,
    triple_pointer,
    vector_pointer,
    where,
)


@njit(error_model="numpy")
def kernel(given, out):
    """out: a row for each of the things that vectors can do."""
    rows, to = pointer(given), vector_pointer(out)
    count = lane_count(rows)
    x, y, z = load3(rows, 0, count)
    x += 1
    store(to, 0, x * y - z / 2.0)
    store3(to, 1, 1, -x, abs(z), sqrt(abs(y)))
    store(to, 4, max(x, y))
    store(to, 5, min(y, x))
    store(to, 6, where((x < y) & ~(y <= 0.5) | (x != x), y, 7.0))
    store(to, 7, 1)
    store(to, 8, broadcast(x, rows[2]))
    store(to, 9, max(min(x, 0.25), -0.25))
    return any_lane(x > 1e9), any_lane(z > 0.0), reduce_max(where(x > y, x, y)), load(rows, 3)


@njit
def sums(given):
    """A vector from a place that is not a multiple of its length."""
    rows = pointer(given)
    return reduce_max(load(rows, 3)), lane_count(rows)


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
    rows, to = half_width_pointer(given), half_width_pointer(numbers)
    x = load(rows, 1)
    store(half_width_pointer(out), 0, floor(x))
    store(to, 2, load(to, 0))
    store(to, 0, np.int64(-7))
    return movemask(x > 0.0), lane_count(rows)


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
    rows, to = pointer(given), pointer(out)
    x, y = load(pointer(first), 0), load(pointer(second), 0)
    store(to, 0, gather(rows, 5, x, 7, y))
    store(to, lane_count(to), gather(rows, np.int64(0), x, 3, 2.0))
    a, b = gather2(rows, np.int64(1), x, 3, y)
    c, d, e, f = gather4(rows, 4, x, 3, y)
    store3(to, 2 * lane_count(to), lane_count(to), a, b, c)
    store3(to, 5 * lane_count(to), lane_count(to), d, e, f)
    for k, each in enumerate(gather8(rows, 9, y, 4, x)):
        store(to, (8 + k) * lane_count(to), each)
    return movemask(x > y)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_numbers_are_picked_from_where_they_are_said_to_be(dtype: Any) -> None:
    count = VECTOR // np.dtype(dtype).itemsize
    rng = np.random.default_rng(6)
    given, out = rng.normal(size=400).astype(dtype), np.zeros(16 * count, dtype)
    first, second = (rng.integers(0, 40, count).astype(dtype) for _ in range(2))
    assert picked(given, first, second, out) == sum(1 << int(k) for k in np.flatnonzero(first > second))
    beside = 3 * first + second
    places = [5 + 7 * first + second, 3 * first + 2, *(beside + k for k in (1, 2, 4, 5, 6, 7))]
    places += [9 + 4 * second + first + k for k in range(8)]
    places = np.concatenate(places).astype(int)
    np.testing.assert_array_equal(out, given[places])


@njit
def tripled(given, out):
    """Twice three numbers."""
    store(triple_pointer(out), 1, 2.0 * load(triple_pointer(given), 1))
    return lane_count(triple_pointer(out))


@njit
def copied(given, out):
    """Four whole numbers."""
    store(quadruple_pointer(out), 4, load(quadruple_pointer(given), 1))
    return lane_count(quadruple_pointer(out))


@pytest.mark.parametrize(
    ("kernel", "count", "kind", "found"),
    [(tripled, 3, np.float32, [9, 2, 4, 6, 9]), (copied, 4, np.int32, [9, 9, 9, 9, 1, 2, 3, 4, 9])],
    ids=["three numbers", "four whole numbers"],
)
def test_few_numbers_are_a_vector(kernel: Any, count: int, kind: type, found: list[int]) -> None:
    out = np.full(len(found), 9, kind)
    assert kernel(np.arange(len(found), dtype=kind), out) == count
    np.testing.assert_array_equal(out, found)


@njit(error_model="numpy")
def fused(vectors):
    """In place of six vectors, sums and differences of products of the first three."""
    pile = fused_vector_pointer(vectors)
    x, y, z = load3(pile, 0, 1)
    store(pile, 0, x * y + z)
    store(pile, 1, z - x * y)
    store(pile, 2, x * y - z)
    store(pile, 3, x * x + y * y)
    store(pile, 4, no_fma(x * y) + z)
    z += x * y
    store(pile, 5, z)


@pytest.mark.skipif(not has_fma(cpu_target.target_context), reason="all are rounded there")
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_products_of_fused_vectors_are_not_rounded(dtype: Any) -> None:
    count = VECTOR // np.dtype(dtype).itemsize
    given = np.random.default_rng(7).normal(size=(6, count)).astype(dtype)
    given[2] = -given[0] * given[1]  # nothing is left but what rounding took
    out = given.copy()
    fused(out)
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
def mark_line(array):
    store(line_pointer(array), 0, 7.0)


def test_a_line_begins_where_the_cache_has_one() -> None:
    for begin in range(17):
        whole = np.zeros(96, np.float32)
        array = whole[begin : begin + 48]
        mark_line(array)
        marked = np.flatnonzero(whole)
        assert len(marked) == VECTOR // 4
        assert (whole.ctypes.data + 4 * marked[0]) % VECTOR == 0
        assert begin <= marked[0] < begin + VECTOR // 4


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
    rows = pointer(given)
    prefetch3(rows, o, stride)
    return rows[0]


def test_places_that_are_none_can_be_asked_for() -> None:
    given = np.array([3.0, 4.0])
    for o, stride in ((0, 1), (-(2**50), 2**40), (2**50, 1)):
        assert asked(given, o, stride) == 3.0
    np.testing.assert_array_equal(given, [3.0, 4.0])
    assert "prefetch" in next(iter(asked.inspect_llvm().values()))


def test_vectors_on_the_stack_are_aligned() -> None:
    """LLVM leaves them where they fall otherwise, and code that has many takes twice as long in every other process."""
    sums(np.zeros(VECTOR))
    assert f"alignstack={VECTOR}" in sums.inspect_llvm(sums.signatures[-1])
