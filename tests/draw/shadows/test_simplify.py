"""Vertices at which strands hardly bend: those that are left out lie near the lines that are drawn."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from opacity_twin import splatted
from strandcli.draw.common.scratch import Scratch
from strandcli.draw.geometry.curves import Polylines
from strandcli.draw.geometry.extent import Thickness
from strandcli.draw.shadows import strands_in_map
from strandcli.draw.shadows.kernels import opacity
from strandcli.draw.shadows.shadow import ShadowMaps, plan_maps
from strandcli.draw.shadows.strands_in_map import BENT, LONGEST
from strandcli.scene.model import DirectionalLight, Shadow

BOX = np.array([[-1.0, -1, -1], [1, 1, 1]])
SUN = DirectionalLight(direction=(-0.5, -1.0, -0.3), shadow=Shadow(model="opacity", size=64, layers=13, texel=1e-6))
WIDE = Thickness(0.01, 0.5)


@pytest.fixture(autouse=True)
def _of_any_number(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(strands_in_map, "FEWEST", 0)


def bent(count: int, turn: float, longest: float = 0.03) -> Polylines:
    """Strands of 0 to 40 vertices that turn by about so many radians at each."""
    rng = np.random.default_rng(1)
    lengths = rng.integers(0, 41, count)
    first = np.append(0, np.cumsum(lengths))
    way = rng.normal(size=(count, 1, 3)) + turn * rng.normal(size=(count, 40, 3)).cumsum(1)
    way /= np.linalg.norm(way, axis=2, keepdims=True)
    world = rng.uniform(-0.3, 0.3, (count, 1, 3)) + rng.uniform(0.002, longest, (count, 1, 1)) * way.cumsum(1)
    return Polylines(first, np.concatenate([one[:n] for one, n in zip(world, lengths, strict=True)]).astype(np.float32))


def maps_of(lines: Polylines, workers: int = 1) -> ShadowMaps:
    maps = plan_maps((SUN,), BOX, Scratch(), WIDE)
    assert maps is not None
    maps.build(lines, workers, Scratch())
    return maps


@pytest.mark.parametrize("turn", [0, 0.05, 0.5])
@pytest.mark.parametrize("along", [False, True], ids=["evenly", "along"])
def test_lines_pass_near_all_vertices(turn: float, along: bool) -> None:
    lines, scratch = bent(300, turn, 0.15), Scratch()
    places = np.concatenate([np.linspace(0, 1, n) for n in np.diff(lines.first)]).astype(np.float32)
    if along:
        lines = Polylines(lines.first, lines.world, along=places**2)
        places = places**2
    maps = maps_of(lines)
    simple, texel = maps.simplified(lines, scratch), 1 / maps.views[0].focal
    assert simple.along is not None
    parts = []
    for (a, b), (c, d) in zip(pairwise(lines.first), pairwise(simple.first), strict=True):
        numbers = np.searchsorted(places[a:b], simple.along[c:d] - 1e-5)
        np.testing.assert_array_equal(simple.world[c:d], lines.world[a:b][numbers])
        np.testing.assert_allclose(simple.along[c:d], places[a:b][numbers], atol=1e-6)
        if b > a:
            assert (numbers[0], numbers[-1]) == (0, b - a - 1)
        assert (np.diff(numbers) > 0).all()
        assert (np.diff(numbers) <= 4).all()
        for u, v in pairwise(numbers):
            begin, end = lines.world[a + u].astype(float), lines.world[a + v].astype(float)
            way, points = end - begin, lines.world[a + u + 1 : a + v] - begin
            t = points @ way / max(way @ way, 1e-30)
            off = np.linalg.norm(points - t[:, None] * way, axis=1)
            # of four segments, the first vertex is beside a line of two, whose end is beside the longer one
            assert (off <= 2 * BENT * texel * 1.001).all()
            assert len(points) == 0 or np.linalg.norm(way) <= LONGEST * texel * 1.001
        parts.append((d - c) / max(b - a, 1))
    assert np.mean(parts) < (0.5 if turn == 0 else 0.95)


def test_bits_depend_on_no_number_of_bands() -> None:
    lines = bent(2000, 0.1)
    one, two = maps_of(lines), maps_of(lines, 3)
    assert one.stacks is not None
    np.testing.assert_array_equal(one.stacks, two.stacks)


def test_maps_hold_what_their_lines_add() -> None:
    lines = bent(400, 0.1)
    maps = maps_of(lines)
    simple = maps.simplified(lines, Scratch())
    assert len(simple.world) < 0.8 * len(lines.world)
    expected = splatted(maps, lines, WIDE)[..., -1]
    assert maps.stacks is not None
    heads = maps.stacks[: opacity.HEAD * len(maps.extents[0])].reshape(-1, opacity.HEAD)
    assert heads[:, opacity.WHOLE :].sum(dtype=np.float64) == pytest.approx(expected.sum(), rel=1e-4)


@pytest.mark.parametrize("points", [0, 1, 2])
def test_strands_of_hardly_any_vertices(points: int) -> None:
    world = np.zeros((3 * points, 3), np.float32)
    simple = maps_of(bent(9, 0.1)).simplified(Polylines(np.arange(4) * points, world), Scratch())
    np.testing.assert_array_equal(simple.first, np.arange(4) * points)


def test_what_stays_of_a_strand_depends_on_no_other() -> None:
    """Nor on how many vertices the strands before it have."""
    lines = bent(300, 0.05, 0.15)
    maps = maps_of(lines)
    all_of_them = maps.simplified(lines, Scratch())
    assert len(all_of_them.world) < 0.7 * len(lines.world)
    rng = np.random.default_rng(2)
    chosen = rng.random(300) < 0.5
    counts = np.where(chosen, np.diff(lines.first), 0)
    some = Polylines(np.append(0, np.cumsum(counts)), lines.world[np.repeat(chosen, np.diff(lines.first))])
    simple = maps.simplified(some, Scratch())
    kept = np.repeat(chosen, np.diff(all_of_them.first))
    np.testing.assert_array_equal(np.diff(simple.first), np.where(chosen, np.diff(all_of_them.first), 0))
    np.testing.assert_array_equal(simple.world, all_of_them.world[kept])
