"""Filtered shadows on a surface: interpolated between some points, against the filter at each of them."""

from __future__ import annotations

import numpy as np
import pytest
from numba import njit

from strandcli.constants import W
from strandcli.draw.common.kernels import batch, surface_batch
from strandcli.draw.shadows.kernels import percentage_closer, sparse_filter
from strandcli.scene.model import Light
from tests.draw.shadows.test_percentage_closer import LAMP, SUN, left

list_ends, list_between, interpolate = (
    sparse_filter.list_ends, sparse_filter.list_between, sparse_filter.interpolate
)  # fmt: skip


@njit
def ends_of(work, n, texel):  # type: ignore[no-untyped-def]
    """Only compiled functions can call these."""
    return list_ends(work, n, texel)


@njit
def between(work, n):  # type: ignore[no-untyped-def]
    return list_between(work, n)


@njit
def fill(work, n):  # type: ignore[no-untyped-def]
    interpolate(work, n)


@pytest.mark.parametrize("light", [SUN, LAMP])
@pytest.mark.parametrize("step", [0.001, 0.006, 0.05])
def test_neighbouring_points_have_the_light_that_each_has_by_itself(light: Light, step: float) -> None:
    """Points of rows of pixels, near each other and far apart; between rows and at a fold the line jumps."""
    along = np.arange(W) * step
    rows = [np.stack([x + along, np.full(W, y), np.full(W, z)], 1) for x, y, z in
            ((-1.4, -1.4, 0.1), (-0.9, -1.4, 0.15), (-0.7, -1.2, 0.2), (-1.1, -1.4, -0.1))]  # fmt: skip
    rows[1][W // 3 :, 1] += 0.4
    points = np.concatenate(rows)
    each = np.concatenate([left(percentage_closer, light, one[None]) for one in points[:: 4 if step < 0.05 else 1]])
    together = left(percentage_closer, light, points)[:: 4 if step < 0.05 else 1]
    assert each.std() > 0.03
    assert np.abs(together - each).max() < 0.03
    assert np.abs(together - each).mean() < 0.002


def test_a_smooth_shadow_is_filtered_at_few_points() -> None:
    """Neighbours a hundredth of a filter's radius apart are not filtered one by one, and all are done."""
    work = np.zeros((surface_batch.ROWS, W), np.float32)
    work[batch.U // W] = 10 + 0.01 * np.arange(W)
    work[[batch.V // W, surface_batch.RADIUS // W]] = [[10.0], [3.0]]
    work[batch.INSIDE // W] = 1
    flat = work.reshape(-1)
    count = ends_of(flat, W, np.float32(1))
    listed = work[surface_batch.LIST // W][:count].astype(int)
    assert count <= W // sparse_filter.LONGEST + sparse_filter.LONGEST
    assert (np.diff(listed) > 0).all()
    work[surface_batch.LEFT // W :][:3, listed] = 0.3 + 0.002 * listed
    assert between(flat, W) == 0
    fill(flat, W)
    np.testing.assert_allclose(work[surface_batch.LEFT // W], 0.3 + 0.002 * np.arange(W), rtol=1e-5)
    work[surface_batch.LEFT // W, listed[1]] += 1  # the ends of two stretches differ
    assert between(flat, W) > 0
