"""Segments that pass through a solid between two particles: not seen point by point, caught with `segments: true`."""

from __future__ import annotations

import numpy as np
import pytest

from reference.rules import depth
from strand_kit import scene_of, solver_of
from strandcli.constants import W
from strandcli.scene import Scene
from strandcli.simulate.thesis.solver import ThesisSolver

# one long segment from x = -2 to 2, a little beside the middle of a solid at the origin
ACROSS = """
emitter: {strands: 1, particles: 2, length: 4, shape: {kind: plane, width: 1e-9, depth: 1e-9}, direction: [1, 0, 0],
  position: [-2, %g, %g]}
time: {fps: 10}
rules: [%s]
solids: [%s]
"""
SOLIDS = {
    "sphere": "{kind: sphere, radius: 0.5}",
    "capsule across": "{kind: capsule, radius: 0.3, length: 1.5, rotation: [90, 0, 0]}",
    "capsule along": "{kind: capsule, radius: 0.3, length: 1.5, rotation: [0, 0, 90]}",
    "capsule askew": "{kind: capsule, radius: 0.3, length: 1.5, rotation: [40, 30, 20]}",
    "box": "{kind: box, size: [0.8, 0.6, 0.9]}",
    "turned box": "{kind: box, size: [0.8, 0.6, 0.9], rotation: [30, 20, 40]}",
}
BESIDE = [(0.1, 0.05), (-0.2, 0.0), (0.02, -0.15), (0.0, 0.0)]


def deepest(points: np.ndarray, scene: Scene) -> float:
    """Depth of the deepest place of any segment, (strands, particles, 3)."""
    share = np.linspace(0, 1, 2001)[:, None, None, None]
    dense = points[:, :-1] + share * (points[:, 1:] - points[:, :-1])
    return float(depth(dense, scene.solids[0], scene.emitter, 0.0).max())


def solver_across(scene: Scene, beside: tuple[float, float]) -> ThesisSolver:
    """A solver whose strand is exactly where it is said to be: through the very middle, too."""
    solver = solver_of(scene, plain=True)
    solver.positions[:, :, W : 2 * W], solver.positions[:, :, 2 * W :] = beside
    return solver


@pytest.mark.parametrize("solid", SOLIDS.values(), ids=SOLIDS.keys())
@pytest.mark.parametrize("beside", BESIDE)
def test_a_long_segment_is_caught_where_points_are_not(solid: str, beside: tuple[float, float]) -> None:
    points = scene_of(ACROSS % (*beside, "collision", solid))
    solver = solver_across(points, beside)
    before = solver.particles()
    through = deepest(before, points)
    assert through > 0.05
    for _ in range(5):
        solver.step(0.0, 0.1)
    np.testing.assert_array_equal(solver.particles(), before)  # both ends are outside: points see nothing

    scene = scene_of(ACROSS % (*beside, "collision: {segments: true}, elasticity", solid))
    solver = solver_across(scene, beside)
    for _ in range(12):
        solver.step(0.0, 0.1)
    after = solver.particles()
    np.testing.assert_array_equal(after[:, 0], before[:, 0])
    assert deepest(after, scene) < 0.02 * through
    assert solver.errors(1)["stretch_max"] < 1e-5


@pytest.mark.parametrize("solid", SOLIDS.values(), ids=SOLIDS.keys())
def test_a_segment_that_touches_nothing_is_left_alone(solid: str) -> None:
    for beside in ((0.9, 0.0), (0.0, -1.2), (2.0, 2.0)):
        scene = scene_of(ACROSS % (*beside, "collision: {segments: true}", solid))
        solver = solver_of(scene, plain=True)
        before = solver.particles()
        assert deepest(before, scene) < 0
        solver.step(0.0, 0.1)
        np.testing.assert_array_equal(solver.particles(), before)


def test_strands_that_stand_on_their_own_sphere_are_left_alone() -> None:
    """Roots lie on the solid's surface, or a rounding below it; that is no reason to push."""
    text = """
emitter: {strands: 300, particles: 4, length: 0.5, jitter: 30, shape: {kind: sphere, radius: 0.4}}
rules: [collision: {segments: true}]
solids: [{kind: sphere, radius: 0.4}]
"""
    solver = solver_of(scene_of(text), plain=True)
    before = solver.particles()
    solver.step(0.0, 0.1)
    assert np.abs(solver.particles() - before).max() < 1e-6
