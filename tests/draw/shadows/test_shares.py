"""Maps of some of the strands, in lights that add little."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from strandcli.draw.shadows.shares import LEAST, SLACK, shares_of
from strandcli.draw.shadows.strands_in_map import chances_of
from strandcli.scene.model import PointLight, Shadow
from tests.draw.shadows.test_deep_strands import STRANDS, SUN, maps_of
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
    assert shares_of((SUN, replace(FILL, shadow=Shadow(model="minmax")))) == [1, 1]
    assert shares_of((SUN, FILL, PointLight(position=(0.0, 3.0, 0.0)))) == [1, 1, 1]


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
