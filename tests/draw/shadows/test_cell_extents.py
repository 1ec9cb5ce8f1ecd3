"""Extents of the cells of opacity maps: by vertices and long segments, in the cells about them, on many threads."""

from __future__ import annotations

import numba
import numpy as np
from numpy.typing import NDArray

from strandcli.draw.common.scratch import Scratch
from strandcli.draw.shadows.kernels import cell_extents
from strandcli.draw.shadows.kernels.map_parts import MapView, StrandsInMap
from strandcli.draw.shadows.kernels.minmax import FARTHEST, NEAREST
from strandcli.draw.shadows.map_extents import spread_extents
from strandcli.draw.shadows.strands_in_map import parts_of

SIDE, FAR = 64, np.float32(2.0)
VIEW = MapView(FAR, np.float32(0.0), np.float32(30.0))


def strands_of(count: int, vertices: int, longest: float) -> StrandsInMap:
    """Strands whose segments go anywhere, up to ``longest`` texels along each axis."""
    random = np.random.default_rng(1)
    steps = random.uniform(-longest, longest, (count, vertices, 3)) * (1, 1, 0.2 / longest)
    steps[:, 0] = random.uniform((0, 0, 0.3), (SIDE, SIDE, 0.7), (count, 3))
    screen = steps.cumsum(1).astype(np.float32)
    screen[..., 2] = screen[..., 2].clip(0.01, 0.99)
    first = np.arange(count + 1) * vertices
    return StrandsInMap(first, screen.reshape(-1, 3), np.float32(1e-2), np.float32(0.0), None)


def measured(strands: StrandsInMap, workers: int) -> NDArray[np.float32]:
    extents = np.tile(np.array([np.inf, -np.inf], np.float32), (SIDE * SIDE // 4, 1))
    threads = numba.get_num_threads()
    numba.set_num_threads(min(workers, threads))
    try:
        parts_of(strands, VIEW, SIDE, workers, Scratch(), extents=extents)
    finally:
        numba.set_num_threads(threads)
    return extents


def test_threads_find_the_same_extents() -> None:
    for longest in (0.7, 3.0, 20.0):
        strands = strands_of(300, 60, longest)
        alone = measured(strands, 1)
        assert np.isfinite(alone).any()
        for workers in (2, 5):
            np.testing.assert_array_equal(measured(strands, workers), alone)


def test_every_cell_that_a_segment_comes_to_has_extents() -> None:
    """To the texels on both sides of it, too, where splats add."""
    for longest in (1.0, 6.0, 40.0):
        strands = strands_of(40, 12, longest)
        extents = measured(strands, 1)
        spread_extents(extents, SIDE // 2, 0.0, Scratch())
        points = strands.screen.reshape(40, 12, 3)
        for t in np.linspace(0, 1, 200):
            x, y, _ = (points[:, :-1] + t * (points[:, 1:] - points[:, :-1])).reshape(-1, 3).T
            for aside in (-0.5, 0.5):
                for u, v in ((x + aside, y), (x, y + aside)):
                    inside = (u >= 0) & (u < SIDE) & (v >= 0) & (v < SIDE)
                    cells = (v[inside] // 2).astype(int) * (SIDE // 2) + (u[inside] // 2).astype(int)
                    assert np.isfinite(extents[cells]).all()


def test_extents_spread_to_the_cells_about() -> None:
    """As far as they reach; empty cells take all."""
    side, reach = 21, np.float32(0.1)
    extents = np.tile(np.array([np.inf, -np.inf], np.float32), (side * side, 1))
    random = np.random.default_rng(2)
    some = random.permutation(side * side)[:150]
    extents[some] = np.sort(random.random((150, 2)).astype(np.float32), 1)
    wide = np.full((side + 2, side + 2, 2), (np.inf, -np.inf), np.float32)
    wide[1:-1, 1:-1] = extents.reshape(side, side, 2)
    about = np.stack([wide[i : i + side, j : j + side] for i in range(3) for j in range(3)]).reshape(9, -1, 2)
    there = np.isfinite(extents[:, NEAREST])
    nearest, farthest = about[..., NEAREST].min(0), about[..., FARTHEST].max(0)
    nearest[there] = np.maximum(nearest[there], extents[there, NEAREST] - reach)
    farthest[there] = np.minimum(farthest[there], extents[there, FARTHEST] + reach)
    cell_extents.spread(extents, side, reach, np.empty(cell_extents.room_of(side), np.float32))
    np.testing.assert_array_equal(extents[:, NEAREST], nearest)
    np.testing.assert_array_equal(extents[:, FARTHEST], farthest)
