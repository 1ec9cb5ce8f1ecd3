"""Vertices of a batch that a light reaches: they come first, and none is lost."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from numba import njit

from strandcli.constants import W
from strandcli.draw.common.kernels import batch
from strandcli.draw.lighting.kernels import lit_vertices

of_batch = lit_vertices.lit_first


@njit
def lit_first(work, n, which):  # type: ignore[no-untyped-def]
    """Only compiled functions can call it."""
    return of_batch(work, n, which)


KEPT = [first // W + c for first in lit_vertices.THREES for c in range(3)] + [batch.REACH // W, batch.ARRIVES // W]


@settings(deadline=None)
@given(st.lists(st.booleans(), max_size=W), st.integers(0, 2**32 - 1))
def test_lit_vertices_come_first_with_all_that_is_known_of_them(lit: list[bool], seed: int) -> None:
    """Each column of the batch stays with its vertex's number."""
    n = np.int64(len(lit))
    work = np.random.default_rng(seed).random((batch.ROWS, W), np.float32)
    work[batch.ARRIVES // W, :n] = np.where(lit, 0.5, 0.0)
    before, which = work.copy(), np.arange(W)
    count = lit_first(work.reshape(-1), n, which)
    assert count == sum(lit)
    assert (work[batch.ARRIVES // W, :count] > 0).all()
    np.testing.assert_array_equal(np.sort(which), np.arange(W))
    np.testing.assert_array_equal(work[KEPT], before[KEPT][:, which])
    assert {batch.RADIANCE // W + 2, batch.LX // W, batch.EXTRA // W} <= set(KEPT)
