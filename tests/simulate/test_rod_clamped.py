"""Tips that are clamped and turned: uniform twist, a ring's onset, writhe, checkpoints, refusals."""

from __future__ import annotations

import math

import numpy as np
import pytest

from strand_kit import require_same_after_restart, scene_of
from strandcli.groom.emit import emit
from strandcli.scene import SceneError
from strandcli.simulate import rod_clamped
from strandcli.simulate.rod import RodSolver
from strandcli.study.exactness import scene_of as reference_scene
from strandcli.study.motion.contestants import CONTESTANTS, follow, prepare
from strandcli.study.references import michell, writhe
from strandcli.study.references.base import Case, Reference, groom, preset


def measured(reference: Reference, particles: int, dt: float, metric: str) -> float:
    """An error of a reference."""
    case = reference.case(particles)
    scene = reference_scene(case, CONTESTANTS["rod"], {})
    track, _ = follow(lambda: prepare(CONTESTANTS["rod"], scene, case), dt, reference.span, reference.moving)
    error = reference.measure(track)[metric]
    assert error is not None
    return error


def straight(keys: list[dict[str, object]]) -> RodSolver:
    """A straight strand of a metre along x whose tip is clamped."""
    settings = preset(0.01, 1, 11, gravity=0.0, drag=2.0)
    settings["rod"] |= {"end": "clamped", "precision": "double", "torsion": 0.75, "end_keys": keys}
    case = Case(settings, groom([[1, 0, 0]], [1.0]))
    solver = prepare(CONTESTANTS["rod"], reference_scene(case, CONTESTANTS["rod"], {}), case)
    assert isinstance(solver, RodSolver)
    return solver


def run(solver: RodSolver, seconds: float, dt: float = 1 / 60) -> None:
    for i in range(round(seconds / dt)):
        solver.step((i + 1) * dt, dt)


def test_turns_are_spread_evenly_along_a_straight_strand() -> None:
    solver = straight([{"time": 0}, {"time": 1, "turns": -12.5}])  # two radians a segment and step, at times
    run(solver, 3)
    shares = (np.arange(10) + 0.5) / 10  # of the middles of segments
    np.testing.assert_allclose(solver.state.twist[0, :, 0], -25 * math.pi * shares, rtol=1e-9)
    np.testing.assert_allclose(solver.particles()[0, :, 1:], 0, atol=1e-12)


def test_a_tip_that_is_rotated_about_its_direction_twists_the_strand_through_whole_turns() -> None:
    solver = straight([{"time": 0}, {"time": 2, "rotation": [-800, 0, 0]}])
    run(solver, 4)
    shares = (np.arange(10) + 0.5) / 10
    np.testing.assert_allclose(solver.state.twist[0, :, 0], -math.radians(800) * shares, rtol=1e-9)


def test_the_angle_of_a_tip_is_found_in_one_step() -> None:
    solver = straight([{"time": 0, "ease": "step"}, {"time": 0.01, "rotation": [100, 0, 0]}])
    solver.step(1 / 60, 1 / 60)
    assert solver.state.turned[0, 0] == pytest.approx(math.radians(100), abs=1e-12)


def test_damping_leaves_no_trace_at_rest() -> None:
    """In the joint of the tip it would, were it not bent toward what it was."""
    ends = []
    for damping in (0.0, 0.02):
        settings = preset(0.02, 1, 11, drag=8.0)
        settings["rod"] |= {"end": "clamped", "precision": "double", "damping": damping, "torsion": 0.75}
        settings["rod"] |= {"end_keys": [{"time": 0}, {"time": 1, "position": [-0.2, 0, 0]}]}
        case = Case(settings, groom([[1, 0, 0]], [1.0]))
        solver = prepare(CONTESTANTS["rod"], reference_scene(case, CONTESTANTS["rod"], {}), case)
        assert isinstance(solver, RodSolver)
        run(solver, 12)
        ends.append(solver.particles()[0].copy())
    assert np.ptp(ends[0][:, 1]) > 0.1
    np.testing.assert_allclose(ends[1], ends[0], atol=1e-7)


