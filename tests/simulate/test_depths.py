"""Depths of particles and of whole segments, which frames report, against a search in float64."""

from __future__ import annotations

import numpy as np
import pytest

from reference.rules import depth
from strand_kit import scene_of, solver_of
from strandcli.constants import W
from strandcli.groom.blocks import pack
from strandcli.simulate.contact.kernels import measure
from strandcli.solids import pack_all

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


def deepest_places(x: np.ndarray, solid: object, emitter: object) -> np.ndarray:
    """(strands, segments) the depth of each segment by a search in thirds: along a line depth has one maximum."""
    low, high = np.zeros(x[:, :-1].shape[:2]), np.ones(x[:, :-1].shape[:2])
    edge = np.diff(x, axis=1)

    def at(share: np.ndarray) -> np.ndarray:
        return np.asarray(depth(x[:, :-1] + share[..., None] * edge, solid, emitter, 0.0))

    for _ in range(60):
        a, b = low + (high - low) / 3, high - (high - low) / 3
        left = at(a) > at(b)
        low, high = np.where(left, low, a), np.where(left, b, high)
    return np.asarray(np.maximum(np.maximum(at(low), at(high)), np.maximum(at(0 * low), at(0 * low + 1))))


@pytest.mark.parametrize("kind", SOLIDS)
@pytest.mark.parametrize("particles", [2, 3, 7])
def test_segments_that_are_passed_over_are_not_the_deepest(kind: str, particles: int) -> None:
    """Of each block the greatest depth is told, and most segments are found to be no deeper without a search. Strands
    here lie along surfaces, where that is closest: their ends are put outside, of some blocks all of them."""
    scene = scene_of(TEXT % (particles, SOLIDS[kind]))
    solid = scene.solids[0]
    rng = np.random.default_rng(particles)
    blocks = 40
    steps = rng.normal(size=(blocks * W, particles, 3)) * 10 ** rng.uniform(-2, -0.3, blocks).repeat(W)[:, None, None]
    x = (rng.uniform(-1, 1, (blocks * W, 1, 3)) + np.cumsum(steps, 1)).astype(np.float64)
    step = 1e-4
    led_out = rng.choice([0.98, 1], blocks).repeat(W)[:, None]
    for _ in range(4):
        slope = np.stack([depth(x + step * axis, solid, scene.emitter, 0.0) for axis in np.eye(3)], -1)
        slope -= depth(x, solid, scene.emitter, 0.0)[..., None]
        slope /= np.maximum(np.linalg.norm(slope, axis=-1, keepdims=True), 1e-9)
        out = depth(x, solid, scene.emitter, 0.0) + rng.choice([0, 1e-6, 1e-3], (len(x), 1))
        x -= np.where(rng.random(out.shape) < led_out, out, 0)[..., None] * slope
    x = x.astype(np.float32).astype(np.float64)
    positions = np.zeros((blocks, particles + 1, 3 * W), np.float32)
    positions[:, 1:] = pack(x.astype(np.float32))
    found = np.zeros((blocks, measure.COLUMNS), np.float32)
    measure.depths(positions, pack_all(scene.solids, scene.emitter, 0.0), found)
    ends = depth(x[:, 1:], solid, scene.emitter, 0.0).reshape(blocks, -1).max(1).clip(0)
    inner = deepest_places(x, solid, scene.emitter)
    inner[:, 0] -= depth(x[:, 0], solid, scene.emitter, 0.0).clip(0)
    inner = inner.reshape(blocks, -1).max(1).clip(0)
    assert (inner > ends).any() or kind == "plane"
    rounding = 1e-6 * max(1, np.abs(x).max())
    assert np.abs(found[:, measure.PARTICLES] - ends).max() < rounding
    assert np.abs(found[:, measure.SEGMENTS] - inner).max() < rounding


def test_coordinates_that_are_not_finite_are_counted_and_leave_the_rest_told() -> None:
    scene = scene_of(TEXT % (3, "{kind: sphere, radius: 0.5}"))
    solver = solver_of(scene, plain=True)
    strand = np.array([[[-2, 0.48, 0], [2, 0.48, 0], [2, 2, 0]]], np.float32)
    solver.positions[:, 1:] = pack(strand)
    told = solver.errors(1)
    for bad in (np.nan, np.inf, -np.inf):
        solver.positions[0, 3, W + 5] = bad
        found = solver.errors(1)
        assert found["nonfinite"] == 1
        assert found["segment_penetration_max"] == told["segment_penetration_max"]
        assert not np.isnan([v for v in found.values() if v is not None]).any()
