"""What opacity maps leave out: strands deep in shadow."""

from __future__ import annotations

import numpy as np
import pytest

from strandcli.draw.common.scratch import Scratch
from strandcli.draw.geometry.curves import Polylines
from strandcli.draw.geometry.extent import Thickness
from strandcli.draw.shadows.kernels.deep_strands import WEIGHTS
from strandcli.draw.shadows.kernels.map_parts import WIDE as WIDTH
from strandcli.draw.shadows.shadow import ShadowMaps, plan_maps
from strandcli.draw.shadows.strands_in_map import FEWEST, chances_of
from strandcli.scene.model import DirectionalLight, Shadow
from tests.draw.shadows.test_opacity import BOX, depth, straight

SUN = DirectionalLight(direction=(-0.5, -1.0, -0.3), shadow=Shadow(model="opacity", layers=31))
THICK = Thickness(0.02, 0.3)
SPACING = 0.04
STRANDS = 6000


def maps_of(lines: Polylines, chances: np.ndarray | None) -> ShadowMaps:
    maps = plan_maps((SUN,), BOX, Scratch(), THICK, SPACING)
    maps.chances = chances
    maps.build(lines, 2, Scratch())
    return maps


def drawn(maps: ShadowMaps, lines: Polylines) -> tuple[int, float]:
    """How many segments a map is drawn of, and how much they cover, texels."""
    parts = maps.parts(0, lines, 1, Scratch())
    count, area = 0, 0.0
    for begin, vertices in parts.order[:, :2]:
        kept = parts.kept[begin : begin + vertices].astype(np.float64)
        there = kept[1:, WIDTH] >= 0
        count += np.count_nonzero(there)
        area += (np.hypot(*np.diff(kept[:, :2], axis=0).T) * kept[1:, WIDTH])[there].sum()
    return count, area


def test_weights_make_up_for_what_is_left_out() -> None:
    chances = (np.arange(10_000) + 0.5) / 10_000
    for most, slope, top in WEIGHTS.astype(np.float64):
        weights = np.clip((most - chances) * slope, 0, top)
        assert weights.mean() == pytest.approx(1, abs=1e-3)
        assert (np.diff(weights) <= 0).all()
    assert np.allclose(np.clip((WEIGHTS[0, 0] - chances) * WEIGHTS[0, 1], 0, WEIGHTS[0, 2]), 1, atol=1e-6)


def test_part_of_a_dense_ball_is_left_out_and_light_is_the_same() -> None:
    """Mean of four choices of strands, of which one is 1.5 % off in what is covered, standard deviation."""
    lines = straight(STRANDS, 3)
    whole = maps_of(lines, None)
    every, area = drawn(whole, lines)
    points = np.random.default_rng(1).uniform(-0.6, 0.6, (400, 3))
    full = np.array([depth(whole, SUN, point) for point in points])
    assert (full > 8).mean() > 0.3
    assert (full < 3).mean() > 0.2
    shares, deep = [], []
    for choice in range(4):
        ids = np.arange(STRANDS, dtype=np.int32) + 100_000 * choice
        some = maps_of(lines, chances_of(ids, STRANDS))
        few, covered = drawn(some, lines)
        found = np.array([depth(some, SUN, point) for point in points])
        off = np.abs(np.exp(-found) - np.exp(-full))
        assert few < 0.72 * every
        assert off.mean() < 0.005
        assert off[full < 2].mean() < 0.015
        shares.append(covered / area)
        deep.append((found[full > 8] / full[full > 8]).mean())
    assert np.mean(shares) == pytest.approx(1, abs=0.03)
    assert np.mean(deep) == pytest.approx(1, abs=0.06)


@pytest.mark.parametrize("strands", [FEWEST - 1, STRANDS])
def test_nothing_is_left_out_of_few_strands_or_thin_ones(strands: int) -> None:
    lines = straight(strands, 3)
    maps = plan_maps((SUN,), BOX, Scratch(), THICK if strands < FEWEST else Thickness(0.0005), SPACING)
    before = drawn(maps, lines)
    maps.chances = chances_of(None, strands)
    assert drawn(maps, lines) == before