def test_a_twisted_ring_leaves_its_plane_where_michell_says() -> None:
    coarse, fine = (measured(michell.REFERENCE, count, 1 / 24, "onset") for count in (17, 33))
    assert fine < 0.012
    assert math.log(coarse / fine) / math.log(2) > 1.7


def test_a_turned_rod_has_the_form_of_the_boundary_value_solution() -> None:
    coarse, fine = (measured(writhe.REFERENCE, count, 1 / 24, "shape") for count in (11, 21))
    assert fine < 1.2e-3
    assert math.log(coarse / fine) / math.log(2) > 1.8
    assert measured(writhe.REFERENCE, 41, 1 / 24, "writhe") < 0.01


def curls(more: str = "") -> RodSolver:
    """Loose curls on an emitter that moves, whose tips are moved and turned."""
    scene = scene_of(
        f"solver: rod\nrod: {{end: clamped, young: 1.0e+7, precision: double, "
        f"end_keys: [{{time: 0}}, {{time: 1, turns: 2, "
        f"position: [0, 0.02, 0], rotation: [0, 30, 0]}}], {more}}}\ntime: {{fps: 24}}\n"
        "emitter: {shape: {kind: disc, radius: 0.05}, strands: 20, particles: 20, length: 0.3, curl_turns: 2, "
        "curl_angle: 50, keys: [{time: 0}, {time: 1, position: [0.2, 0.1, 0], rotation: [0, 70, 30]}]}\n"
        "rules: [emitter_motion, gravity]\n"
    )
    return RodSolver(scene, emit(scene.emitter, scene.seed))


@pytest.mark.parametrize("more", ["integrator: euler", "rest: straight"])
def test_tips_go_where_keys_and_emitter_carry_them(more: str) -> None:
    solver = curls(more)
    pins = solver.pins
    assert isinstance(pins, rod_clamped.Clamps)
    solver.advance(37)
    errors = solver.errors(37)
    assert errors["nonfinite"] == 0
    assert errors["stretch_max"] <= 1e-6  # type: ignore[operator]
    moved, turns = pins.moved(1.5)
    assert (turns, moved.translation) == (2.0, (0.0, 0.02, 0.0))
    tips = solver.particles()[:, -1].astype(np.float64) - np.array(solver.pose.translation)
    own = (tips @ np.array(solver.pose.rotation) - moved.translation) @ np.array(moved.rotation)
    places = pins.places.transpose(0, 2, 1).reshape(-1, 3)[: solver.strands]
    away = np.linalg.norm(solver.groom.emitted(own) - solver.groom.emitted(places), axis=1)
    assert away.max() < 2e-4 * 0.3


def test_curls_stay_as_they_are_emitted_while_nothing_turns_them() -> None:
    strands = "{strands: 5, particles: 12, curl_turns: 2, curl_angle: 50}"
    scene = scene_of(f"solver: rod\nrod: {{end: clamped, precision: double}}\nemitter: {strands}\nrules: []\n")
    solver = RodSolver(scene, emit(scene.emitter, scene.seed))
    start = solver.particles().copy()
    solver.advance(10)
    assert np.abs(solver.particles() - start).max() < 1e-6


def test_a_state_in_the_middle_goes_on_to_the_same_bits() -> None:
    whole, half = curls(), curls()
    require_same_after_restart(whole, half)


@pytest.mark.parametrize(
    ("rod", "words"),
    [
        ("end_keys: [{time: 0}]", r":2:\d+: rod\.end_keys: nothing moves a free tip"),
        ("end: pinned, end_keys: [{time: 0, turns: 1}]", r":2:\d+: rod\.end_keys\.0\.turns: a pinned tip turns freely"),
        ("end: clamped, end_keys: [{time: 1}, {time: 0}]", r"rod\.end_keys\.1\.time: keys must go forward"),
    ],
)
def test_keys_that_nothing_obeys_are_refused_with_their_place(rod: str, words: str) -> None:
    with pytest.raises(SceneError, match=words):
        scene_of(f"solver: rod\nrod: {{{rod}}}\n")
