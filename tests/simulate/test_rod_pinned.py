"""Tips that are pinned: the catenary, places that the emitter carries along, checkpoints."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from rod_kit import rod_of
from strand_kit import require_same_after_restart, scene_of
from strandcli.scene import SceneError
from strandcli.simulate.rod.solver import RodSolver
from strandcli.study.references import track_of
from strandcli.study.references.base import Case, groom, preset

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


def on_a_ball(rate: int, more: str = "") -> RodSolver:
    """Slack strands between two places, which fall on a ball."""
    return rod_of(
        f"rod: {{end: pinned, young: 1.0e+7, drag: 1, friction: 0.2{more}}}\ntime: {{fps: {rate}}}\n"
        "emitter: {shape: {kind: disc, radius: 0.03}, strands: 16, particles: 20, length: 0.3, curl_turns: 2, "
        "curl_angle: 50, rotation: [90, 0, 0]}\nrules: [gravity, collision]\n"
        "solids: [{kind: sphere, radius: 0.04, position: [0, -0.05, 0.1]}]\n"
    )


@pytest.mark.parametrize("more", [", rest: straight", ", rest: shape"])
@pytest.mark.parametrize("rate", [24, 60])
def test_tips_stay_where_solids_have_strands_go_by_eulers_method(rate: int, more: str) -> None:
    """With the velocity that BDF2 asks for, tips fell by 7 and 1.2 mm in each such step, and strands fidgeted for
    ever."""
    solver = on_a_ball(rate, more)
    start, seen, off = solver.particles()[:, -1].astype(np.float64), False, []
    for i in range(4 * rate):
        seen = seen or bool(solver.state.restart.any())
        solver.step((i + 1) / rate, 1 / rate)
        off.append(np.abs(solver.particles()[:, -1] - start).max())
    assert seen
    assert max(off) < 1e-3 * 0.3
    assert max(off[-rate:]) < 1e-5 * 0.3
