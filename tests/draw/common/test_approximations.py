"""Elementary functions of the kernels against float64, over dense samples and at the edges; arrays that are reused."""

from __future__ import annotations

import mmap
import weakref
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from strandcli.draw.common.kernels import approximations as ap
from strandcli.draw.common.scratch import LINE, Scratch
from strandcli.jit import function
from strandcli.simd import lane_count, load, pointer, store

FLOATS = st.floats(width=32, allow_nan=True, allow_infinity=True)


@function
def over(function, values, out):
    for i in range(values.size):
        out[i] = function(values[i])


def sample(function, values):
    x = values.astype(np.float32)
    out = np.empty_like(x)
    over(function, x, out)
    return x.astype(np.float64), out.astype(np.float64)


@pytest.mark.parametrize(("name", "exact"), [("acos", np.arccos), ("asin", np.arcsin)])
def test_inverse_trigonometry_within_half_a_microradian(name, exact):
    ends = 1.0 - np.logspace(-7, -1, 20_001)
    x, y = sample(getattr(ap, name), np.concatenate([np.linspace(-1, 1, 200_001), ends, -ends]))
    assert np.abs(y - exact(x)).max() < 5e-7


def test_exp2_relative_error_over_its_whole_range():
    x, y = sample(ap.exp2, np.linspace(-126, 127, 500_001))
    assert np.abs(y / np.exp2(x) - 1).max() < 2.5e-7


def test_exp_relative_error_grows_only_with_the_argument():
    x, y = sample(ap.exp, np.linspace(-87, 88, 500_001))
    assert (np.abs(y / np.exp(x) - 1) / (3e-7 + 1.5e-7 * np.abs(x))).max() < 1


def test_exact_values():
    zero, one = np.float32(0), np.float32(1)
    assert ap.acos(one) == 0
    assert ap.asin(zero) == 0
    assert ap.acos(-one) == np.float32(np.pi)
    assert ap.asin(one) == np.float32(np.pi / 2)
    assert [ap.exp2(np.float32(k)) for k in (-126, -1, 0, 1, 127)] == [2.0**k for k in (-126, -1, 0, 1, 127)]
    assert ap.exp(zero) == 1


@given(FLOATS)
def test_nothing_that_can_be_passed_gives_nan_or_infinity(x):
    x = np.float32(x)
    for one in (ap.acos, ap.asin, ap.exp2, ap.exp):
        assert np.isfinite(one(x)), one


@given(FLOATS)
def test_clamp_puts_nan_and_everything_else_inside(x):
    assert -2 <= ap.clamp(np.float32(x), np.float32(-2), np.float32(3)) <= 3


@function
def exp_of_vectors(values, out):
    rows, to = pointer(values), pointer(out)
    for k in range(0, len(values), lane_count(rows)):
        store(to, k, ap.exp_lanes(load(rows, k)))


def test_lanes_have_the_bits_of_numbers():
    x = np.concatenate([np.linspace(-100, 100, 4089), [np.nan, np.inf, -np.inf, 0.0, -0.0, 1e38, -1e38]])
    x = x.astype(np.float32)
    each, lanes = np.empty_like(x), np.empty_like(x)
    over(ap.exp, x, each)
    exp_of_vectors(x, lanes)
    np.testing.assert_array_equal(lanes.view(np.int32), each.view(np.int32))


def test_a_borrowed_array_is_the_same_memory_until_a_larger_one_is_asked_for() -> None:
    scratch = Scratch()
    for borrow in (scratch.borrow, scratch.sparse):
        first = borrow("a", 1000, np.float32)
        first[:] = 7
        assert (borrow("a", 900, np.float32) == 7).all()
        assert borrow("a", 5000, np.float32).shape == (5000,)
        assert borrow("a", 10, np.uint64).dtype == np.uint64
        assert borrow("b", 0, np.uint64).shape == (0,)


def test_arrays_that_are_released_share_memory_in_turns() -> None:
    scratch = Scratch()
    scratch.release("a", "b", "small")
    first = scratch.borrow("a", 1000, np.float32)
    assert first.ctypes.data % LINE == 0
    assert not np.shares_memory(scratch.borrow("b", 1000, np.float32), first)  # both are in use
    scratch.release("a")
    assert not np.shares_memory(scratch.borrow("c", 1000, np.float32), first)  # never released, it keeps its own
    assert not np.shares_memory(scratch.borrow("small", 10, np.float32), first)  # most would be left over
    scratch.release("b")
    scratch.borrow("b", 900, np.int32)
    scratch.release("c")
    assert np.shares_memory(scratch.borrow("a", 900, np.float32), first)  # the one that had it before others


def test_what_no_array_is_in_is_given_back() -> None:
    scratch = Scratch()
    held, left = scratch.borrow("held", 1000, np.float32), scratch.borrow("left", 5000, np.float32)
    gone = weakref.ref(left.base)
    del left
    scratch.release("left")
    assert gone() is not None
    scratch.let_go()
    assert gone() is None
    assert np.shares_memory(scratch.borrow("held", 1000, np.float32), held)


@pytest.mark.skipif(not hasattr(mmap, "MADV_NOHUGEPAGE"), reason="no huge pages")
def test_of_a_sparse_array_only_what_is_written_to_takes_memory() -> None:
    def resident() -> int:
        return int(Path("/proc/self/statm").read_text().split()[1]) * mmap.PAGESIZE

    array = Scratch().sparse("a", 16_000_000, np.uint32)
    assert array.flags.c_contiguous
    assert array.flags.writeable
    before = resident()
    array[:: 1 << 17] = 1  # a page in each half of a megabyte
    assert resident() - before < 8_000_000
