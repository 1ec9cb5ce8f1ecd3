"""What solvers compute for several steps at once: the same motion as step by step, and no more than they may."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import strandcli
from strandcli.constants import W
from strandcli.groom.emit import emit
from strandcli.simulate import solver_of
from strandcli.simulate.solver import ANNOUNCED
from strandcli.simulate.thesis import solver as thesis
from tests.simulate.test_surroundings import ALL, TURN

SCENES: dict[str, dict[str, Any]] = {
    "rules": {},
    "substeps": {"time.substeps": 3},
    "a loop": {"time.loop": True, "time.frames": 12},
    "steps that vary": {"time.jitter": 0.5},
}


def solver(**changes: Any) -> Any:
    settings = {
        "emitter": {"strands": 20, "particles": 6, "length": 0.5, "shape": {"kind": "sphere", "radius": 0.3}},
        "emitter.keys": TURN,
        "time": {"fps": 10, "frames": 40},
        "solver": "thesis",
        "solids": ALL,
        "rules": ["emitter_motion", "gravity", {"wind": {"strength": 5, "gust": 0.5, "sway": 30}}, "collision"],
        **changes,
    }
    one = strandcli.load("minimal", settings=settings)
    return solver_of(one)(one, emit(one.emitter, one.seed))


@pytest.mark.parametrize("changes", SCENES.values(), ids=SCENES)
def test_steps_that_are_announced_move_strands_as_others_do(changes: dict[str, Any]) -> None:
    told, untold = solver(**changes), solver(**changes)
    untold.announce = lambda ends, dt: None
    for frame in range(1, 2 * ANNOUNCED + 3):
        told.advance(frame)
        untold.advance(frame)
        np.testing.assert_array_equal(told.positions, untold.positions)


def test_what_was_announced_before_a_state_was_restored_is_not_used_where_it_does_not_follow() -> None:
    one, other = solver(), solver()
    one.advance(4)
    state = {name: array.copy() for name, array in one.state_arrays().items()}
    other.advance(3)
    other.restore(state)
    for frame in (5, 6):
        one.advance(frame)
        other.advance(frame)
        np.testing.assert_array_equal(one.positions, other.positions)


def test_rules_that_remember_steps_are_prepared_one_by_one(monkeypatch: pytest.MonkeyPatch) -> None:
    passes_of = thesis.passes_of

    def remembering(scene: Any) -> Any:
        return [(use, replace(one, state=(np.zeros(1),))) for use, one in passes_of(scene)]

    monkeypatch.setattr(thesis, "passes_of", remembering)
    one = solver()
    one.advance(3)
    assert not one._known


def test_lanes_without_a_strand_are_copies_of_the_last() -> None:
    one = solver(solver="rod")
    one.advance(3)
    rows = one.positions[-1].reshape(-1, W)
    assert (rows[:, 20:] == rows[:, 19:20]).all()
