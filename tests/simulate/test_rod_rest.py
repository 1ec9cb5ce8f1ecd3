"""Strands come to rest, alone, on solids and leaning on them, at steps as long as a frame or as their fall."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from rod_kit import each_step, motion_at_rest, rms, rod_of
from strand_kit import scene_of
from strandcli.groom.record import Groom
from strandcli.simulate.rod.solver import RodSolver

FLOOR = "{kind: plane, position: [0, -0.02, 0]}"
BALL = "{kind: sphere, radius: 0.03, position: [0, 0.04, 0]}"
CAPSULE = "{kind: capsule, radius: 0.03, length: 0.2, position: [0, 0.04, 0], rotation: [70, 0, 0]}"


RATE = 24
STILL = 5e-5
"""Metres a frame, root mean square of tips: what is left on a solid at rest."""


def tips_at_rest(
    rod: str, length: float, solids: str = "", more: str = "", radius: str = "1.0e-4"
) -> NDArray[np.float64]:
    """(frames, strands) how far tips move in a frame of the last of 16 seconds, metres. ``more``: of the emitter."""
    rules = "[gravity, collision]" if solids else "[gravity]"
    solver = rod_of(
        f"rod: {{radius: {radius}, drag: 5, damping: 0.01, {rod}}}\ntime: {{fps: {RATE}}}\n"
        f"emitter: {{shape: {{kind: disc, radius: 0.03}}, strands: 100, particles: 12, length: {length}, "
        f"jitter: 20{more}}}\n"
        f"rules: {rules}\nsolids: [{solids}]\n"
    )
    return motion_at_rest(solver, RATE, 16)[..., -1]


@pytest.mark.parametrize("length", [0.01, 0.015, 0.018, 0.02, 0.025])
def test_a_pendulum_of_about_a_radian_a_step_does_not_turn_for_ever(length: float) -> None:
    """By BDF2 alone those of 15 to 20 mm turn by a quarter at each step."""
    assert tips_at_rest("root: hinged", length).max() < 1e-6


@pytest.mark.parametrize("length", [0.05, 0.1])
@pytest.mark.parametrize("root", ["clamped", "hinged"])
@pytest.mark.parametrize("solid", [FLOOR, BALL, CAPSULE], ids=["floor", "ball", "capsule"])
def test_strands_rest_on_solids(solid: str, root: str, length: float) -> None:
    assert rms(tips_at_rest(f"root: {root}", length, solid)) < STILL


@pytest.mark.parametrize("radius", ["1.0e-4", "3.0e-5"])
@pytest.mark.parametrize("friction", [0, 0.2])
@pytest.mark.parametrize("root", ["clamped", "hinged"])
@pytest.mark.parametrize("height", [0.05, 0.08, 0.09, 0.098])
def test_strands_that_hang_down_to_a_floor_rest_on_their_tips(
    height: float, root: str, friction: float, radius: str
) -> None:
    """They are longer than their height by 2 to 50 mm."""
    above = f", rotation: [180, 0, 0], position: [0, {height - 0.02}, 0]"
    assert rms(tips_at_rest(f"root: {root}, friction: {friction}", 0.1, FLOOR, more=above, radius=radius)) < STILL


def test_strands_that_leave_a_solid_are_marked_no_more() -> None:
    """They go by BDF2 again from the step after the one by Euler's method on."""
    solver = rod_of(
        "rod: {radius: 1.0e-4, drag: 5}\ntime: {fps: 24}\n"
        "emitter: {shape: {kind: disc, radius: 0.01}, strands: 20, particles: 8, length: 0.1, jitter: 5,"
        " keys: [{time: 0, rotation: [180, 0, 0], position: [0, 0.05, 0]},"
        " {time: 1, rotation: [180, 0, 0], position: [0, 0.05, 0]},"
        " {time: 2, rotation: [180, 0, 0], position: [0, 0.3, 0]}]}\n"
        "rules: [emitter_motion, gravity, collision]\nsolids: [{kind: plane, position: [0, -0.02, 0]}]\n"
    )
    seen = []
    for _ in each_step(solver, 24, 72):
        seen.append((solver.state.force.any(), solver.state.restart.any()))
    assert seen[22][0]
    assert not any(seen[-1])


@pytest.mark.parametrize("more", ["", "torsion: 0.7"])
def test_curls_that_lean_on_a_ball_come_to_rest(more: str) -> None:
    """Where edges that a solid presses are not kept, tips twitch by 1 to 3 mm a frame, for ever."""
    solver = rod_of(
        f"rod: {{rest: shape, radius: 6.0e-5, drag: 1.5, damping: 0.0005, friction: 0.2, {more}}}\n"
        "emitter: {shape: {kind: sphere, radius: 0.1}, strands: 128, particles: 64, length: 0.3, curl_turns: 8, "
        "curl_angle: 56, comb: [0.85, -0.55, -0.15], lift: 30}\n"
        "solids: [{kind: sphere, radius: 0.1}]\nrules: [gravity, collision]\n"
    )
    moved = motion_at_rest(solver, RATE, 5)[-12:, :, -1]
    assert rms(moved) < 1e-4
    assert moved.max() < 6e-4


