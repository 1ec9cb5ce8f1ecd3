"""Joints of wide segments that are found several at once, against each by itself."""

from __future__ import annotations

import numpy as np
import pytest

from strandcli.draw.coverage.kernels import joined
from strandcli.draw.coverage.kernels import segments as seg
from strandcli.draw.geometry.kernels.ribbon import measure_ribbon
from strandcli.jit import function
from strandcli.simd import half_width_pointer


@function
def both(screen: np.ndarray, widths: np.ndarray, ends: np.ndarray, work: np.ndarray, alone: np.ndarray) -> None:
    """Numbers of the rows of `joined`, in `work`, and what they are by `measure_ribbon`; ends: base, count, begin and
    end of the segments."""
    base, count, begin, end = ends
    for k in range(count + 1):
        work[np.int64(seg.WIDTH) + k] = widths[base - 1 + k]
    joined.measure_joints(half_width_pointer(screen), base, count, begin, end, work)
    for v in range(base, base + count):
        one = measure_ribbon(screen, v, begin, end, widths[v - 1], widths[v], True)
        row = alone[v - base]
        row[0], row[1], row[2] = one.da, one.db, one.per_length
        row[3], row[4], row[5], row[6] = one.ma0, one.mb0, one.ma1, one.mb1


@pytest.mark.parametrize(
    ("base", "count", "begin", "end"), [(1, 5, 0, 6), (13, 9, 10, 24), (12, 12, 10, 24), (11, 1, 10, 12)]
)
def test_joints_together_are_those_of_each_by_itself(base: int, count: int, begin: int, end: int) -> None:
    rng = np.random.default_rng(base)
    screen = np.column_stack([np.cumsum(rng.normal([3, 1], 2.5, (32, 2)), 0), rng.uniform(-0.1, 1, 32)])
    screen[17, :2] = screen[16, :2]
    screen, widths = screen.astype(np.float32), rng.uniform(0.1, 6, 32).astype(np.float32)
    work, alone = np.ones(seg.ROWS * seg.ROW, np.float32), np.empty((count, 7), np.float32)
    both(screen, widths, np.array([base, count, begin, end]), work, alone)
    rows = (joined.DX, joined.DY, joined.PER_LENGTH, joined.MX0, joined.MY0, joined.MX1, joined.MY1)
    together = np.column_stack([work[row + 1 : row + 1 + count] for row in rows])
    drawn = np.hypot(*np.diff(screen[base - 1 : base + count, :2], axis=0).T) > 0
    np.testing.assert_array_equal(together[drawn], alone[drawn])
    assert count < 9 or (together[drawn, 3:5] != together[drawn, :2]).any(), "some joints are mitred"
