"""Segments that lie behind all that can be seen around them are left out, and no others."""

from __future__ import annotations

import numpy as np
import pytest

from strandcli.draw.coverage.kernels import segments as seg
from strandcli.draw.coverage.kernels import windows
from strandcli.draw.coverage.kernels.tiles import PIXELS, TILE_HEIGHT, TILE_WIDTH
from strandcli.draw.view.kernels.depth_slope import DepthSlope
from strandcli.jit import function

LEFT, TOP, COUNT = 64, 96, seg.SEGMENTS - 1


@function
def measured(
    depths: np.ndarray, work: np.ndarray, widths: np.ndarray, far: np.float32, slope: DepthSlope, blocks: np.ndarray,
    found: np.ndarray,
) -> None:  # fmt: skip
    windows.find_windows(depths, blocks, found)
    left, top = np.float32(LEFT), np.float32(TOP)
    seg.measure_segments(work, widths, COUNT, np.float32(1.0), left, top, far, slope, found)


def measure(depths: np.ndarray, vertices: np.ndarray, widths: np.ndarray, slope: DepthSlope) -> dict[int, np.ndarray]:
    """Rows of the segments between vertices (`COUNT` + 1, 3), by their names in `segments`."""
    work = np.zeros(seg.ROWS * seg.ROW, np.float32)
    for row, values in zip((seg.X, seg.Y, seg.DEPTH, seg.WIDTH), (*vertices.T, widths), strict=True):
        work[row : row + COUNT + 1] = values
    far = np.float32(
        max(abs(LEFT - slope.axis_x), abs(LEFT + TILE_WIDTH - slope.axis_x))
        + max(abs(TOP - slope.axis_y), abs(TOP + TILE_HEIGHT - slope.axis_y))
    )
    blocks, found = np.empty(PIXELS, np.int32), np.empty(windows.WINDOWS, np.float32)
    measured(depths.reshape(-1), work, widths, far, slope, blocks, found)
    return {row: work[row + 1 : row + 1 + COUNT] for row in (seg.HIDDEN, seg.NEAREST, seg.KIND)}


def chain(seed: int, step: float) -> np.ndarray:
    """Vertices (`COUNT` + 1, 3) that wander about the tile, and beyond its sides."""
    rng = np.random.default_rng(seed)
    ends = np.cumsum(rng.normal(0, step, (COUNT + 1, 2)), 0) % 44 + [LEFT - 6, TOP - 6]
    return np.column_stack([ends, rng.uniform(0.2, 0.9, COUNT + 1)]).astype(np.float32)


@pytest.mark.parametrize(("step", "wide"), [(2, 0.2), (2, 1.5), (9, 0.4), (9, 12)])
def test_nothing_in_front_of_what_is_hidden_where_a_segment_lies_is_left_out(step: float, wide: float) -> None:
    rng = np.random.default_rng(1)
    depths = rng.uniform(0.1, 1, (TILE_HEIGHT, TILE_WIDTH)).astype(np.float32)
    vertices = chain(int(step), step)
    rows = measure(depths, vertices, np.full(COUNT + 1, wide, np.float32), DepthSlope(*np.zeros(4, np.float32)))
    useful = 0
    for k in range(COUNT):
        size = abs(vertices[k + 1, :2] - vertices[k, :2])
        # along its axis a thin segment has no other cells than those of its ends
        reach = (1 + 0.7 * wide) * ((size < size.max()) | (rows[seg.KIND][k] == seg.RIBBON))
        low = vertices[k : k + 2, :2].min(0) - [LEFT, TOP] - reach
        high = vertices[k : k + 2, :2].max(0) - [LEFT, TOP] + reach
        if (high < 0).any() or (low > 31).any():
            continue
        (x0, y0), (x1, y1) = np.clip(np.floor([low, high]), 0, 31).astype(int)
        least = depths[y0 : y1 + 1, x0 : x1 + 1].min()
        assert rows[seg.HIDDEN][k] <= least
        if rows[seg.KIND][k] != 0 and abs(rows[seg.KIND][k]) <= 2 and (high - low < 7).all():
            near = depths[max(y0 - 4, 0) : y1 + 12, max(x0 - 4, 0) : x1 + 12].min()
            assert rows[seg.HIDDEN][k] >= near * windows.SAFE
            useful += rows[seg.HIDDEN][k] > depths.min()
    assert step > 2 or wide > 1 or useful > COUNT // 4


def test_a_round_strand_is_nowhere_nearer_than_its_bound() -> None:
    """Against the greatest depth number of `geometry.kernels.ribbon.depth_offsets`, wherever the tile shows it."""
    slope = DepthSlope(*np.array([0.004, 0.0, 300, 400], np.float32))
    vertices = chain(3, 5)
    vertices[::2, 2] = 0.5  # some rise much from end to end, some hardly
    vertices[COUNT // 2 :, 2] = 0.5 + 1e-3 * vertices[COUNT // 2 :, 2]
    widths = np.random.default_rng(2).uniform(0.8, 9, COUNT + 1).astype(np.float32)
    rows = measure(np.zeros((TILE_HEIGHT, TILE_WIDTH), np.float32), vertices, widths, slope)
    tightest = np.inf
    for k in range(COUNT):
        (a, b), (w0, w1) = vertices[k : k + 2].astype(float), widths[k : k + 2].astype(float)
        length = np.hypot(*(b - a)[:2])
        dx, dy = (b - a)[:2] / length
        steep = (b - a)[2] * min(1 / length, 2 / max(w0, w1))
        t = np.linspace(0, 1, 33)[:, None]
        x, y = a[0] + t * (b - a)[0], a[1] + t * (b - a)[1]
        inside = (abs(x - LEFT - 16) < 16) & (abs(y - TOP - 16) < 16)
        q = a[2] + t * (b - a)[2]
        per = slope.per_depth * q
        u, v = (x - slope.axis_x) * slope.per_depth, (y - slope.axis_y) * slope.per_depth
        p, w, g = u * dx + v * dy, v * dx - u * dy, steep / per
        scale = (w0 + t * (w1 - w0)) / 2 * per / (1 + w * w)
        h = np.linspace(-1, 1, 65)[None]
        forward = scale * np.sqrt((1 - g * p) ** 2 + g * g * (1 + w * w))
        depth = q + forward * np.sqrt(1 - h * h) + scale * w * (1 - g * p) * h
        if inside.any():
            most = np.where(inside, depth, -np.inf).max()
            assert most <= rows[seg.NEAREST][k]
            tightest = min(tightest, (rows[seg.NEAREST][k] - q.max()) / (depth - q).max())
    assert tightest < 4, "and the bound is of use"
