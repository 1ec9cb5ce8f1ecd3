"""Moments and steps of a film: steps that vary, motion that repeats, what is computed for several steps at once."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

import strandcli
from strand_kit import groom_of, scene_of, solver_of, warned
from strandcli import simulate
from strandcli.constants import W
from strandcli.errors import UsageError
from strandcli.scene.model import Scene
from strandcli.simulate.rules import wind
from strandcli.simulate.solver import ANNOUNCED
from strandcli.simulate.thesis import solver as thesis
from strandcli.study.claims import tremble
from tests.simulate.test_motion import ALL, TURN

SETTINGS = {
    "emitter.strands": 40, "emitter.particles": 8, "emitter.length": 1.0, "emitter.keys": [], "time.fps": 24,
    "time.preroll": 8.0, "rules": ["gravity", {"stiffness": {"strength": 40.0}}, "elasticity"],
}  # fmt: skip


def scene(jitter: float, **more: object) -> Scene:
    return strandcli.load("headline", settings={**SETTINGS, "time.jitter": jitter, **more})


def test_resting_strands_tremble_by_stiffness_and_steps_that_vary() -> None:
    assert tremble(scene(0.0), 24) < 1e-5
    assert tremble(scene(0.5), 24) > 0.01
    assert tremble(scene(0.5, rules=["elasticity"]), 24) < 1e-5


def test_steps_are_spread_evenly_about_the_given_one() -> None:
    one = solver_of(scene(0.5))
    steps = np.sort([one._stretched(number / 24, 1 / 24) for number in range(-100, 400)])
    assert np.allclose(steps, np.linspace(0.5, 1.5, 500), atol=0.01)
    assert solver_of(scene(0.0))._stretched(3.0, 1 / 24) == 1.0


def test_a_step_asks_its_rules_for_its_own_length() -> None:
    """Gravity alone moves a particle by g Δt²."""
    one = solver_of(scene(0.5, rules=["gravity"]), plain=True)
    before = one.particles()[:, -1, 1]
    one.step(1.0, 1 / 24)
    fallen = before - one.particles()[:, -1, 1]
    assert fallen == pytest.approx(9.81 * (one._stretched(1.0, 1 / 24) / 24) ** 2, rel=1e-3)


def test_rods_say_that_they_ignore_it() -> None:
    rods = strandcli.load("headline", settings={"solver": "rod", "time.jitter": 0.5, "emitter.strands": 4})
    assert any(words.startswith("time.jitter: ignored") for words in warned(rods))
    with pytest.raises(UsageError, match="jitter"):
        scene(1.0)


def tips(scene: Scene, *frames: int) -> list[np.ndarray]:
    """Of each frame the (strands, 3) tips, metres."""
    solver = simulate.solver_of(scene)(scene, groom_of(scene))
    found = []
    for frame in frames:
        solver.advance(frame)
        found.append(solver.particles()[:, -1].astype(np.float64))
    return found


@pytest.mark.parametrize("preset", ["hair", pytest.param("ponytail", marks=pytest.mark.long), "fur"])
def test_presets_that_say_so_loop(preset: str) -> None:
    """The frame after the last is the first again: no tip is off by more than tips move from one frame to the next,
    and nearly all by far less. Rods that slide on shoulders need not come to lie in the very same way. All strands are
    simulated, for those that interact may loop where fewer would, or the other way round."""
    scene = strandcli.load(preset)
    assert scene.time.loop
    count = scene.time.frames
    first, *others, last, again = tips(scene, *range(1, count + 2))
    before = [first, *others, last]
    step = max(float(np.linalg.norm(b - a, axis=1).max()) for a, b in pairwise(before))
    off = np.linalg.norm(again - first, axis=1)
    assert off.max() <= step
    assert off.mean() < 5e-4
    assert np.linalg.norm(first - last, axis=1).max() <= 1.5 * step


def test_keys_and_gusts_repeat_before_and_after() -> None:
    scene = scene_of("time: {frames: 48, fps: 24, loop: true}")
    assert scene.time.period == 2.0
    assert [scene.time.pose_time(time) for time in (-0.5, 0.0, 1.5, 2.25)] == [1.5, 0.0, 1.5, 0.25]
    held = scene_of("time: {frames: 48, fps: 24}")
    assert (held.time.period, held.time.pose_time(-0.5), held.time.pose_time(2.25)) == (0.0, 0.0, 2.25)
    phases = [0.1, 0.7, 0.4]
    for time in (-1.3, 0.0, 0.4):
        later = wind.gusts(time + 3.0, 0.55, phases, 3.0)
        assert wind.gusts(time, 0.55, phases, 3.0) == pytest.approx(later, abs=1e-12)
    assert wind.fitted(0.55, 3.0) == pytest.approx(0.6)
    assert wind.fitted(10.0, 3.0) == 3.0  # no wave is longer than the loop
    assert wind.fitted(0.55, 0.0) == 0.55


def test_a_loop_whose_keys_lead_elsewhere_is_told() -> None:
    text = "time: {frames: 48, loop: LOOP}\nemitter: {strands: 3, keys: [{time: 0}, {time: 2, position: [X, 0, 0]}]}\n"
    (words,) = warned(text.replace("LOOP", "true").replace("X", "1"))
    assert words.startswith("emitter: time.loop repeats all motion after 2 s, where its keys have not led back")
    for loop, x in (("true", "0"), ("false", "1")):
        assert warned(text.replace("LOOP", loop).replace("X", x)) == []


SCENES: dict[str, dict[str, Any]] = {
    "rules": {},
    "substeps": {"time.substeps": 3},
    "a loop": {"time.loop": True, "time.frames": 12},
    "steps that vary": {"time.jitter": 0.5},
}


def solver(**changes: Any) -> Any:
    settings = {
        "emitter": {"strands": 20, "particles": 6, "length": 0.5, "shape": {"kind": "sphere", "radius": 0.3}},
        "emitter.keys": TURN, "time": {"fps": 10, "frames": 40}, "solver": "thesis", "solids": ALL,
        "rules": ["emitter_motion", "gravity", {"wind": {"strength": 5, "gust": 0.5, "sway": 30}}, "collision"],
        **changes,
    }  # fmt: skip
    one = strandcli.load("minimal", settings=settings)
    return simulate.solver_of(one)(one, groom_of(one))


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
