"""Parts of strands that vectors write, against the same parts vertex by vertex."""

from __future__ import annotations

import numpy as np
import pytest

from strandcli.draw.common.scratch import Scratch
from strandcli.draw.shadows.kernels.deep_strands import LEVELS, NO_SKETCH, WEIGHTS, Sketch
from strandcli.draw.shadows.kernels.map_parts import MapView, PartsInMap, StrandsInMap
from strandcli.draw.shadows.strands_in_map import parts_of

SIDE = 64
VIEW = MapView(np.float32(2), np.float32(1), np.float32(8))
LENGTHS = np.array([7, 17, 18, 34, 57, 120, 6, 49, 2, 16, 33])


def strands_of(step: float, alike: bool, placed: bool) -> StrandsInMap:
    """Wavy strands of some lengths whose vertices are about ``step`` texels apart, of several widths or one, with or
    without places along them."""
    rng = np.random.default_rng(4)
    first = np.append(0, np.cumsum(LENGTHS))
    moves = rng.normal(0, step, (first[-1], 2)) + step
    screen = np.concatenate([np.cumsum(moves, 0) % SIDE, rng.uniform(0.1, 0.9, (first[-1], 1))], 1).astype(np.float32)
    scale = None if alike else rng.uniform(0.5, 2, len(LENGTHS)).astype(np.float32)
    along = np.concatenate([np.linspace(0, 1, n) ** 2 for n in LENGTHS]).astype(np.float32) if placed else None
    return StrandsInMap(first, screen, np.float32(0.02), np.float32(0.6), scale, along)


def alone(strands: StrandsInMap, s: int) -> StrandsInMap:
    """One of the strands, behind which there is nothing that a vector might reach: it is written vertex by vertex."""
    here = slice(strands.first[s], strands.first[s + 1])
    return strands._replace(
        first=np.array([0, LENGTHS[s]]), screen=strands.screen[here].copy(),
        scale=None if strands.scale is None else strands.scale[s : s + 1],
        along=None if strands.along is None else strands.along[here].copy(),
    )  # fmt: skip


def deep(chances: np.ndarray) -> Sketch:
    """A sketch behind whose middle depth fewer and fewer strands are drawn."""
    cells = SIDE // 4
    depths = np.tile(np.array([2.0, 2.0], np.float32), (cells * cells, 1))
    none = np.zeros(cells * cells * (LEVELS + 1), np.float32)
    return Sketch(chances, none[: cells * cells], none, depths, WEIGHTS, cells, np.float32(1))


def vertices(parts: PartsInMap) -> np.ndarray:
    """Those of all parts in the order of their memory."""
    order = parts.order[np.argsort(parts.order[:, 0])]
    return np.concatenate([parts.kept[begin : begin + count] for begin, count in order[:, :2]] or [parts.kept[:0]])


@pytest.mark.parametrize(("step", "alike", "placed"), [(2.0, True, False), (2.0, False, True), (0.5, False, True)])
@pytest.mark.parametrize("sketched", [False, True])
@pytest.mark.parametrize("workers", [1, 2])
def test_they_are_the_same(step: float, alike: bool, placed: bool, sketched: bool, workers: int) -> None:
    strands = strands_of(step, alike, placed)
    chances = np.linspace(0, 0.99, len(LENGTHS), dtype=np.float32)
    together = parts_of(strands, VIEW, SIDE, workers, Scratch(), deep(chances) if sketched else NO_SKETCH)
    found = vertices(together).copy()
    one_by_one, drawn = [], 0
    for s in range(len(LENGTHS)):
        sketch = deep(chances[s : s + 1]) if sketched else NO_SKETCH
        parts = parts_of(alone(strands, s), VIEW, SIDE, workers, Scratch(), sketch)
        drawn += len(parts.order)
        one_by_one.append(vertices(parts).copy())
    np.testing.assert_array_equal(found, np.concatenate(one_by_one))
    assert len(together.order) == drawn
    if sketched:
        assert np.count_nonzero(found[:, 3] >= 0) < 0.9 * np.sum(LENGTHS - 1)
    elif step > 1:
        assert np.count_nonzero(found[:, 3] >= 0) > 0.8 * np.sum(LENGTHS - 1)
