"""Curls that swing in free air without drag and damping: their energy does not grow, nor is that of twist raised."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numba import njit
from numpy.typing import NDArray

from strand_kit import scene_of
from strandcli.blocks import aligned
from strandcli.constants import VECTOR
from strandcli.groom.emit import emit
from strandcli.simd import load, store, vector_pointer
from strandcli.simulate.kernels import rod_curl
from strandcli.simulate.kernels.rod_energy import UNKNOWN
from strandcli.simulate.rod import RodSolver

G, L = 9.81, 0.3


def curls(fps: int, particles: int, turns: int, angle: int, gamma: float, more: str, keys: str = "") -> RodSolver:
    """Sixteen curls with Γ = ρ A g L³ / B."""
    radius = 0.002 * L
    young = 4000 * G * L**3 / gamma / radius**2
    scene = scene_of(
        f"solver: rod\nrod: {{rest: shape, density: 1000, radius: {radius}, young: {young}, torsion: 0.7, drag: 0, "
        f"damping: 0{more}}}\ntime: {{fps: {fps}}}\nemitter: {{shape: {{kind: disc, radius: 0.06}}, strands: 16, "
        f"particles: {particles}, length: {L}, jitter: 20, rotation: [30, 0, 0], curl_turns: {turns}, curl_angle: "
        f"{angle}{keys}}}\nrules: [gravity, emitter_motion]\n"
    )
    return RodSolver(scene, emit(scene.emitter, scene.seed))


def energy(solver: RodSolver) -> NDArray[np.float64]:
    """(16,) of motion and weight, over m g L."""
    mass, rows = solver.mass.astype(float), solver.state.velocity
    velocity = rows.reshape(*rows.shape[:2], 3, -1).transpose(0, 3, 1, 2).reshape(-1, rows.shape[1], 3)[:16]
    kinetic = 0.5 * (mass[:, None] * solver.groom.emitted(velocity.astype(float)) ** 2).sum((1, 2))
    potential = G * (mass * solver.particles()[:, 1:, 1].astype(float)).sum(1)
    return np.asarray((kinetic + potential) / (G * L * mass.sum()))


def gained(solver: RodSolver, seconds: float) -> float:
    fps, begin, most = solver.scene.time.fps, energy(solver), -math.inf
    for i in range(round(seconds * fps)):
        solver.step((i + 1) / fps, 1 / fps)
        most = max(most, float((energy(solver) - begin).max()))
    return most


@pytest.mark.parametrize(
    ("fps", "particles", "turns", "angle", "gamma", "more"),
    [
        (24, 64, 12, 75, 1000, ", root: hinged"),
        (48, 16, 6, 75, 100, ""),
        (24, 32, 12, 56, 300, ""),
    ],
)  # fmt: skip
def test_energy_does_not_grow(fps: int, particles: int, turns: int, angle: int, gamma: float, more: str) -> None:
    """It grew by .4 to 150 m g L, of curls with 1.2 to 5.2 segments a turn."""
    assert gained(curls(fps, particles, turns, angle, gamma, more), 4) < 0.01


def test_resolved_curls_are_left_alone() -> None:
    """By twist that does not run away they keep their energy themselves."""
    solver = curls(24, 64, 6, 56, 30, "")
    for i in range(48):
        solver.step((i + 1) / 24, 1 / 24)
        assert not solver.state.calmed.any()
    assert (solver.state.energy < UNKNOWN / 2).all()


def test_strands_that_are_driven_may_gain_energy() -> None:
    keys = ", keys: [{time: 0, rotation: [30, 0, 0]}, {time: 0.5, rotation: [90, 0, 0]}]"
    solver = curls(24, 32, 3, 56, 30, "", keys)
    for i in range(16):
        solver.step((i + 1) / 24, 1 / 24)
        assert (solver.state.energy > UNKNOWN / 2).all() == (i < 12)


LANES = VECTOR // 8


@njit(error_model="numpy")
def torques(given: Any, out: Any, count: int) -> None:
    at, to = vector_pointer(given), vector_pointer(out)
    for i in range(count):
        x, y, v, w = load(at, i), load(at, count + i), load(at, 2 * count + i), load(at, 3 * count + i)
        turn, stiff = rod_curl.torque(x, y, v, w)
        store(to, i, turn)
        store(to, count + i, stiff)


def test_a_step_of_twist_lowers_the_energy_of_a_bend() -> None:
    """And goes to the balance at once where it is near."""
    draw, count = np.random.Generator(np.random.Philox(key=3)), 512 * LANES
    given, out = aligned((4, count), np.float64), aligned((2, count), np.float64)
    given[...] = draw.normal(size=given.shape)

    def bent(angle: NDArray[np.float64]) -> NDArray[np.float64]:
        x, y, v, w = given
        c, d = np.cos(angle), np.sin(angle)
        return 0.5 * ((c * x + d * y - v) ** 2 + (c * y - d * x - w) ** 2)

    def step() -> NDArray[np.float64]:
        torques(given.reshape(-1), out.reshape(-1), count // LANES)
        return np.asarray(out[0] / out[1])

    zero, first = np.zeros(count), step()
    assert (bent(first) <= bent(zero) + 1e-12).all()
    small = 1e-6
    slope = (bent(zero + small) - bent(zero - small)) / (2 * small)
    np.testing.assert_allclose(out[0], -slope, atol=1e-8)
    given[:2] = given[2:]  # at rest, and then turned a little
    c, d = math.cos(0.01), math.sin(0.01)
    given[0], given[1] = c * given[2] - d * given[3], c * given[3] + d * given[2]
    assert np.abs(step() - 0.01).max() < 1e-6
