"""Segments that solids hide are not binned, and no others are missing."""

from __future__ import annotations

import numpy as np
import pytest

from strandcli.draw.common.scratch import Scratch
from strandcli.draw.coverage.kernels import tile_binning, windows
from strandcli.draw.coverage.kernels.segments import WIDE
from strandcli.draw.coverage.kernels.strand_extents import COLUMNS, find_extents
from strandcli.draw.coverage.picture import windows_of
from strandcli.draw.geometry.kernels.screen_lines import ScreenLines
from strandcli.draw.solids.edges import none
from strandcli.draw.view.kernels.depth_slope import FLAT

WIDTH, HEIGHT, STRANDS = 75, 61, 1000


def hills(seed: int) -> np.ndarray:
    """Depth numbers (HEIGHT, WIDTH) of a solid, with a hole, that vary from block to block."""
    depths = np.random.default_rng(seed).uniform(0.4, 0.6, (HEIGHT, WIDTH)).astype(np.float32)
    depths[20:32, 30:50] = 0
    return depths


def binned(hides: np.ndarray | None, screen: np.ndarray, wide: float, top: int = 0) -> np.ndarray:
    """Which strands of two vertices, screen (2 S, 3), have a row in some tile from row `top` on."""
    count = len(screen) // 2
    lines = ScreenLines(2 * np.arange(count + 1, dtype=np.int64), screen, np.full(2 * count, wide, np.float32))
    extents = np.empty((count, COLUMNS), np.float32)
    find_extents(*lines, WIDTH, extents)
    tiles, blocks = 9, count
    segments = tile_binning.TileSegments(
        np.full((blocks * tile_binning.BLOCK, 2), -1, np.int64), np.zeros(blocks * tile_binning.BLOCK, np.float32),
        np.zeros(blocks, np.int64),
        np.zeros((1, tiles), np.int64), np.zeros((1, tiles), np.int64), np.zeros(1, np.int64),
    )  # fmt: skip
    edges = None if hides is None else none(hides.reshape(-1))
    found = windows_of(edges, (WIDTH, HEIGHT), Scratch())
    tile_binning.bin_segments(lines, extents, top, HEIGHT, WIDTH, 1, segments, found, FLAT)
    rows = segments.pool[segments.pool[:, 0] >= 0, tile_binning.STRAND_AND_LAST]
    return np.isin(np.arange(count), rows >> tile_binning.SHIFT)


def short(seed: int, length: float) -> np.ndarray:
    """Strands of one segment each, in and about the picture."""
    rng = np.random.default_rng(seed)
    begin = rng.uniform((-4, -4, 0.2), (WIDTH + 4, HEIGHT + 4, 0.8), (STRANDS, 3))
    end = begin + rng.uniform((-length, -length, -0.02), (length, length, 0.02), (STRANDS, 3))
    return np.stack([begin, end], 1).reshape(-1, 3).astype(np.float32)


@pytest.mark.parametrize(("wide", "length", "top"), [(0.2, 4, 0), (2.0, 4, 32), (0.3, 30, 0)])
def test_only_segments_behind_solids_wherever_they_lie_are_left_out(wide: float, length: float, top: int) -> None:
    hides, screen = hills(1), short(2, length)
    every, kept = binned(None, screen, wide, top), binned(hides, screen, wide, top)
    assert not (kept & ~every).any()
    for k in np.flatnonzero(every & ~kept):
        ends = screen[2 * k : 2 * k + 2]
        size = abs(ends[1, :2] - ends[0, :2])
        # along its axis a thin segment has no other cells than those of its ends
        reach = (1 + wide / 2) * ((size < size.max()) | (wide > WIDE))
        low, high = ends[:, :2].min(0) - reach, ends[:, :2].max(0) + reach
        (x0, y0), (x1, y1) = np.clip(np.floor([low, high]).astype(int), 0, (WIDTH - 1, HEIGHT - 1))
        assert ends[:, 2].max() < hides[y0 : y1 + 1, x0 : x1 + 1].min()
    if length < 10:
        behind = every & (screen[:, 2].reshape(-1, 2).max(1) < 0.38)
        assert np.mean(kept[behind]) < 0.5, "and most that lie behind solids are"


def test_windows_are_least_depths_of_the_pixels_in_them() -> None:
    hides = hills(3)
    found = windows_of(none(hides.reshape(-1)), (WIDTH, HEIGHT), Scratch())
    side = windows.BLOCK
    for y in range(found.down):
        for x in range(found.across):
            inside = hides[side * y : side * (y + windows.SPAN), side * x : side * (x + windows.SPAN)]
            assert found.depths[y * found.across + x] == inside.min() * windows.SAFE
    assert found.depths[-1] == 0
