"""The truncated cone, a shape with closed forms, against its support function, NumPy rays and dense segments."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from strand_kit import scene_of, solver_of
from strandcli.draw.solids.kernels import rays
from strandcli.groom.blocks import pack
from strandcli.scene.model import Emitter
from strandcli.scene.motion import solid_pose
from strandcli.simulate.advice import depth
from strandcli.solid_shapes import cone
from strandcli.solids import pack_all

Floats = NDArray[np.float64]
STILL = Emitter()
ASKEW: dict[str, Any] = {"position": (0.1, -0.2, 0.3), "rotation": (25.0, 40.0, -10.0)}
SHAPES_OF_IT: dict[str, dict[str, float]] = {
    "flat": {"radius": 0.8, "top": 0.3, "length": 0.2},
    "funnel": {"radius": 0.1, "top": 0.6, "length": 0.7},
}
EVERY = pytest.mark.parametrize("sizes", SHAPES_OF_IT.values(), ids=SHAPES_OF_IT.keys())
ANGLES = np.linspace(-math.pi / 2, math.pi / 2, 20001)


def local(solid: Any, points: Any) -> Floats:
    """Points of the world in a solid's own frame."""
    pose = solid_pose(solid, STILL, 0.0)
    return np.asarray((np.asarray(points, float) - pose.translation) @ np.array(pose.rotation))


def signed(solid: Any, points: Any, angles: Floats = ANGLES) -> Floats:
    """Signed distance of points (..., 3) of the world from a convex body: over all directions, the greatest by which a
    point is beyond the plane that touches the body. Here for the directions of a half plane at these angles, exact to
    the step between them: 2e-4 for all of them."""
    x, y, z = np.moveaxis(local(solid, points), -1, 0)
    flat, up, h = np.cos(angles), np.sin(angles), solid.length / 2
    touch = np.maximum(solid.radius * flat - h * up, solid.top * flat + h * up)
    found = [np.max(q * flat + v * up - touch) for q, v in zip(np.hypot(x, z).ravel(), y.ravel(), strict=True)]
    return np.reshape(found, x.shape)


def inside(solid: Any, points: Any) -> NDArray[np.bool_]:
    x, y, z = np.moveaxis(local(solid, points), -1, 0)
    share = y / solid.length + 0.5
    return np.asarray((abs(share - 0.5) < 0.5) & (np.hypot(x, z) < solid.radius + share * (solid.top - solid.radius)))


def of(sizes: dict[str, float]) -> cone.Settings:
    return cone.Settings(**sizes, **ASKEW)


def rays_at(solid: Any, count: int, away: float, seed: int) -> list[tuple[NDArray[np.float32], NDArray[np.float32]]]:
    """Origins ``away`` from a solid's middle, and vectors to points about it."""
    random = np.random.default_rng(seed)
    origins = random.normal(size=(count, 3))
    origins *= away / np.linalg.norm(origins, axis=1, keepdims=True)
    aims = random.uniform(-0.7, 0.7, (count, 3)) - origins
    return list(zip((origins + solid.position).astype(np.float32), aims.astype(np.float32), strict=True))


@EVERY
def test_distance_is_that_of_its_support_function(sizes: dict[str, float]) -> None:
    solid = of(sizes)
    points = np.random.default_rng(2).uniform(-1, 1, (800, 3)) + solid.position
    expected = signed(solid, points)
    assert (expected < 0).sum() > 10
    found = [cone.distance(*one, cone.numbers(solid)) for one in local(solid, points)]
    np.testing.assert_allclose(found, expected, atol=2e-4)
    assert np.all(np.linalg.norm(local(solid, points[expected < 0]), axis=1) < cone.reach(solid))


