"""Emitters, solids and air that move while strands are simulated, and what the source's solver admits about itself."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest

from reference.rules import depth
from strand_kit import frames_of, groom_of, moved, scene_of, solver_of
from strandcli.constants import W
from strandcli.errors import SimulationError, UsageError
from strandcli.groom.blocks import unpack
from strandcli.scene import Scene
from strandcli.scene.motion import emitter_pose
from strandcli.simulate import solver_of as choose
from strandcli.simulate.rod.surroundings import Surroundings
from tests.simulate.test_rod import scene

TURNING = """
emitter:
  strands: 135
  particles: 5
  length: 0.6
  length_variation: 0.3
  shape: {kind: sphere, radius: 0.4}
  keys:
  - {time: 0, position: [1, 2, 3], rotation: [0, 0, 0]}
  - {time: 2, position: [-4, 1, 0], rotation: [100, 720, -50]}
time: {fps: 10, preroll: 0.4}
rules: [%s]
"""
HANGING = """
emitter: {strands: 1, particles: %d, length: 1, shape: {kind: plane, width: 1e-9, depth: 1e-9}, direction: [1, 0, 0]}
time: {fps: %g, substeps: %d}
rules: [%s]
"""


def pose(scene: Scene, frame: int) -> list[np.ndarray]:
    return [np.array(part) for part in emitter_pose(scene.emitter, (frame - 1) / scene.time.fps)]


@pytest.mark.parametrize("rules", ["emitter_motion, gravity, elasticity", "gravity, elasticity, emitter_motion"])
def test_roots_and_directions_turn_with_the_emitter(rules: str) -> None:
    """Exactly, on whatever frame: they are placed from the emitter's own frame, so nothing can drift."""
    scene = scene_of(TURNING % rules)
    groom = groom_of(scene)
    solver = solver_of(scene, plain=True)
    for frame in (1, 2, 7, 21, 30):
        solver.advance(frame)
        rotation, centre = pose(scene, frame)
        roots = solver.particles()[:, 0]
        np.testing.assert_allclose(roots, groom.roots @ rotation.T + centre, atol=2e-6)
        np.testing.assert_allclose(np.linalg.norm(roots - centre, axis=1), 0.4, atol=2e-6)
        lanes = unpack(solver.positions[:, :2], 135)
        segment = groom.lengths[:, None] / 4
        np.testing.assert_allclose((lanes[:, 1] - lanes[:, 0]) / segment, groom.directions @ rotation.T, atol=2e-5)
        if rules.endswith("elasticity"):
            assert solver.errors(frame)["stretch_max"] < 1e-5


def test_keys_before_the_first_frame_move_nothing_during_the_preroll() -> None:
    keys = "[{time: -2, position: [0, 0, 0]}, {time: 2, position: [4, 0, 0]}]"
    text = TURNING[: TURNING.index("  keys:")] + f"  keys: {keys}\n" + TURNING[TURNING.index("time: {fps") :]
    scene = scene_of(text % "emitter_motion, elasticity")
    groom = groom_of(scene)
    tips = groom.roots + groom.directions * groom.lengths[:, None] + [2, 0, 0]
    assert np.abs(moved(scene, 1)[:, -1] - tips).max() < 1e-5


@pytest.mark.parametrize("solver", ["thesis", "rod"])
def test_positions_taken_from_elsewhere_restore_the_whole_state(solver: str) -> None:
    """The row before the root turns with the emitter too, to the bits; curves take their first tangent from it."""
    scene = scene_of(f"solver: {solver}\n" + TURNING % "emitter_motion, gravity, elasticity")
    groom = groom_of(scene)
    for start in (1, 9):
        run, taken = (choose(scene)(scene, groom) for _ in range(2))
        for frame in (start, start + 3):
            run.advance(frame)
            taken.take(frame, run.particles())
            np.testing.assert_array_equal(taken.positions, run.positions)


SOLIDS = """
emitter:
  strands: 80
  particles: 6
  length: 1.2
  shape: {kind: sphere, radius: 0.3}
  keys: [{time: 0}, {time: 1, position: [0.5, 0.3, 0], rotation: [0, 90, 40]}]
time: {fps: 12}
rules: [emitter_motion, gravity: {acceleration: [0, -30, 0]}, elasticity, collision]
solids: [%s]
"""


