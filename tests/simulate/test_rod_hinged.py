"""Strands with hinged roots whose rest shapes have frames: energy without drag and damping, freedom, resumed runs."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from strand_kit import scene_of
from strandcli.groom.emit import emit
from strandcli.simulate.rod import RodSolver

CURL = ", curl_turns: {}, curl_angle: {}"


def solver_of(rod: str, fps: int, length: float, particles: int, more: str = "") -> RodSolver:
    scene = scene_of(
        f"solver: rod\nrod: {{density: 1000, root: hinged, torsion: 0.7, drag: 0, damping: 0, {rod}}}\n"
        f"time: {{fps: {fps}}}\nemitter: {{shape: {{kind: disc, radius: 0.02}}, strands: 16, particles: {particles}, "
        f"length: {length}, jitter: 20, rotation: [90, 0, 0]{more}}}\nrules: [emitter_motion, gravity]\n"
    )
    return RodSolver(scene, emit(scene.emitter, scene.seed))


def energy(solver: RodSolver) -> NDArray[np.float64]:
    """(16,) kinetic and potential energy of strands over their weight times their length."""
    mass, rows = solver.mass.astype(float), solver.state.velocity
    velocity = rows.reshape(*rows.shape[:2], 3, -1).transpose(0, 3, 1, 2).reshape(-1, rows.shape[1], 3)[:16]
    velocity, pull = solver.groom.emitted(velocity.astype(float)), 9.81
    potential = pull * (mass * solver.particles()[:, 1:, 1].astype(float)).sum(1)
    kinetic = 0.5 * (mass[:, None] * velocity**2).sum((1, 2))
    return (potential + kinetic) / (pull * solver.groom.lengths[0] * mass.sum())


def growth(solver: RodSolver, fps: int, seconds: int) -> float:
    """The most that a strand's energy grows by over its beginning, g L."""
    begin, most = energy(solver), -math.inf
    for i in range(seconds * fps):
        solver.step((i + 1) / fps, 1 / fps)
        most = max(most, float((energy(solver) - begin).max()))
    return most


@pytest.mark.parametrize(
    ("length", "particles", "turns", "angle", "fps"),
    [(0.05, 20, 1, 30, 24), (0.05, 20, 1, 30, 96), (0.1, 26, 3, 56, 24), (0.1, 26, 3, 56, 96), (0.3, 64, 6, 56, 24)],
)
def test_curls_gain_no_energy(length: float, particles: int, turns: int, angle: int, fps: int) -> None:
    """With frames from the direction of emission it grows by 1.8 to 55 g L."""
    solver = solver_of("rest: shape, radius: 6.0e-5, young: 4.0e+9", fps, length, particles, CURL.format(turns, angle))
    assert growth(solver, fps, 4) < 0.01


def test_a_run_goes_on_from_its_state() -> None:
    curl = CURL.format(3, 56) + ", keys: [{time: 0}, {time: 1, rotation: [0, 200, 60]}]"
    whole, other = (solver_of("rest: shape", 24, 0.1, 13, curl) for _ in range(2))
    for i in range(20):
        if i == 12:
            saved = {name: one.copy() for name, one in whole.state_arrays().items()}
            other.restore(saved)
        whole.step((i + 1) / 24, 1 / 24)
        if i >= 12:
            other.step((i + 1) / 24, 1 / 24)
    np.testing.assert_array_equal(whole.positions, other.positions)
