"""Curls that lean on solids, and swing among other strands."""

from __future__ import annotations

import numpy as np
import pytest

from strand_kit import scene_of
from strandcli.groom.emit import emit
from strandcli.simulate.rod.solver import RodSolver


@pytest.mark.parametrize("more", ["", "torsion: 0.7"])
def test_curls_that_lean_on_a_ball_come_to_rest(more: str) -> None:
    """Where edges that a solid presses are not kept, tips twitch by 1 to 3 mm a frame, for ever."""
    scene = scene_of(
        f"solver: rod\nrod: {{rest: shape, radius: 6.0e-5, drag: 1.5, damping: 0.0005, friction: 0.2, {more}}}\n"
        "emitter: {shape: {kind: sphere, radius: 0.1}, strands: 128, particles: 64, length: 0.3, curl_turns: 8, "
        "curl_angle: 56, comb: [0.85, -0.55, -0.15], lift: 30}\n"
        "solids: [{kind: sphere, radius: 0.1}]\nrules: [gravity, collision]\n"
    )
    solver = RodSolver(scene, emit(scene.emitter, scene.seed))
    tips = []
    for i in range(1, 121):
        solver.step(i / 24, 1 / 24)
        tips.append(solver.particles()[:, -1].astype(float))
    moved = np.linalg.norm(np.diff(tips[-13:], axis=0), axis=-1)
    assert np.sqrt((moved**2).mean()) < 1e-4
    assert moved.max() < 6e-4


def test_strands_that_interact_swing_as_long_as_alone() -> None:
    """By default, where they keep their distance: Euler's method would take more than half of it a cycle."""
    last = []
    for rule in ("", ", interaction: {density: 1.0e+9, friction: 0, cell: 0.05}"):
        scene = scene_of(
            "solver: rod\nrod: {rest: straight, drag: 0, damping: 0}\nemitter: {shape: {kind: disc, radius: 0.05}, "
            "strands: 64, particles: 8, length: 0.25, rotation: [150, 0, 0]}\ntime: {fps: 24}\n"
            f"rules: [gravity{rule}]\n"
        )
        solver = RodSolver(scene, emit(scene.emitter, scene.seed))
        tips = []
        for i in range(1, 97):
            solver.step(i / 24, 1 / 24)
            x = solver.particles().astype(float)
            tips.append((x[:, -1] - x[:, 0])[:, 2].mean())
        last.append(np.ptp(tips[-30:]))
    assert last[1] == pytest.approx(last[0], rel=0.02)
    assert last[0] > 0.1
