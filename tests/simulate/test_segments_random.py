"""`segments: true` keeps whole segments out of solids, and never at the price of a particle that `false` keeps out."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from reference.rules import depth
from strandcli.groom.emit import emit
from strandcli.scene import Scene, loads
from strandcli.simulate import solver_of
from strandcli.simulate.rules import registry

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
    solver = solver_of(scene)(scene, emit(scene.emitter, scene.seed))
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
    solver = solver_of(scene)(scene, emit(scene.emitter, scene.seed))
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
