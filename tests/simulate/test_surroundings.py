"""What acts on rods from outside: solids with their motion, and moving air."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from strandcli.constants import W
from strandcli.errors import UsageError
from strandcli.simulate.rod.surroundings import Surroundings
from tests.simulate.test_rod import scene

TURN = [{"time": 0, "position": [0, 0, 0]}, {"time": 1, "position": [1, 0.5, 0], "rotation": [30, 120, -20]}]
ALL = [
    {"kind": "sphere", "radius": 0.2, "position": [0, 1, 0], "follow": "emitter"},
    {"kind": "sphere", "radius": 0.3, "position": [3, 0, 0]},
    {"kind": "sphere", "radius": 0.1, "keys": TURN},
    {"kind": "capsule", "radius": 0.1, "length": 1, "keys": TURN},
    {"kind": "capsule", "radius": 0.2, "length": 2, "position": [5, 0, 0]},
    {"kind": "plane", "position": [0, -3, 0], "keys": TURN},
    {"kind": "box", "size": [1, 2, 3], "position": [0, 0, 2], "follow": "emitter"},
]


def around(collision: Any = "collision", *rules: Any, **changes: Any) -> Surroundings:
    one = scene(10.0, **{"solids": ALL, "emitter.keys": TURN, "rules": ["gravity", collision, *rules], **changes})
    return Surroundings(one, np.float64)


def test_only_the_solids_that_are_named_are_touched() -> None:
    named = [{**one, "name": f"solid{i}"} for i, one in enumerate(ALL)]
    mine = around({"collision": {"with": ["solid1"]}}, solids=named)
    packed, whole = mine.solids(0.1, 0.1), mine.segments
    assert [rows.shape for rows in packed] == [(1, 17), (0, 21), (0, 16), (0, 28)]
    assert mine.any_solids
    assert not whole
    mine = around({"collision": {"with": ["solid1"], "segments": True}}, solids=named)
    packed, whole = mine.solids(0.1, 0.1), mine.segments
    assert whole
    assert [len(rows) for rows in packed] == [1, 0, 0, 0]
    mine = around("emitter_motion", solids=named)
    assert [len(rows) for rows in mine.solids(0.1, 0.1)] == [0, 0, 0, 0]
    assert not mine.any_solids


def test_gusts_that_travel_differ_from_place_to_place_and_others_do_not() -> None:
    calm = around("collision", {"wind": {"strength": 3.0, "direction": [0, 0, 2]}})
    assert calm.gust(0.3, np.zeros((1, 3, 24))) is None
    np.testing.assert_allclose(calm.air(0.3), (0, 0, 3))
    gusty = around("collision", {"wind": {"strength": 3.0, "gust": 1.0}})
    speeds = [gusty.air(time)[0] for time in np.linspace(0, 5, 50)]
    assert 0 <= min(speeds) < 0.6
    assert 2.4 < max(speeds) <= 3
    travelling = around("collision", {"wind": {"strength": 3.0, "gust": 1.0, "wavelength": 0.5}})
    np.testing.assert_allclose(travelling.air(0.3), (3, 0, 0))


@pytest.mark.parametrize("other", [{"gust": 0.5, "wavelength": 0.2}, {"gust": 0.5}, {}])
def test_gusts_that_travel_are_refused_beside_another_wind(other: dict[str, Any]) -> None:
    """Its strength would come and go with theirs."""
    travelling = {"wind": {"strength": 3.0, "gust": 1.0, "wavelength": 0.5}}
    for winds in ([travelling, {"wind": other}], [{"wind": other}, travelling]):
        with pytest.raises(UsageError, match=r"rule wind: of 2 winds, .* solver rod supports travelling gusts only"):
            around("collision", *winds)
    still = {"wind": {"strength": 0.0, **other}}
    assert around("collision", travelling, still).gust(0.3, np.zeros((1, 3, 3 * W))) is not None