def test_strands_that_interact_swing_as_long_as_alone() -> None:
    """By default, where they keep their distance: Euler's method would take more than half of it a cycle."""
    last = []
    for rule in ("", ", interaction: {density: 1.0e+9, friction: 0, cell: 0.05}"):
        solver = rod_of(
            "rod: {rest: straight, drag: 0, damping: 0}\nemitter: {shape: {kind: disc, radius: 0.05}, "
            "strands: 64, particles: 8, length: 0.25, rotation: [150, 0, 0]}\ntime: {fps: 24}\n"
            f"rules: [gravity{rule}]\n"
        )
        tips = []
        for i in range(1, 97):
            solver.step(i / 24, 1 / 24)
            x = solver.particles().astype(float)
            tips.append((x[:, -1] - x[:, 0])[:, 2].mean())
        last.append(np.ptp(tips[-30:]))
    assert last[1] == pytest.approx(last[0], rel=0.02)
    assert last[0] > 0.1


STANDING = "rules: [gravity, collision]\nsolids: [{{kind: plane, position: [0, {height}, 0]}}]\n"
MOVING = (
    "rules: [emitter_motion, gravity, collision]\nsolids: [{{kind: plane, position: [0, {height}, 0], keys: "
    "[{{time: 0, position: [0, {height}, 0], ease: linear}}, {{time: 10, position: [1, {height}, 0]}}]}}]\n"
)


def above_a_floor(
    length: float,
    weight: float,
    height: float,
    root: str = "clamped",
    around: str = STANDING,
    keys: str = "",
    more: str = "damping: 0.01",
) -> RodSolver:
    """24 strands clamped downward at a share of their length above a floor; ``weight``: over their stiffness; ``more``:
    of the rod."""
    radius = 0.002 * length
    young = 4 * 1000 * 9.81 * length**3 / weight / radius**2
    return rod_of(
        f"rod: {{rest: straight, density: 1000, radius: {radius:g}, young: {young:.6g}, "
        f"drag: 5, friction: 0.2, root: {root}, {more}}}\ntime: {{fps: {RATE}}}\n"
        f"emitter: {{shape: {{kind: disc, radius: {0.2 * length:g}}}, strands: 24, particles: 26, length: {length}, "
        f"jitter: 20, rotation: [180, 0, 0]{keys}}}\n" + around.format(height=-height * length),
    )


@pytest.mark.parametrize("root", ["clamped", "hinged"])
@pytest.mark.parametrize("height", [0.3, 0.6])
@pytest.mark.parametrize("weight", [3, 10])
@pytest.mark.parametrize("length", [0.01, 0.02, 0.05])
def test_stiff_strands_rest_that_fall_as_far_in_a_step_as_they_are_long(
    length: float, weight: float, height: float, root: str
) -> None:
    """Without parts, tips move by up to the strand's length and more in a frame, for ever."""
    assert rms(motion_at_rest(above_a_floor(length, weight, height, root), RATE, 8)[..., -1]) < STILL


def test_they_rest_on_a_floor_that_moves_with_them() -> None:
    keys = ", keys: [{time: 0, rotation: [180, 0, 0], ease: linear}, {time: 10, rotation: [180, 0, 0], "
    solver = above_a_floor(0.02, 3, 0.6, around=MOVING, keys=keys + "position: [1, 0, 0]}]")
    assert rms(motion_at_rest(solver, RATE, 8)[..., -1]) < STILL


def swing(beside: bool) -> NDArray[np.float64]:
    """(steps,) how far the tip of a long strand swings, ``beside`` such as solids lead astray at first."""
    scene = scene_of(
        f"solver: rod\nrod: {{rest: straight, drag: 0, damping: 0}}\ntime: {{fps: {RATE}}}\n"
        "emitter: {strands: 16, particles: 10, length: 0.3}\nrules: [gravity, collision]\n"
        "solids: [{kind: plane, position: [0, -0.003, 0]}]\n"
    )
    roots, ways, lengths = np.zeros((16, 3)), np.tile([0.05, -1.0, 0.0], (16, 1)), np.full(16, 0.01)
    roots[:, 0] = 0.02 * np.arange(16)
    long = np.arange(16) >= (8 if beside else 0)
    roots[long, 1], ways[long], lengths[long] = 1.0, [1.0, -0.2, 0.0], 0.3
    ways /= np.linalg.norm(ways, axis=1)[:, None]
    single = (one.astype(np.float32) for one in (roots, ways, lengths, np.zeros(16)))
    solver = RodSolver(scene, Groom(*single))
    found = []
    for _ in each_step(solver, RATE, 3 * RATE):
        found.append(solver.particles()[-1, -1, 0] - solver.particles()[-1, 0, 0])
    return np.array(found)


def test_strands_beside_them_go_on_as_alone() -> None:
    """Parts are Euler's, which would take most of their swing."""
    alone = swing(False)
    assert np.ptp(alone[-RATE:]) > 0.3
    np.testing.assert_allclose(swing(True), alone, atol=2e-3)
