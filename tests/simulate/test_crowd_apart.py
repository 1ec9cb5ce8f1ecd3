"""Loose strands that fly so far off that the grid has no room for them."""

from __future__ import annotations

from typing import Any
from unittest.mock import patch

import numba
import numpy as np
import pytest
from numpy.typing import NDArray

from loose_kit import SEGMENTS, STEP, Loose, groom_about
from strandcli.errors import UsageError
from strandcli.simulate import crowd_box
from strandcli.simulate.crowd_apart import chosen, groups_of
from strandcli.simulate.health import beyond_the_grid

STILL = "gravity: {acceleration: [0, 0, 0]}"
RULE = "interaction: {friction: 0.3, cell: 0.05, density: 30}"
COUNT = 40
WIND = "wind: {direction: [0, 0, 1], strength: 3, gust: 0}"


def tangle(extra: Any = (), rules: str = f"{STILL}, {RULE}", rod: str = "drag: 0") -> Loose:
    """Strands in all directions that are too dense, and more of them about other ``extra`` (M, 3) middles, in the
    order of `COUNT` and then these."""
    rng = np.random.default_rng(3)
    middles, ways = rng.uniform(-0.1, 0.1, (COUNT, 3)), rng.normal(size=(COUNT, 3))
    extra = np.reshape(extra, (-1, 3))
    return Loose(groom_about([*middles, *extra], [*ways, *np.tile([1.0, 0, 0], (len(extra), 1))]), rules, rod)


def test_one_that_is_thrown_a_thousand_kilometres_goes_on_alone() -> None:
    """And the others do as they do without it, to the bit."""
    both, alone = tangle([1.0e6, 2.0e5, -3.0e5]), tangle()
    for loose in (both, alone):
        loose.run(0.5)
    np.testing.assert_array_equal(both.places()[:COUNT], alone.places())
    assert np.linalg.norm(alone.places() - tangle().places(), axis=2).max() > 0.05  # pressure parts them
    assert np.abs(both.velocities()[COUNT]).max() == 0
    errors = both.solver.errors(1)
    assert errors["left_out"] == 1
    assert "left_out" not in alone.solver.errors(1)
    assert errors["momentum_lost"] < 1e-7
    assert "frame 1: 1 of 41 strands are so far off" in beyond_the_grid(both.solver, 1, errors)
    assert beyond_the_grid(alone.solver, 1, alone.solver.errors(1)) == ""


def test_one_that_flies_off_and_comes_back_is_left_out_in_between() -> None:
    """With room for cells that a few metres take: thrown off at 120 m/s, and back."""
    loose = tangle([0.0, 0.0, 0.8], rod="drag: 0, integrator: euler")
    thrown = np.zeros((COUNT + 1, SEGMENTS + 1, 3))
    found = []
    with patch.object(crowd_box, "MOST_CELLS", 30_000):
        for way, steps in ((120.0, 10), (-120.0, 10)):
            thrown[COUNT, :, 2] = way
            loose.throw(thrown)
            for _ in range(steps):
                loose.run(STEP)
                found.append(loose.solver.errors(1).get("left_out", 0))
    assert found[0] == found[-1] == 0
    assert max(found) == 1
    assert np.isfinite(loose.places()).all()


def test_wind_takes_along_what_is_left_out_as_it_takes_a_single_strand() -> None:
    rules = f"{STILL}, {WIND}, interaction: {{cell: 0.05, density: 2000}}"
    both = tangle([1.0e5, 0.0, 0.0], rules, "drag: 2")
    one = Loose(groom_about([[1.0e5, 0.0, 0.0]], [[1.0, 0, 0]]), f"{STILL}, {WIND}", "drag: 2")
    for loose in (both, one):
        loose.run(0.5)
    np.testing.assert_array_equal(both.velocities()[COUNT], one.velocities()[0])


def test_any_number_of_threads_gives_the_same_bits() -> None:
    """Of strands that burst apart in all directions, in several parts."""
    found = []
    for threads in {1, min(2, numba.config.NUMBA_NUM_THREADS)}:
        numba.set_num_threads(threads)
        rng = np.random.default_rng(5)
        loose = Loose(groom_about(rng.uniform(-0.1, 0.1, (900, 3)), rng.normal(size=(900, 3))), f"{STILL}, {RULE}")
        ways = loose.places().mean(1, keepdims=True)
        loose.throw(np.broadcast_to(1.0e3 * ways, (900, SEGMENTS + 1, 3)) * (np.arange(900) % 2)[:, None, None])
        loose.run(0.2)
        assert 100 < loose.solver.errors(1)["left_out"] <= 450
        found.append(loose.places())
    assert np.isfinite(found[0]).all()
    for one in found:
        np.testing.assert_array_equal(one, found[0])


def test_what_is_too_large_in_itself_is_told_as_before() -> None:
    with patch.object(crowd_box, "MOST_CELLS", 100), pytest.raises(UsageError, match="make them at least"):
        tangle([1.0e6, 0, 0]).run(STEP)


def boxes(places: Any, size: float = 3.0) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    low = np.array(places, np.float64)
    return low, low + size


def test_groups_have_empty_cells_between_them() -> None:
    rng = np.random.default_rng(2)
    for count, wide in ((1, 1), (2, 60), (300, 300), (300, 60), (2000, 1e3), (50, 1e30)):
        low, high = boxes(np.floor(rng.uniform(-wide, wide, (count, 3))))
        high += np.floor(rng.uniform(0, 5, (count, 3)))
        groups = groups_of(low, high)
        gaps = np.maximum(low[:, None] - high[None], low[None] - high[:, None]).max(-1)
        assert (gaps[groups[:, None] != groups[None]] > 2).all()
        if wide > 100:  # and what is alone by twice the reach is in a group of its own
            gaps[np.arange(count), np.arange(count)] = np.inf
            for strand in np.flatnonzero(gaps.min(1) > 25):
                assert np.count_nonzero(groups == groups[strand]) == 1


def test_a_chain_is_one_group_however_long() -> None:
    row = np.zeros((3000, 3))
    row[:, 1] = 5 * np.random.default_rng(0).permutation(3000)
    assert len(set(groups_of(*boxes(row)))) == 1
    row[row[:, 1] >= 5 * 1500, 1] += 20
    assert len(set(groups_of(*boxes(row)))) == 2


def test_groups_of_most_strands_come_first_as_long_as_there_is_room() -> None:
    low, high = boxes([[0, 0, 0], [1e4, 0, 0], [1e4, 1, 0], [1e4, 0, 1], [1e4 + 40, 0, 0], [1e9, 0, 0], [1e9, 1, 0]])
    groups = groups_of(low, high)
    assert chosen(groups, low, high, 0).tolist() == [True, True, True, True, True, False, False]
    with patch.object(crowd_box, "MOST_CELLS", 5 * 5 * 100):
        assert chosen(groups, low, high, 0).tolist() == [False, True, True, True, True, False, False]
        assert chosen(groups, low, high, 9).tolist() == [False, True, True, True, False, False, False]
