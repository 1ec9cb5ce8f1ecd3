"""Elementary functions of the kernels against float64, over dense samples and at the edges of their domains."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from strandcli.draw.common.kernels import approximations as ap
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
