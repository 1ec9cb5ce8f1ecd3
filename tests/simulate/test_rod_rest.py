"""Strands come to rest, alone, on solids and leaning on them, at steps of any length; tips that are pinned stay."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from rod_kit import each_step, motion_at_rest, rms, rod_of
from strand_kit import require_same_after_restart, scene_of
from strandcli.groom.record import Groom
from strandcli.scene import SceneError
from strandcli.simulate.rod.solver import RodSolver
from strandcli.study.references import track_of
from strandcli.study.references.base import Case, groom, preset

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


APART = 0.7
"""Distance of the ends of a strand of a metre."""


def hanging(particles: int) -> float:
    """Greatest distance of a limp strand, pinned at both ends, from a cosh(x / a) with 2 a sinh(D / (2 a)) = L."""
    edges = np.tile([APART, -math.sqrt(1 - APART**2), 0.0], (1, particles - 1, 1))
    edges[:, (particles - 1) // 2 :, 1] *= -1
    settings = preset(0.0, 1, particles, drag=2.0)
    settings["rod"]["end"] = "pinned"
    strand = track_of(Case(settings, replace(groom([[1, 0, 0]], [1.0]), edges=edges)), 1 / 24, 10.0).last[0]
    u = np.linspace(0.1, 5, 1_000_000)
    a = APART / (2 * u[np.argmin(np.abs(np.sinh(u) / u - 1 / APART))])
    x = a * np.arcsinh((np.linspace(0, 1, particles) - 0.5) / a)
    exact = np.stack([x + APART / 2, a * (np.cosh(x / a) - math.cosh(APART / (2 * a))), 0 * x], 1)
    return float(np.linalg.norm(strand - exact, axis=1).max())


def test_a_limp_strand_between_two_points_is_a_catenary() -> None:
    coarse, fine = hanging(7), hanging(21)
    assert fine < 6e-4
    assert math.log(coarse / fine) / math.log(20 / 6) > 1.8


def slack(more: str = "", end: str = "pinned", rule: str = "gravity", rest: str = "straight") -> RodSolver:
    """Loose curls on an emitter that turns and moves, with a ``rest`` shape."""
    return rod_of(
        f"rod: {{rest: {rest}, root: hinged, end: {end}, young: 1.0e+7, {more}}}\ntime: {{fps: 24}}\n"
        "emitter: {shape: {kind: disc, radius: 0.05}, strands: 20, particles: 20, length: 0.3, curl_turns: 2, "
        "curl_angle: 50, keys: [{time: 0}, {time: 1, position: [0.2, 0.1, 0], rotation: [0, 70, 30]}]}\n"
        f"rules: [emitter_motion, {rule}, wind: {{strength: 2}}]\n"
    )


def tips(solver: RodSolver) -> np.ndarray:
    """(strands, 3) in the emitter's frame."""
    away = solver.particles()[:, -1].astype(np.float64) - np.array(solver.pose.translation)
    return away @ np.array(solver.pose.rotation)


@pytest.mark.parametrize("more", ["", "drag: 30"])
def test_tips_stay_where_the_emitter_carries_them(more: str) -> None:
    solver, free = slack(more), slack(more, "free")
    start = tips(solver)
    for frame in range(2, 40):
        for one in (solver, free):
            one.advance(frame)
        errors = solver.errors(frame)
        assert errors["nonfinite"] == 0
        assert errors["stretch_max"] <= 1e-6  # type: ignore[operator]
        assert np.abs(tips(solver) - start).max() < 2e-4 * 0.3
    assert np.abs(tips(free) - start).max() > 0.1


def test_a_state_in_the_middle_goes_on_to_the_same_bits() -> None:
    whole, half = slack(), slack()
    require_same_after_restart(whole, half)


def test_pins_on_what_deforms_are_refused_with_their_place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("a.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    text = (
        "solver: rod\nrod: {end: pinned}\n"
        "emitter: {shape: {kind: mesh, file: a.obj, deform: [{time: 0, file: a.obj}, {time: 1, file: a.obj}]}}\n"
    )
    assert scene_of(text + "rules: [gravity]\n").rod.end == "pinned"  # such an emitter stands still
    with pytest.raises(SceneError, match=r":2:\d+: rod\.end: tips cannot be pinned on an emitter that deforms"):
        scene_of(text + "rules: [emitter_motion, gravity]\n")


@pytest.mark.parametrize("more", [", rest: straight", ", rest: shape"])
@pytest.mark.parametrize("rate", [24, 60])
def test_tips_stay_where_solids_have_strands_go_by_eulers_method(rate: int, more: str) -> None:
    """With the velocity that BDF2 asks for, tips fell by 7 and 1.2 mm in each such step, and strands fidgeted for
    ever."""
    solver = rod_of(
        f"rod: {{end: pinned, young: 1.0e+7, drag: 1, friction: 0.2{more}}}\ntime: {{fps: {rate}}}\n"
        "emitter: {shape: {kind: disc, radius: 0.03}, strands: 16, particles: 20, length: 0.3, curl_turns: 2, "
        "curl_angle: 50, rotation: [90, 0, 0]}\nrules: [gravity, collision]\n"
        "solids: [{kind: sphere, radius: 0.04, position: [0, -0.05, 0.1]}]\n"
    )
    start, seen, off = solver.particles()[:, -1].astype(np.float64), False, []
    for i in range(4 * rate):
        seen = seen or bool(solver.state.restart.any())
        solver.step((i + 1) / rate, 1 / rate)
        off.append(np.abs(solver.particles()[:, -1] - start).max())
    assert seen
    assert max(off) < 1e-3 * 0.3
    assert max(off[-rate:]) < 1e-5 * 0.3
