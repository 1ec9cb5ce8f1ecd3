"""Whole segments and solids: how deep they are, and `segments: true`, which keeps them out."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from reference.rules import depth
from strand_kit import groom_of, scene_of, solver_of
from strandcli import simulate
from strandcli.constants import W
from strandcli.groom.blocks import pack
from strandcli.scene import Scene, loads
from strandcli.simulate.contact.kernels import measure
from strandcli.simulate.rules import registry
from strandcli.simulate.thesis.solver import ThesisSolver
from strandcli.solids import pack_all

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


JUMP = """
solver: rod
time: {frames: 12, fps: 24}
emitter:
  shape: {kind: sphere, radius: 0.1}
  strands: 300
  particles: 2
  length: 0.3
  jitter: 20
  keys: [{time: 0, ease: linear}, {time: 12, rotation: [0, 44280, 0], ease: linear}]
rules: [emitter_motion, gravity, wind: {strength: 100, gust: 0.5}, collision: {segments: SEGMENTS}]
solids:
  - {kind: sphere, radius: 0.098, follow: emitter}
  - kind: sphere
    radius: 0.15
    keys: [{time: 0, position: [-5, 0.1, 0], ease: step}, {time: 0.208333, position: [0.32, 0.05, 0], ease: step}]
"""
"""A ball appears in frame 6 over strands of one segment, which a head keeps from turning inward."""
ROUNDING = 2e-6
"""Metres: single precision in a scene a metre wide, a few operations long."""
TOLERANCE = 1e-3
"""Metres."""
SCENES = 40
KINDS: dict[str, Any] = {
    "sphere": lambda r: {"radius": r.uniform(0.01, 0.25)},
    "capsule": lambda r: {"radius": r.uniform(0.01, 0.15), "length": r.uniform(0.02, 0.5)},
    "box": lambda r: {"size": r.uniform(0.03, 0.4, 3).tolist()},
}


def depths(scene: Scene) -> np.ndarray:
    """(frames,) the greatest depth of a particle in any solid, roots left out, metres."""
    solver = simulate.solver_of(scene)(scene, groom_of(scene))
    found = []
    for frame in range(1, scene.time.frames + 1):
        solver.advance(frame)
        points = solver.particles()[:, 1:].astype(np.float64)
        time = (frame - 1) / scene.time.fps
        found.append(max(float(depth(points, one, scene.emitter, time).max()) for one in scene.solids))
    return np.array(found).clip(0)


def test_a_ball_that_appears_between_two_solids_is_left_by_every_tip() -> None:
    for segments in ("false", "true"):
        scene = loads(JUMP.replace("SEGMENTS", segments), rules=registry(), name="jump.yaml")
        assert depths(scene).max() < ROUNDING


def random_scene(seed: int, solver: str, segments: bool, elasticity: str = "first") -> Scene:
    """Solids of several kinds that stand, move and jump about an emitter that may move, too."""
    r = np.random.default_rng([19, seed])
    radius = float(r.uniform(0.05, 0.3))

    def keyed(place: np.ndarray) -> dict[str, Any]:
        times = sorted({0.0, *r.uniform(0.01, 0.45, int(r.integers(0, 4))).round(4).tolist()})
        return {"keys": [
            {"time": time, "position": (place + (time > 0) * r.uniform(-0.4, 0.4, 3)).tolist(),
             "rotation": r.uniform(-180, 180, 3).tolist(), "ease": str(r.choice(["step", "linear", "smooth"]))}
            for time in times
        ]}  # fmt: skip

    solids = []
    for kind in ["sphere", "capsule", "box", *r.choice(list(KINDS), int(r.integers(0, 2)))]:
        way = r.normal(size=3)
        place = way / np.linalg.norm(way) * (radius + r.uniform(-0.05, 0.5))
        follow = {"follow": "emitter"} if r.random() < 0.2 else {}
        solids.append({"kind": str(kind), **KINDS[kind](r), **keyed(place), **follow})
    if r.random() < 0.6:
        solids.append({"kind": "sphere", "radius": radius * float(r.uniform(0.9, 1.0)), "follow": "emitter"})
    emitter = {
        "shape": {"kind": "sphere", "radius": radius}, "strands": 128, "particles": int(r.choice([2, 3, 4, 6, 10])),
        "length": float(r.uniform(0.1, 0.6)), "jitter": float(r.uniform(0, 40)),
        **(keyed(np.zeros(3)) if r.random() < 0.6 else {}),
    }  # fmt: skip
    last: list[Any] = [{"collision": {"segments": segments}}]
    if solver == "thesis":
        last.insert(1 if elasticity == "last" else 0, "elasticity")
    data = {
        "solver": solver, "emitter": emitter, "solids": solids,
        "rules": ["emitter_motion", "gravity", {"wind": {"strength": float(r.uniform(0.1, 60))}}, *last],
        "time": {"frames": 12, "fps": 24, "substeps": int(r.choice([1, 2, 4]))},
    }  # fmt: skip
    import yaml

    return loads(yaml.safe_dump(data), rules=registry(), name="random.yaml")


def errors(scene: Scene) -> np.ndarray:
    """(frames - 1, 2) the greatest depth of a particle and of a segment, metres, from the first frame on that the
    solver has moved."""
    solver = simulate.solver_of(scene)(scene, groom_of(scene))
    found = []
    for frame in range(1, scene.time.frames + 1):
        solver.advance(frame)
        if frame > 1:
            one = solver.errors(frame)
            found.append((one["penetration_max"], one["segment_penetration_max"]))
    return np.array(found)


@pytest.mark.parametrize(
    ("solver", "elasticity", "share"),
    [("thesis", "first", 0.7), pytest.param("thesis", "last", 0.7, marks=pytest.mark.long), ("rod", "", 0.95)],
)
def test_segments_are_less_deep_for_being_caught(solver: str, elasticity: str, share: float) -> None:
    """In the worst frames of scenes, in which solids swallow roots: on the whole particles are as deep, and segments by
    a ``share`` less so. A single scene may go either way, for what is swallowed moves otherwise with segments than
    without."""
    deepest = [
        [errors(random_scene(seed, solver, segments, elasticity)).max(0) for seed in range(SCENES)]
        for segments in (False, True)
    ]
    (plain_particle, plain_segment), (particle, segment) = np.mean(deepest, axis=1)
    assert particle < plain_particle + TOLERANCE
    assert segment < share * plain_segment


MEASURED = {
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


@pytest.mark.parametrize("kind", MEASURED)
@pytest.mark.parametrize("particles", [2, 3, 7])
def test_segments_that_are_passed_over_are_not_the_deepest(kind: str, particles: int) -> None:
    """Of each block the greatest depth is told, and most segments are found to be no deeper without a search. Strands
    here lie along surfaces, where that is closest: their ends are put outside, of some blocks all of them."""
    scene = scene_of(TEXT % (particles, MEASURED[kind]))
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


def test_numbers_stay_numbers_where_everything_coincides() -> None:
    for solid in SOLIDS.values():  # parent, particle and the solid's centre in one place
        scene = scene_of(ACROSS % (0.0, 0.0, "collision: {segments: true}, elasticity", solid))
        solver = solver_of(scene, plain=True)
        solver.positions[:] = 0
        for _ in range(3):
            solver.step(0.0, 0.1)
        assert depth(solver.particles()[:, 1:], scene.solids[0], scene.emitter, 0.0).max() < 4  # and no NaN
