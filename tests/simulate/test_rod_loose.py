"""Roots that are free: strands in flight keep momentum, fall as they should, and go on from checkpoints."""

from __future__ import annotations

import math

import numpy as np
import pytest

from strand_kit import scene_of
from strandcli.errors import UsageError
from strandcli.groom.emit import emit
from strandcli.scene import SceneError
from strandcli.simulate.kernels.rod_scratch import PACK
from strandcli.simulate.rod import RodSolver
from strandcli.study.exactness import scene_of as reference_scene
from strandcli.study.motion.contestants import CONTESTANTS, prepare
from strandcli.study.references.base import Case, groom, preset

PARTICLES = 11
SPIN, SPEED = np.array([3.0, -2.0, 5.0]), np.array([1.0, 2.0, -1.0])


class Flight:
    """Four strands that fly and turn."""

    def __init__(self, gravity: float, integrator: str) -> None:
        settings = preset(0.01, 4, PARTICLES, gravity=gravity)
        settings["rod"] |= {"root": "free", "integrator": integrator}
        ways = [[1.0, 0, 0], [0, 1, 0], [1, 1, 0], [0, 0, 1]]
        case = Case(settings, groom(ways, [1.0, 0.5, 0.7, 1.0]))
        solver = prepare(CONTESTANTS["rod"], reference_scene(case, CONTESTANTS["rod"], {}), case)
        assert isinstance(solver, RodSolver)
        self.solver, state = solver, solver.state
        mass = np.append(0.5, solver.mass.astype(float))
        self.share = (mass / mass.sum())[None, :, None]
        places = solver.particles()[:4].astype(float)
        moving = SPEED + np.cross(SPIN, places - places.mean(1, keepdims=True))
        state.velocity[0].reshape(-1, 3, PACK)[:, :, :4] = moving[:, 1:].transpose(1, 2, 0)
        state.root_velocity[0].reshape(-1, 3, PACK)[:, :, :4] = moving[:, :1].transpose(1, 2, 0)

    def velocity(self) -> np.ndarray:
        """(4, 3) of the centres of mass."""
        both = self.solver.state.root_velocity, self.solver.state.velocity
        rows = [one[0].reshape(-1, 3, PACK)[:, :, :4].transpose(2, 0, 1) for one in both]
        return np.asarray((np.concatenate(rows, 1) * self.share).sum(1))

    def centre(self) -> np.ndarray:
        """(4, 3) metres."""
        return np.asarray((self.solver.particles()[:4].astype(float) * self.share).sum(1))

    def run(self, dt: float) -> None:
        """Fly for a second."""
        for i in range(round(1 / dt)):
            self.solver.step((i + 1) * dt, dt)


@pytest.mark.long
@pytest.mark.parametrize("integrator", ["euler", "bdf2"])
def test_free_flight_keeps_momentum(integrator: str) -> None:
    flight = Flight(0.0, integrator)
    start, place = flight.velocity(), flight.centre()
    flight.run(1 / 60)
    assert np.abs(flight.velocity() - start).max() < 1e-12 * np.linalg.norm(SPEED)
    np.testing.assert_allclose(flight.centre() - place, start, atol=1e-6)
    assert flight.solver.errors(1)["stretch_max"] < 1e-12  # type: ignore[operator]


@pytest.mark.long
def test_a_free_strand_falls_as_all_things_do() -> None:
    off = []
    for dt in (1 / 60, 1 / 240):
        flight = Flight(9.81, "bdf2")
        start, place = flight.velocity(), flight.centre()
        flight.run(dt)
        np.testing.assert_allclose(flight.velocity() - start, [[0, -9.81, 0]] * 4, atol=1e-5)
        off.append(np.abs(flight.centre() - place - start - [0, -9.81 / 2, 0]).max())
    assert off[0] < 5e-3
    assert math.log(off[0] / off[1]) / math.log(4) > 1.8  # the first step is Euler's


def wild(more: str = "") -> RodSolver:
    """Straight strands that drift in the wind."""
    scene = scene_of(
        f"solver: rod\nrod: {{root: free, rest: straight, young: 1.0e+7, {more}}}\ntime: {{fps: 24}}\n"
        "emitter: {shape: {kind: disc, radius: 0.05}, strands: 20, particles: 12, length: 0.3}\n"
        "rules: [gravity, wind: {strength: 2}]\n"
    )
    return RodSolver(scene, emit(scene.emitter, scene.seed))


@pytest.mark.long
def test_a_state_in_the_middle_goes_on_to_the_same_bits() -> None:
    whole, half = wild(), wild()
    whole.advance(12)
    half.restore(whole.state_arrays())
    half.frame = 12
    for one in (whole, half):
        one.frame = 12
        one.advance(20)
    np.testing.assert_array_equal(whole.positions, half.positions)
    taken = wild()
    taken.take(20, whole.particles())
    np.testing.assert_array_equal(taken.positions[:, :, : 3 * 20], whole.positions[:, :, : 3 * 20])


@pytest.mark.parametrize(
    ("rod", "rules", "words"),
    [
        ("rest: sag_free", "gravity", r":2:\d+: rod\.root: free roots hold no strand up"),
        ("end: clamped", "gravity", r":2:\d+: rod\.root: a clamped tip needs a root that is held"),
        ("rest: sag_free, end: clamped", "contact", r"hold no strand up.*use straight; a clamped tip needs a root"),
    ],
)
def test_what_free_roots_do_not_go_with_is_refused_in_one_line_with_its_place(rod: str, rules: str, words: str) -> None:
    with pytest.raises(SceneError, match=words) as raised:
        scene_of(f"solver: rod\nrod: {{root: free, {rod}}}\nrules: [{rules}]\n")
    assert "\n" not in str(raised.value)


def test_curled_strands_need_a_root_that_is_held() -> None:
    curls = "{strands: 5, curl_turns: 2, curl_angle: 50}"
    scene = scene_of(f"solver: rod\nrod: {{root: free}}\nemitter: {curls}\nrules: [gravity]\n")
    with pytest.raises(UsageError, match=r"rod\.root: free roots have no frame"):
        RodSolver(scene, emit(scene.emitter, scene.seed))
