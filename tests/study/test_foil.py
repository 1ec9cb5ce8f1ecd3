"""The foil against closed forms, as any solver; and what it may and may not be asked for."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from strand_kit import groom_of, scene_of
from strandcli.scene import Scene, SceneError
from strandcli.study.exactness import Exactness, Request
from strandcli.study.exactness import scene_of as reference_scene
from strandcli.study.motion.contestants import CONTESTANTS, Contestant, follow, prepare
from strandcli.study.motion.foil import Foil
from strandcli.study.points import fitted_order
from strandcli.study.references import REFERENCES, Case

FOIL = CONTESTANTS["foil"]

BALL = """
solver: rod
time: {frames: 24, fps: 24, substeps: 20}
emitter:
  strands: 20
  particles: 8
  length: 0.5
  shape: {kind: disc, radius: 0.2}
  position: [0, 1, 0]
  direction: [1, 0.2, 0]
  keys:
    - {time: 0, position: [0, 1, 0]}
    - {time: 1, position: [0.3, 1, 0], rotation: [0, 40, 0]}
rod: {material: hair, drag: 2}
solids: [{kind: sphere, radius: 0.3, position: [0.4, 0.6, 0]}, {kind: plane, position: [0, 0.2, 0]}]
rules:
  - emitter_motion
  - gravity
  - wind: {strength: 3, gust: 0.5, wavelength: 0.7}
  - collision
  - elasticity
"""


def measured(name: str, particles: int, dt: float) -> dict[str, float | None]:
    reference = REFERENCES[name]
    point = Exactness(Request(name=name)).measure({"solver": "foil", "emitter.particles": particles, "dt": dt})
    assert point.seconds > 0
    assert reference.metric in point.error
    return point.error


def test_its_chain_is_a_catenary_to_second_order() -> None:
    errors = [measured("catenary", particles, 1 / 960)["shape"] or 1.0 for particles in (7, 11)]
    assert errors[1] < 0.003
    assert fitted_order([1 / 6, 1 / 10], errors) == pytest.approx(2, abs=0.25)


def test_its_pendulum_comes_nearer_with_smaller_steps_and_never_gains() -> None:
    steps = (1 / 240, 1 / 480, 1 / 960)
    errors = [measured("pendulum", 2, dt) for dt in steps]
    assert fitted_order(steps, [error["loss"] or 0.0 for error in errors]) == pytest.approx(1, abs=0.3)
    assert all(error["growth"] == 0 for error in errors)


def test_a_stiff_rod_is_too_soft_for_large_steps() -> None:
    """What the production solver is measured against: stiffness has to be paid for in steps."""
    large, small = (measured("elastica", 6, dt)["H/W Γ=1"] for dt in (1 / 240, 1 / 1920))
    assert large is not None
    assert small is not None
    assert large > 5 * small
    assert small < 0.06


def test_a_mass_on_the_tip_bends_further() -> None:
    plain = REFERENCES["tip_load"].case(6)
    loaded, bare = (ended(replace(plain, tip_mass=mass)) for mass in (plain.tip_mass, 0.0))
    assert loaded[3, -1, 1] < bare[3, -1, 1] - 0.3


def ended(case: Case) -> np.ndarray:
    scene = reference_scene(case, FOIL, {})
    return follow(lambda: prepare(FOIL, scene, case), 1 / 480, 4.0, False)[0].last


def test_it_keeps_out_of_solids_and_with_its_roots() -> None:
    scene = scene_of(BALL)
    foil = Foil(scene, groom_of(scene))
    foil.advance(24)
    errors = foil.errors(24)
    assert errors["nonfinite"] == 0
    assert errors["penetration_max"] is not None
    assert errors["penetration_max"] < 1e-6
    other = Foil(scene, groom_of(scene))
    other.place_roots(24)
    np.testing.assert_allclose(foil.positions[:, :2], other.positions[:, :2], atol=1e-6)
    assert np.linalg.norm(foil.particles()[:, 0] - Foil(scene, groom_of(scene)).particles()[:, 0], axis=1).max() > 0.2


def test_gusts_and_a_step_of_no_length() -> None:
    scene = scene_of(BALL)
    foil = Foil(scene, groom_of(scene))
    gust = foil._gust(0.3)
    assert gust is not None
    assert 0.5 - 1e-9 <= gust.min() < gust.max() <= 1 + 1e-9
    before = foil.positions.copy()
    foil.step(0.0, 0.0)
    np.testing.assert_array_equal(foil.positions, before)


def test_no_preset_can_ask_for_it() -> None:
    with pytest.raises(SceneError, match="foil"):
        scene_of("solver: foil\n")


def refusal(contestant: Contestant, text: str) -> str:
    scene: Scene = scene_of(text)
    return contestant.refuses(scene)


def test_what_is_not_represented_is_said() -> None:
    assert CONTESTANTS["thesis"].lacks(("bending", "inertia")) == "bending stiffness in physical units, inertia"
    assert CONTESTANTS["rod"].lacks(("bending", "tip mass")) == ""
    assert CONTESTANTS["rod"].lacks(("two ends",)) == ""
    assert "both ends" in CONTESTANTS["thesis"].lacks(("two ends",))
    assert all(("twist" in one.lacks(("twist",))) == (name != "rod") for name, one in CONTESTANTS.items())
    assert refusal(FOIL, BALL) == ""
    assert "straight" in refusal(FOIL, BALL.replace("strands: 20", "strands: 20\n  curl_turns: 3"))
    assert "straight" in refusal(FOIL, BALL.replace("material: hair", "rest: sag_free"))


def test_cases_are_data() -> None:
    """So that a solver of another process, or of another language, could be handed one."""
    for reference in REFERENCES.values():
        json.dumps(reference.case(6).settings)
