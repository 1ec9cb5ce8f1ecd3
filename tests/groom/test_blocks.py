"""Strands in blocks of lanes: none is lost, and padding copies the last one."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from strandcli.blocks import LINE, lanes, on_large_pages, pack, unpack
from strandcli.constants import W

NUMBERS = st.floats(width=32, allow_nan=True, allow_infinity=True)


@settings(max_examples=60, deadline=None)
@given(
    st.tuples(st.integers(1, 3 * W), st.integers(1, 4)).flatmap(
        lambda shape: arrays.arrays(np.float32, (*shape, 3), elements=NUMBERS, fill=NUMBERS)
    )
)
def test_packing_and_unpacking_is_the_identity(positions: np.ndarray) -> None:
    strands, rows, _ = positions.shape
    packed = pack(positions)
    assert packed.shape == (-(-strands // W), rows, 3 * W)
    assert packed.dtype == np.float32
    np.testing.assert_array_equal(unpack(packed, strands), positions)


@settings(max_examples=40, deadline=None)
@given(st.integers(1, 3 * W), st.integers(1, 5))
def test_lanes_hold_one_value_of_all_strands_after_another(strands: int, k: int) -> None:
    rows = np.arange(strands * k, dtype=np.float64).reshape(strands, k)
    packed = lanes(rows)
    for s in range(-(-strands // W) * W):
        for value in range(k):
            assert packed[s // W, value * W + s % W] == rows[min(s, strands - 1), value]


def test_padding_repeats_the_last_strand() -> None:
    positions = np.random.default_rng(0).normal(size=(W + 5, 3, 3)).astype(np.float32)
    whole = unpack(pack(positions), 2 * W)
    np.testing.assert_array_equal(whole[W + 5 :], np.broadcast_to(positions[-1], (W - 5, 3, 3)))


def test_arrays_on_large_pages_are_zeros_that_begin_where_a_line_does() -> None:
    for shape in ((3, 5), (400, 700), (1000, 1000)):
        for kind in (np.float32, np.float64):
            one, other = on_large_pages(shape, kind), on_large_pages(shape, kind)
            assert one.shape == shape
            assert one.dtype == kind
            assert one.flags.c_contiguous
            assert one.ctypes.data % LINE == 0
            assert not one.any()
            one[...] = 1
            assert not other.any()