@EVERY
def test_its_normal_is_the_way_in_which_the_distance_grows(sizes: dict[str, float]) -> None:
    solid = of(sizes)
    p = cone.numbers(solid)
    checked = 0
    for one in np.random.default_rng(3).uniform(-1, 1, (600, 3)):
        steps = [np.array([cone.distance(*(one + s), p) for s in h * np.eye(3)]) for h in (1e-6, -1e-6)]
        grows = (steps[0] - steps[1]) / 2e-6
        if abs(np.linalg.norm(grows) - 1) > 1e-6:  # between two faces
            continue
        found = np.array(cone.normal(*one, p))
        np.testing.assert_allclose(found / np.linalg.norm(found), grows, atol=1e-5)
        checked += 1
    assert checked > 500
    axis = np.array(cone.normal(0.0, 0.0, 0.0, p))
    assert np.isfinite(axis).all()
    assert np.any(axis != 0)
    on_rim = np.array(cone.normal(solid.radius, -solid.length / 2, 0.0, p))
    assert on_rim[0] >= 0
    assert np.any(on_rim != 0)


@EVERY
@pytest.mark.parametrize("away", [2.0, 200.0])
def test_rays_meet_it_where_it_begins(sizes: dict[str, float], away: float) -> None:
    solid = of(sizes)
    solids = pack_all([solid], STILL, 0.0)
    share = np.linspace(1 - min(2.5 / away, 1), 1 + 2.5 / away, 8001)
    hits = 0
    for o, d in rays_at(solid, 300, away, 4):
        there = inside(solid, o.astype(float) + share[:, None] * d)
        found = float(rays.meet(solids, 0, *o, *d))
        if not there.any():
            grazed = math.isfinite(found) and abs(signed(solid, o + found * d.astype(float))) < 1e-3
            assert math.isinf(found) or grazed
        elif math.isinf(found):
            assert there.sum() < 8  # no more than a corner
        else:
            hits += 1
            assert abs(found - share[there.argmax()]) < share[1] - share[0] + 4e-7  # and single precision
            point = o + found * d.astype(float)
            assert abs(signed(solid, point)) < 2e-4 + 2e-7 * away
            n = np.array(rays.normal(solids, 0, *point.astype(np.float32)))
            assert np.linalg.norm(n) == pytest.approx(1, abs=1e-5)
            assert n @ d <= 1e-3 * np.linalg.norm(d)
    assert hits > 60
    middle = np.array(solid_pose(solid, STILL, 0.0).translation, np.float32)
    assert math.isinf(float(rays.meet(solids, 0, *middle, *np.eye(3, dtype=np.float32)[1])))  # begun inside


STRAND = """
emitter: {strands: 1, particles: 4, length: 1}
rules: [collision]
solids: [%s]
"""


@EVERY
def test_reported_depths_are_those_of_dense_segments(sizes: dict[str, float]) -> None:
    written = ", ".join(f"{key}: {value}" for key, value in sizes.items())
    scene = scene_of(STRAND % f"{{kind: cone, {written}, position: [0.1, -0.2, 0.3], rotation: [25, 40, -10]}}")
    solver = solver_of(scene, plain=True)
    solid = scene.solids[0]
    share = np.linspace(0, 1, 1001)[:, None, None]
    deep = 0
    for seed in range(60):
        strand = np.random.default_rng(seed).uniform(-1, 1, (1, 4, 3)).astype(np.float32)
        solver.positions[:, 1:] = pack(strand)
        x = strand[0].astype(np.float64)
        points = depth(x[1:], solid, STILL)
        places = x[:-1] + share * (x[1:] - x[:-1])
        segments = depth(places.reshape(-1, 3), solid, STILL).reshape(-1, 3).max(0)
        segments[0] -= depth(x[:1], solid, STILL)[0].clip(0)
        found = solver.errors(1)
        assert found["penetration_max"] == pytest.approx(max(points.max(), 0), abs=1e-6)
        longest = float(np.linalg.norm(np.diff(x, axis=0), axis=1).max())
        # the search narrows a segment to 7e-5 of it, the reference to a thousandth
        assert max(segments.max(), 0) - 7e-5 * longest - 1e-6 < found["segment_penetration_max"]
        assert found["segment_penetration_max"] < max(segments.max(), 0) + 1e-3 * longest
        deep += segments.max() > 0.02
    assert deep > 5
