"""Short strands are projected together, and each as if it were alone."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from strandcli.draw.common.kernels import view_columns as columns
from strandcli.draw.view.kernels import project


def test_strands_together_are_on_the_screen_where_each_is_alone() -> None:
    """Among them some of no vertex, of one and of many, and some that cross the near plane, from either side."""
    rng = np.random.default_rng(4)
    first = np.concatenate([[0], np.cumsum(rng.choice([0, 1, 2, 3, 9, 150], 300))])
    world = rng.normal(0, 1, (first[-1], 3)).astype(np.float32)
    view = np.zeros(64, np.float32)
    view[[columns.RIGHT_X, columns.UP_Y, columns.FORWARD_Z, columns.PERSPECTIVE]] = 1
    view[columns.FOCAL], view[columns.NEAR_PLANE], view[columns.DEPTH_RANGE] = 500, 0.1, 100
    together = np.full_like(world, np.nan)
    project.points(first, world, 1, view, together)
    moved = world[:, 2] < view[columns.NEAR_PLANE]
    assert (together[moved, 2] > 0).any()
    assert (together[moved, 2] == 0).any()
    for begin, end in pairwise(first):
        alone = np.empty((end - begin, 3), np.float32)
        project.points(np.array([0, end - begin]), world[begin:end], 1, view, alone)
        np.testing.assert_array_equal(together[begin:end], alone)
