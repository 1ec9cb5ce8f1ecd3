"""Motion that repeats: `time.loop`."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

import strandcli
from strand_kit import groom_of, scene_of
from strandcli.groom.emit import emit
from strandcli.scene import Scene
from strandcli.simulate import advice, solver_of
from strandcli.simulate.rules import wind


def tips(scene: Scene, *frames: int) -> list[np.ndarray]:
    """Of each frame the (strands, 3) tips, metres."""
    solver = solver_of(scene)(scene, emit(scene.emitter, scene.seed))
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
    there = scene_of(text.replace("LOOP", "true").replace("X", "1"))
    (words,) = advice.warnings(there, groom_of(there))
    assert words.startswith("emitter: time.loop repeats all motion after 2 s, where its keys have not led back")
    for loop, x in (("true", "0"), ("false", "1")):
        fine = scene_of(text.replace("LOOP", loop).replace("X", x))
        assert advice.warnings(fine, groom_of(fine)) == []
