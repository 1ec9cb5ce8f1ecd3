"""Depths of particles and of whole segments, which frames report, against a search in float64."""

from __future__ import annotations

import numpy as np
import pytest

from reference.rules import depth
from strand_kit import scene_of, solver_of
from strandcli.blocks import pack

SOLIDS = {
    "sphere": "{kind: sphere, radius: 0.5, position: [0.1, 0.2, -0.1]}",
    "capsule": "{kind: capsule, radius: 0.3, length: 1.1, rotation: [40, 30, 20]}",
    "plane": "{kind: plane, position: [0, -0.3, 0], rotation: [10, 0, 20]}",
    "box": "{kind: box, size: [0.8, 0.6, 1.1], rotation: [30, 20, 40]}",
}
TEXT = """
emitter: {strands: 1, particles: %d, length: 1}
rules: [collision]
solids: [%s]
"""


@pytest.mark.parametrize("kind", SOLIDS)
@pytest.mark.parametrize("particles", [2, 4])
def test_depths_of_particles_and_of_segments(kind: str, particles: int) -> None:
    scene = scene_of(TEXT % (particles, SOLIDS[kind]))
    solver = solver_of(scene, plain=True)
    share = np.linspace(0, 1, 4001)[:, None, None, None]
    for seed in range(60):
        strand = np.random.default_rng(seed).uniform(-1, 1, (1, particles, 3)).astype(np.float32)
        solver.positions[:, 1:] = pack(strand)
        x = strand.astype(np.float64)
        found = solver.errors(1)
        points = depth(x[:, 1:], scene.solids[0], scene.emitter, 0.0)
        assert found["penetration_max"] == pytest.approx(max(points.max(), 0), abs=1e-6)
        segments = depth(x[:, :-1] + share * (x[:, 1:] - x[:, :-1]), scene.solids[0], scene.emitter, 0.0).max(0)
        segments[:, 0] -= depth(x[:, 0], scene.solids[0], scene.emitter, 0.0).clip(0)
        assert found["segment_penetration_max"] == pytest.approx(max(segments.max(), 0), abs=3e-4)


def test_a_segment_across_a_ball_is_told_though_both_of_its_ends_are_outside() -> None:
    """A chord that passes the centre at a distance of 0.48 is 0.02 deep in a ball of 0.5."""
    scene = scene_of(TEXT % (2, "{kind: sphere, radius: 0.5}"))
    solver = solver_of(scene, plain=True)
    solver.positions[:, 1:] = pack(np.array([[[-2, 0.48, 0], [2, 0.48, 0]]], np.float32))
    found = solver.errors(1)
    assert found["penetration_max"] == 0
    assert found["segment_penetration_max"] == pytest.approx(0.02, abs=1e-6)
