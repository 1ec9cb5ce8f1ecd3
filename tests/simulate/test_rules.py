"""The six rules against their formulas in float64 (thesis §2), and the facts that follow from them."""

from __future__ import annotations

import numpy as np
import pytest

from reference.rules import depth
from strand_kit import moved, scene_of, solver_of, twin_of
from strandcli.simulate.rod.surroundings import Surroundings

SCENE = """
emitter:
  strands: 135
  particles: 5
  length: 0.8
  length_variation: 0.4
  jitter: 40
  shape: {kind: sphere, radius: 0.5}
  keys: [{time: 0}, {time: 1, position: [0.2, 0.1, 0], rotation: [10, 300, 20]}]
time: {fps: 10, substeps: 2, preroll: 0.1}
solids:
- {kind: sphere, name: ball, radius: 0.75}
- {kind: capsule, name: arm, radius: 0.3, position: [0, 1, 0], rotation: [20, 0, 40]}
- {kind: plane, name: ground, position: [0, -0.7, 0], rotation: [5, 0, 10]}
- {kind: box, name: crate, position: [1, 0, 0], rotation: [10, 20, 30], size: [0.9, 0.8, 0.7]}
rules: [%s]
"""
ALL = "emitter_motion, gravity, wind, stiffness, collision, elasticity"
LISTS = [
    "gravity",
    "gravity: {acceleration: [3, -2, 1]}, elasticity",
    "emitter_motion, elasticity",
    "wind: {gust: 0.5, sway: 30}",
    "wind: {direction: [1, 2, -1], strength: 5}",
    "wind: {per_length: false, direction: [1, 2, 3]}",
    "wind: {gust: 0.8, sway: 20, wavelength: 0.7, direction: [1, 0, 2]}",
    "wind: {gust: 0.8, wavelength: 0.7, per_length: false, strength: 3}",
    "gravity, stiffness: {strength: 20}",
    "gravity, stiffness: {strength: 200}",
    "gravity, stiffness: {strength: 200, clamp: false}",
    "collision: {with: ball}",
    "collision: {with: arm}",
    "collision: {with: ground}",
    "collision: {with: crate}",
    "collision, gravity, collision: {with: [crate, ball]}",
    ALL,
    "elasticity, collision, stiffness, wind, gravity, emitter_motion",
]
ONE = """
emitter: {strands: 1, particles: %d, length: %g, shape: {kind: plane, width: 1e-9, depth: 1e-9}, direction: %s}
time: {fps: 10}
rules: [%s]
"""


@pytest.mark.parametrize("rules", LISTS)
def test_rules_in_their_order_agree_with_the_formulas(rules: str) -> None:
    scene = scene_of(SCENE % rules)
    start = twin_of(scene).p.copy()
    exact = twin_of(scene).advance(3)
    assert np.abs(exact - start).max() > 0.01  # something happened
    assert np.abs(moved(scene, 3) - exact).max() < 2e-6


def test_compiled_rules_give_the_bits_of_plain_single_precision() -> None:
    rules = ALL.replace("wind", "wind: {gust: 1, wavelength: 2}").replace("collision", "collision: {segments: true}")
    scene = scene_of(SCENE % rules)
    np.testing.assert_array_equal(moved(scene, 4, plain=False), moved(scene, 4, plain=True))


def test_elasticity_leaves_coincident_particles_where_they_are() -> None:
    solver = solver_of(scene_of(ONE % (4, 0.3, "[0, 1, 0]", "elasticity")), plain=True)
    solver.positions[:, 2] = solver.positions[:, 1]
    before = solver.particles()
    solver.step(0.1, 0.1)
    after = solver.particles()
    np.testing.assert_array_equal(after[0, :2], before[0, :2])
    assert np.linalg.norm(after[0, 2] - after[0, 1]) == pytest.approx(0.1, rel=1e-6)


def test_elasticity_never_hides_that_a_particle_flew_off() -> None:
    """Its squared distance overflows: that must not come back as a segment of no length."""
    solver = solver_of(scene_of(ONE % (3, 0.3, "[0, 1, 0]", "elasticity")), plain=True)
    solver.positions[:, 3] = 1e25
    with np.errstate(over="ignore", invalid="ignore"):
        solver.step(0.1, 0.1)
    assert solver.errors(1)["nonfinite"] > 0


@pytest.mark.parametrize("name", ["ball", "arm", "ground", "crate"])
def test_no_particle_stays_inside_a_solid_and_outside_nothing_moves(name: str) -> None:
    scene = scene_of(SCENE % f"collision: {{with: {name}}}")
    solid = next(solid for solid in scene.solids if solid.name == name)
    solver = solver_of(scene, plain=True)
    rng = np.random.default_rng(3)
    solver.positions[:, 2:] = rng.uniform(-1.5, 1.5, solver.positions[:, 2:].shape).astype(np.float32)
    before = solver.particles()
    solver.step(0.0, 0.05)
    after = solver.particles()
    deep = depth(before[:, 1:], solid, scene.emitter, 0.0)
    assert (deep > 0).any()
    assert (deep < 0).any()
    assert depth(after[:, 1:], solid, scene.emitter, 0.0).max() < 1e-6
    np.testing.assert_array_equal(after[:, 1:][deep < -1e-6], before[:, 1:][deep < -1e-6])
    # the way out is the shortest: as long as the particle was deep
    way = np.linalg.norm(after - before, axis=2)[:, 1:]
    np.testing.assert_allclose(way[deep > 1e-6], deep[deep > 1e-6], atol=1e-6)
    np.testing.assert_array_equal(after[:, 0], before[:, 0])  # not the root


@pytest.mark.parametrize(
    "solid",
    [
        "{kind: sphere, radius: 0.4}",
        "{kind: capsule, radius: 0.4, length: 1}",
        "{kind: capsule, radius: 0.4, length: 1, rotation: [0, 0, 70]}",
        "{kind: capsule, radius: 0.4, length: 0}",
        "{kind: box, size: [0.9, 0.8, 0.8]}",
        "{kind: box, size: [0.8, 0.8, 0.9]}",
        "{kind: box, size: [0.8, 0.8, 0.8], rotation: [10, 20, 30]}",
    ],
)
def test_a_particle_at_the_very_centre_leaves_by_some_way(solid: str) -> None:
    scene = scene_of(ONE % (3, 0.3, "[0, 1, 0]", "collision") + f"solids: [{solid}]\n")
    solver = solver_of(scene, plain=True)
    solver.positions[:, 2:] = 0
    solver.step(0.0, 0.1)
    after = solver.particles()[0, 1:]
    np.testing.assert_allclose(np.linalg.norm(after, axis=1), 0.4, atol=1e-6)
    assert np.abs(depth(after, scene.solids[0], scene.emitter, 0.0)).max() < 1e-6


def test_a_rule_that_is_listed_twice_is_applied_twice() -> None:
    """In either solver: pulls add up."""
    once = scene_of(ONE % (4, 0.3, "[0, 1, 0]", "gravity: {acceleration: [1, -4, 4]}"))
    pulls = "gravity: {acceleration: [1, 2, 3]}, gravity: {acceleration: [0, -6, 1]}"
    twice = scene_of(ONE % (4, 0.3, "[0, 1, 0]", pulls))
    np.testing.assert_allclose(moved(twice, 3), moved(once, 3), atol=1e-6)
    np.testing.assert_array_equal(Surroundings(twice, np.float64).gravity, [1, -4, 4])
