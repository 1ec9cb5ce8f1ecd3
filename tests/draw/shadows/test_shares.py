"""Maps of some of the strands, in lights that add little."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from strandcli.draw.common.scratch import Scratch
from strandcli.draw.geometry.extent import Thickness
from strandcli.draw.shadows.shares import LEAST, SLACK, share_of, shares_of
from strandcli.draw.shadows.strands_in_map import Drawn, chances_of
from strandcli.scene.model import PointLight, Shadow
from tests.draw.shadows.test_deep_strands import STRANDS, SUN, THICK, maps_of
from tests.draw.shadows.test_opacity import depth, straight

FILL = replace(SUN, direction=(0.5, -1.0, 0.3), intensity=SUN.intensity / 10)


def test_a_light_that_adds_little_has_fewer_strands() -> None:
    one, few = shares_of((SUN, FILL))
    assert one == 1
    assert few == pytest.approx(1 / (1 + SLACK * 101))
    added = FILL.intensity**2 * (1 / few - 1)
    assert added == pytest.approx(SLACK * (SUN.intensity**2 + FILL.intensity**2))
    assert shares_of((SUN, replace(FILL, intensity=1e-6))) == [1, LEAST]
    assert shares_of((SUN, replace(FILL, colour=(0.0, 0.0, 0.0)))) == [1, 1]


def test_a_light_without_another_that_adds_more_has_all() -> None:
    assert shares_of((FILL,)) == [1]
    assert shares_of((SUN, replace(FILL, intensity=SUN.intensity / 2))) == [1, 1]
    assert shares_of((replace(SUN, shadow=Shadow(model="off")), FILL)) == [1, 1]
    assert shares_of((SUN, replace(FILL, shadow=Shadow(model="nearby")))) == [1, 1]
    assert shares_of((SUN, FILL, PointLight(position=(0.0, 3.0, 0.0)))) == [1, 1, 1]


def test_whether_a_strand_is_there_depends_on_no_other() -> None:
    lines, chances = straight(STRANDS, 3), chances_of(None, STRANDS)
    drawn = share_of(Drawn(lines, THICK, chances), 0.5, Scratch())
    some = np.isin(chances, drawn.chances)
    odd = np.arange(STRANDS) % 2 == 1
    ends = np.cumsum(np.diff(lines.first) * odd)
    fewer = replace(lines, first=np.append(0, ends), world=lines.world[np.repeat(odd, np.diff(lines.first))])
    without = share_of(Drawn(fewer, THICK, chances), 0.5, Scratch())
    assert without.among == drawn.among == STRANDS
    np.testing.assert_array_equal(without.chances, drawn.chances)
    np.testing.assert_array_equal(np.diff(without.lines.first) > 0, np.flatnonzero(some) % 2 == 1)
    assert drawn.thickness == Thickness(2 * THICK.width, THICK.taper)
    assert drawn.chances is not None
    assert len(drawn.chances) == pytest.approx(STRANDS / 2, rel=0.05)
    assert np.histogram(drawn.chances, 8, (0, 1))[0].min() > 0.85 * len(drawn.chances) / 8


def test_few_strands_are_all_drawn() -> None:
    drawn = Drawn(straight(100, 3), THICK, chances_of(None, 100))
    assert share_of(drawn, 0.5, Scratch()) is drawn


def test_light_is_the_same_on_average() -> None:
    lines = straight(STRANDS, 3)
    points = np.random.default_rng(1).uniform(-0.6, 0.6, (400, 3))
    whole = maps_of(lines, None)
    full = np.array([depth(whole, SUN, point) for point in points])
    passed = []
    for choice in range(4):
        some = maps_of(lines, chances_of(np.arange(STRANDS, dtype=np.int32) + 100_000 * choice, STRANDS), shares=[0.5])
        passed.append([depth(some, SUN, point) for point in points])
    light = np.exp(-np.array(passed))
    assert light.mean() == pytest.approx(np.exp(-full).mean(), abs=0.01)
    assert np.abs(light - np.exp(-full)).mean() < 0.03
