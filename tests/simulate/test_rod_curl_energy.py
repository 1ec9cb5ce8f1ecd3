"""Curls that swing in free air without drag and damping: their energy does not grow, nor is that of twist raised."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from rod_kit import each_step, rod_of
from strand_kit import require_same_after_restart
from strandcli.simulate.rod.solver import RodSolver

G = 9.81


def curls(
    fps: int, particles: int, turns: int, angle: int, gamma: float, more: str = "", keys: str = "", length: float = 0.3
) -> RodSolver:
    """Sixteen curls with Γ = ρ A g L³ / B."""
    radius = 0.002 * length
    young = 4000 * G * length**3 / gamma / radius**2
    return rod_of(
        f"rod: {{rest: shape, density: 1000, radius: {radius}, young: {young}, torsion: 0.7, drag: 0, "
        f"damping: 0{more}}}\ntime: {{fps: {fps}}}\nemitter: {{shape: {{kind: disc, radius: 0.06}}, strands: 16, "
        f"particles: {particles}, length: {length}, jitter: 20, rotation: [30, 0, 0], curl_turns: {turns}, "
        f"curl_angle: {angle}{keys}}}\nrules: [gravity, emitter_motion]\n"
    )


def energy(solver: RodSolver) -> NDArray[np.float64]:
    """(16,) of motion and weight, over m g L."""
    mass, rows = solver.mass.astype(float), solver.state.velocity
    velocity = rows.reshape(*rows.shape[:2], 3, -1).transpose(0, 3, 1, 2).reshape(-1, rows.shape[1], 3)[:16]
    kinetic = 0.5 * (mass[:, None] * solver.groom.emitted(velocity.astype(float)) ** 2).sum((1, 2))
    potential = G * (mass * solver.particles()[:, 1:, 1].astype(float)).sum(1)
    return np.asarray((kinetic + potential) / (G * solver.groom.lengths[0] * mass.sum()))


HINGED = ", root: hinged"


@pytest.mark.parametrize(
    ("fps", "particles", "turns", "angle", "gamma", "more", "length"),
    [
        (24, 64, 12, 75, 1000, HINGED, 0.3),
        (48, 16, 6, 75, 100, "", 0.3),
        (24, 32, 12, 56, 300, "", 0.3),
        (24, 64, 6, 56, 300, "", 0.3),
        (96, 64, 6, 56, 300, "", 0.3),
        (24, 64, 6, 56, 300, "", 1.0),
        (24, 20, 1, 30, 0.34, HINGED, 0.05),
        (96, 20, 1, 30, 0.34, HINGED, 0.05),
        (24, 26, 3, 56, 2.7, HINGED, 0.1),
        (96, 26, 3, 56, 2.7, HINGED, 0.1),
        (24, 64, 6, 56, 74, HINGED, 0.3),
    ],
)
def test_energy_does_not_grow(
    fps: int, particles: int, turns: int, angle: int, gamma: float, more: str, length: float
) -> None:
    """With 1.2 to 20 segments a turn. It grew by .06 to 150 m g L where twist or frames run away."""
    solver = curls(fps, particles, turns, angle, gamma, more, length=length)
    begin, most = energy(solver), -math.inf
    for _ in each_step(solver, fps, 4 * fps):
        most = max(most, float((energy(solver) - begin).max()))
    assert most < 0.01


def test_a_run_of_hinged_curls_goes_on_from_its_state() -> None:
    keys = ", keys: [{time: 0}, {time: 1, rotation: [0, 200, 60]}]"
    require_same_after_restart(*(curls(24, 13, 3, 56, 2.7, HINGED, keys, 0.1) for _ in range(2)))