@pytest.mark.parametrize(
    "solid",
    [
        "{kind: sphere, radius: 0.5, keys: [{time: 0, position: [-1, -1, 0]}, {time: 1, position: [1, 0, 0]}]}",
        "{kind: plane, keys: [{time: 0, position: [0, -2, 0]}, {time: 1, position: [0, 1, 0], rotation: [30, 0, 20]}]}",
        "{kind: capsule, radius: 0.3, length: 1, follow: emitter, position: [0, -0.8, 0], rotation: [0, 0, 50]}",
        "{kind: box, size: [1, 0.5, 1], follow: emitter, keys: [{time: 0, position: [0, -1, 0]},"
        " {time: 1, position: [0, -0.6, 0], rotation: [0, 200, 0]}]}",
    ],
)
def test_solids_push_strands_where_they_are_at_that_moment(solid: str) -> None:
    scene = scene_of(SOLIDS % solid)
    free = scene_of(SOLIDS.replace(", collision]", "]") % solid)
    unhindered, solver = solver_of(free, plain=True), solver_of(scene, plain=True)
    deepest = 0.0
    for frame in range(2, 14):
        unhindered.advance(frame)
        solver.advance(frame)
        time = (frame - 1) / 12
        deepest = max(deepest, depth(unhindered.particles()[:, 1:], scene.solids[0], scene.emitter, time).max())
        assert depth(solver.particles()[:, 1:], scene.solids[0], scene.emitter, time).max() < 2e-6
    assert deepest > 0.1


def test_errors_are_measured() -> None:
    """Stretch and depth of a state that was made by hand."""
    scene = scene_of(HANGING % (3, 10, 1, "collision") + "solids: [{kind: sphere, radius: 1, position: [3, 0, 0]}]\n")
    solver = solver_of(scene, plain=True)
    assert solver.errors(1) == {
        "stretch_max": 0.0, "penetration_max": 0.0, "segment_penetration_max": 0.0, "residual_max": None,
        "nonfinite": 0,
    }  # fmt: skip
    solver.positions[:, 3, :W] = 2.25  # the tip's x; the parent's is 0.5
    errors = solver.errors(1)
    assert errors["stretch_max"] == pytest.approx(2.5)
    assert errors["penetration_max"] == pytest.approx(0.25)
    solver.positions[0, 3, W : W + 2] = np.nan
    assert solver.errors(1)["nonfinite"] == 2
    assert solver_of(scene_of(HANGING % (3, 10, 1, "gravity")), plain=True).errors(1)["penetration_max"] is None


TURN = [{"time": 0, "position": [0, 0, 0]}, {"time": 1, "position": [1, 0.5, 0], "rotation": [30, 120, -20]}]
ALL = [
    {"kind": "sphere", "radius": 0.2, "position": [0, 1, 0], "follow": "emitter"},
    {"kind": "sphere", "radius": 0.3, "position": [3, 0, 0]},
    {"kind": "sphere", "radius": 0.1, "keys": TURN},
    {"kind": "capsule", "radius": 0.1, "length": 1, "keys": TURN},
    {"kind": "capsule", "radius": 0.2, "length": 2, "position": [5, 0, 0]},
    {"kind": "plane", "position": [0, -3, 0], "keys": TURN},
    {"kind": "box", "size": [1, 2, 3], "position": [0, 0, 2], "follow": "emitter"},
]


def around(collision: Any = "collision", *rules: Any, **changes: Any) -> Surroundings:
    one = scene(10.0, **{"solids": ALL, "emitter.keys": TURN, "rules": ["gravity", collision, *rules], **changes})
    return Surroundings(one, np.float64)


