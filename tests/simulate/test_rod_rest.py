"""Strands that can turn come to rest, alone and on solids, at steps as long as a frame."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from strand_kit import scene_of
from strandcli.groom.emit import emit
from strandcli.simulate.rod.solver import RodSolver

FLOOR = "{kind: plane, position: [0, -0.02, 0]}"
BALL = "{kind: sphere, radius: 0.03, position: [0, 0.04, 0]}"
CAPSULE = "{kind: capsule, radius: 0.03, length: 0.2, position: [0, 0.04, 0], rotation: [70, 0, 0]}"


STILL = 5e-5
"""Metres a frame, root mean square of tips: what is left on a solid at rest."""


def motion_at_rest(
    rod: str, length: float, solids: str = "", seconds: int = 16, more: str = "", radius: str = "1.0e-4"
) -> NDArray[np.float64]:
    """(frames, strands) how far tips move in a frame of the last second, metres. ``more``: of the emitter."""
    rules, rate = "[gravity, collision]" if solids else "[gravity]", 24
    scene = scene_of(
        f"solver: rod\nrod: {{radius: {radius}, drag: 5, damping: 0.01, {rod}}}\ntime: {{fps: {rate}}}\n"
        f"emitter: {{shape: {{kind: disc, radius: 0.03}}, strands: 100, particles: 12, length: {length}, "
        f"jitter: 20{more}}}\n"
        f"rules: {rules}\nsolids: [{solids}]\n"
    )
    solver = RodSolver(scene, emit(scene.emitter, scene.seed))
    tips = []
    for i in range(seconds * rate):
        solver.step((i + 1) / rate, 1 / rate)
        tips.append(solver.particles()[:, -1].astype(float))
    return np.asarray(np.linalg.norm(np.diff(tips[-rate:], axis=0), axis=-1))


def rms(moved: NDArray[np.float64]) -> float:
    return float(np.sqrt((moved**2).mean()))


@pytest.mark.parametrize("length", [0.01, 0.015, 0.018, 0.02, 0.025])
def test_a_pendulum_of_about_a_radian_a_step_does_not_turn_for_ever(length: float) -> None:
    """By BDF2 alone those of 15 to 20 mm turn by a quarter at each step."""
    assert motion_at_rest("root: hinged", length).max() < 1e-6


@pytest.mark.parametrize("length", [0.05, 0.1])
@pytest.mark.parametrize("root", ["clamped", "hinged"])
@pytest.mark.parametrize("solid", [FLOOR, BALL, CAPSULE], ids=["floor", "ball", "capsule"])
def test_strands_rest_on_solids(solid: str, root: str, length: float) -> None:
    assert rms(motion_at_rest(f"root: {root}", length, solid)) < STILL


@pytest.mark.parametrize("radius", ["1.0e-4", "3.0e-5"])
@pytest.mark.parametrize("friction", [0, 0.2])
@pytest.mark.parametrize("root", ["clamped", "hinged"])
@pytest.mark.parametrize("height", [0.05, 0.08, 0.09, 0.098])
def test_strands_that_hang_down_to_a_floor_rest_on_their_tips(
    height: float, root: str, friction: float, radius: str
) -> None:
    """They are longer than their height by 2 to 50 mm."""
    above = f", rotation: [180, 0, 0], position: [0, {height - 0.02}, 0]"
    assert rms(motion_at_rest(f"root: {root}, friction: {friction}", 0.1, FLOOR, more=above, radius=radius)) < STILL


def test_strands_that_leave_a_solid_are_marked_no_more() -> None:
    """They go by BDF2 again from the step after the one by Euler's method on."""
    scene = scene_of(
        "solver: rod\nrod: {radius: 1.0e-4, drag: 5}\ntime: {fps: 24}\n"
        "emitter: {shape: {kind: disc, radius: 0.01}, strands: 20, particles: 8, length: 0.1, jitter: 5,"
        " keys: [{time: 0, rotation: [180, 0, 0], position: [0, 0.05, 0]},"
        " {time: 1, rotation: [180, 0, 0], position: [0, 0.05, 0]},"
        " {time: 2, rotation: [180, 0, 0], position: [0, 0.3, 0]}]}\n"
        "rules: [emitter_motion, gravity, collision]\nsolids: [{kind: plane, position: [0, -0.02, 0]}]\n"
    )
    solver = RodSolver(scene, emit(scene.emitter, scene.seed))
    seen = []
    for i in range(72):
        solver.step((i + 1) / 24, 1 / 24)
        seen.append((solver.state.force.any(), solver.state.restart.any()))
    assert seen[22][0]
    assert not any(seen[-1])