def test_only_the_solids_that_are_named_are_touched() -> None:
    named = [{**one, "name": f"solid{i}"} for i, one in enumerate(ALL)]
    mine = around({"collision": {"with": ["solid1"]}}, solids=named)
    packed, whole = mine.solids(0.1, 0.1), mine.segments
    assert [rows.shape for rows in packed] == [(1, 17), (0, 21), (0, 16), (0, 28)]
    assert mine.any_solids
    assert not whole
    mine = around({"collision": {"with": ["solid1"], "segments": True}}, solids=named)
    packed, whole = mine.solids(0.1, 0.1), mine.segments
    assert whole
    assert [len(rows) for rows in packed] == [1, 0, 0, 0]
    mine = around("emitter_motion", solids=named)
    assert [len(rows) for rows in mine.solids(0.1, 0.1)] == [0, 0, 0, 0]
    assert not mine.any_solids


def test_gusts_that_travel_differ_from_place_to_place_and_others_do_not() -> None:
    calm = around("collision", {"wind": {"strength": 3.0, "direction": [0, 0, 2]}})
    assert calm.gust(0.3, np.zeros((1, 3, 24))) is None
    np.testing.assert_allclose(calm.air(0.3), (0, 0, 3))
    gusty = around("collision", {"wind": {"strength": 3.0, "gust": 1.0}})
    speeds = [gusty.air(time)[0] for time in np.linspace(0, 5, 50)]
    assert 0 <= min(speeds) < 0.6
    assert 2.4 < max(speeds) <= 3
    travelling = around("collision", {"wind": {"strength": 3.0, "gust": 1.0, "wavelength": 0.5}})
    np.testing.assert_allclose(travelling.air(0.3), (3, 0, 0))


@pytest.mark.parametrize("other", [{"gust": 0.5, "wavelength": 0.2}, {"gust": 0.5}, {}])
def test_gusts_that_travel_are_refused_beside_another_wind(other: dict[str, Any]) -> None:
    """Its strength would come and go with theirs."""
    travelling = {"wind": {"strength": 3.0, "gust": 1.0, "wavelength": 0.5}}
    for winds in ([travelling, {"wind": other}], [{"wind": other}, travelling]):
        with pytest.raises(UsageError, match=r"rule wind: of 2 winds, .* solver rod supports travelling gusts only"):
            around("collision", *winds)
    still = {"wind": {"strength": 0.0, **other}}
    assert around("collision", travelling, still).gust(0.3, np.zeros((1, 3, 3 * W))) is not None


DIVERGING = """
emitter: {strands: 70, particles: 5}
time: {fps: 10, frames: 40}
image: {size: [16, 12]}
rules: [gravity, stiffness: {strength: 5000, clamp: false}]
"""


def test_a_simulation_that_diverges_ends_in_an_error_and_not_in_a_picture() -> None:
    frames = []
    ends = None
    for frame in range(1, 41):
        try:
            frames += frames_of(scene_of(DIVERGING), frame, draw=False)
        except SimulationError as error:
            ends = str(error)
            break
    assert 5 < len(frames) < 40
    assert np.isfinite(frames[-1].positions).all()
    assert frames[-1].report["error"]["nonfinite"] == 0
    assert re.match(rf"frame {len(frames) + 1}: strand 0, particle \d is no longer finite", str(ends))
    with pytest.raises(SimulationError, match=rf"^frame {len(frames) + 1}: strand \d+") as caught:
        frames_of(scene_of(DIVERGING), 40)  # it stops where it went wrong, not where it is looked at
    assert "under the rules " in str(caught.value)
    assert "stiffness.clamp: true" in str(caught.value)
    assert caught.value.exit_code == 1


def test_roots_are_clamped_during_the_preroll() -> None:
    scene = scene_of(TURNING.replace("preroll: 0.4", "preroll: 3") % "emitter_motion, gravity, elasticity")
    assert np.abs(moved(scene, 1)[:, 0] - groom_of(scene).roots - [1, 2, 3]).max() < 1e-6
    settled = moved(scene, 1)
    assert settled[:, -1, 1].max() < groom_of(scene).roots[:, 1].max() + 2.05  # and gravity acts


def test_steps_can_be_taken_in_any_portions() -> None:
    scene = scene_of(TURNING.replace("fps: 10", "fps: 10, substeps: 3") % "emitter_motion, gravity, wind, elasticity")
    by_one = solver_of(scene, plain=True)
    for frame in range(1, 8):
        by_one.advance(frame)
    np.testing.assert_array_equal(by_one.particles(), moved(scene, 7))
