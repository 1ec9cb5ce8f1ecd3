"""A shape of solid from outside the package, the example's ring: drawn, lit, collided with and known to the schema."""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

sys.path.insert(0, str(Path(__file__).parents[2] / "examples"))

import solid_shape as ring

from shadow_kit import soft_visibility
from strandcli.draw.shadows.kernels import penumbra
from strandcli.draw.solids.edges import ALL, PIXELS
from strandcli.draw.solids.kernels import rays, visible
from strandcli.draw.solids.solids import frames_of
from strandcli.draw.view.camera import camera_view
from strandcli.errors import UsageError
from strandcli.groom.emit import emit
from strandcli.scene import SceneError, loads
from strandcli.scene.model import Camera, Emitter, SphereSolid
from strandcli.scene.model.solids import SHAPES
from strandcli.scene.schema import json_schema
from strandcli.simulate.rod.solver import RodSolver
from strandcli.simulate.rules import registry
from strandcli.simulate.thesis.solver import ThesisSolver
from strandcli.solids import Solids, pack_all, register

R, THICK = 0.5, 0.125
STILL = Emitter()
FAR, SKIN = np.float32(1e3), np.float32(1e-3)

STRANDS = """
solver: {solver}
time: {{preroll: 0, fps: 30, frames: 16}}
image: {{size: 8x8}}
emitter: {{strands: 64, length: 1.0, particles: 12, shape: {{kind: disc, radius: 0.5}}, rotation: [180, 0, 0]}}
rules: [{rules}]
solids:
  - {{kind: ring, radius: 0.5, thickness: 0.125, position: [0.3, -0.6, 0.1], rotation: [20, 0, 10]}}
"""


@pytest.fixture(autouse=True)
def registered() -> Iterator[None]:
    register(ring)
    yield
    del SHAPES._drivers["ring"]


def packed(*more: Any, **settings: Any) -> Solids:
    return pack_all([ring.Settings(radius=R, thickness=THICK, **settings), *more], STILL, 0.0)


def depth(points: NDArray[Any], centre: tuple[float, ...], degrees: tuple[float, ...]) -> NDArray[np.float64]:
    """Of points (k, 3) in the ring at a place, turned about x and then z."""
    a, _, c = np.radians(degrees)
    about_x = np.array([[1, 0, 0], [0, math.cos(a), -math.sin(a)], [0, math.sin(a), math.cos(a)]])
    about_z = np.array([[math.cos(c), -math.sin(c), 0], [math.sin(c), math.cos(c), 0], [0, 0, 1]])
    x, y, z = ((points.astype(float) - centre) @ (about_z @ about_x)).T
    return np.asarray(THICK - np.hypot(np.hypot(x, z) - R, y))


def first_root(o: NDArray[np.float64], d: NDArray[np.float64]) -> float:
    """Where a ray from outside meets the ring: the least root of a quartic, inf where there is none."""
    square = np.poly1d([d @ d, 2 * o @ d, o @ o])
    flat = np.poly1d([d[0] ** 2 + d[2] ** 2, 2 * (o[0] * d[0] + o[2] * d[2]), o[0] ** 2 + o[2] ** 2])
    roots = ((square + (R**2 - THICK**2)) ** 2 - 4 * R**2 * flat).roots
    real = roots[(np.abs(roots.imag) < 1e-6) & (roots.real > 0)].real
    return float(real.min()) if len(real) else math.inf


def test_rays_meet_it_where_the_closed_form_does() -> None:
    solids = packed()
    random = np.random.default_rng(1)
    hits = 0
    for _ in range(400):
        o = random.normal(size=3)
        o *= 3 / np.linalg.norm(o)
        d = random.uniform(-0.7, 0.7, 3) - o
        expected = first_root(o, d)
        found = float(rays.meet(solids, 0, *o.astype(np.float32), *d.astype(np.float32)))
        if math.isinf(expected):
            assert math.isinf(found) or abs(depth(o[None] + found * d, (0, 0, 0), (0, 0, 0))[0]) < 2e-4
            continue
        hits += 1
        if math.isinf(found):  # a graze
            assert depth(o[None] + np.linspace(0.5, 1.5, 2000)[:, None] * d, (0, 0, 0), (0, 0, 0)).max() < 1e-3
            continue
        point = o + found * d
        assert abs(depth(point[None], (0, 0, 0), (0, 0, 0))[0]) < 2e-4
        assert found <= expected + 2e-5
        normal = np.array(rays.normal(solids, 0, *point.astype(np.float32)))
        middle = np.array([point[0], 0, point[2]]) * R / math.hypot(point[0], point[2])
        np.testing.assert_allclose(normal, (point - middle) / np.linalg.norm(point - middle), atol=5e-3)
    assert hits > 100


def test_its_silhouette_is_a_ring_of_pixels() -> None:
    camera = Camera(kind="orthographic", position=(0.2, 5.0, 0.0), target=(0.2, 0.0, 0.001), height=2.0)
    width, height = 160, 120
    view = camera_view(camera, 0.0, width, height, np.array([[-1.0, -1, -1], [1, 1, 1]]))
    solids = packed(position=(0.2, 0.0, 0.0))
    keys = np.zeros(width * height, np.uint64)
    frames = frames_of(solids, view)
    visible.find(PIXELS, ALL, width, view.pack(), solids, frames, keys)
    seen = (keys != keys.max()).reshape(height, width)
    y, x = np.mgrid[:height, :width]
    metre = height / 2.0
    away = np.abs(np.hypot(x + 0.5 - width / 2, y + 0.5 - height / 2) / metre - R) - THICK
    sure = np.abs(away) > 2e-3
    assert seen.sum() > 1000
    np.testing.assert_array_equal(seen[sure], away[sure] < 0)


def test_its_shadow_on_the_ground_is_a_ring_and_soft_in_a_wide_light() -> None:
    solids = packed()
    up = (np.float32(0), np.float32(1), np.float32(0))
    for off in np.linspace(0.0, 1.0, 101):
        if abs(abs(off - R) - THICK) < 5e-3:
            continue
        point = np.array([0.6 * off, -1.0, 0.8 * off], np.float32)
        hidden = abs(off - R) < THICK
        assert rays.visibility(solids, *point, *up, FAR, SKIN) == (0 if hidden else 1)
        ray = penumbra.LightRay(*point, *up, FAR)
        share = float(soft_visibility(solids, ray, SKIN, np.float32(0.02), np.float32(0)))
        far = abs(abs(off - R) - THICK) > 0.03  # the light is .02 m wide there at the distance of a metre
        assert not far or share == pytest.approx(0 if hidden else 1, abs=1e-3)
        assert 0 <= share <= 1
    edge = np.array([R + THICK, -1.0, 0.0], np.float32)
    ray = penumbra.LightRay(*edge, *up, FAR)
    half = float(soft_visibility(solids, ray, SKIN, np.float32(0.02), np.float32(0)))
    assert half == pytest.approx(0.5, abs=0.08)


def test_points_of_its_own_surface_are_lit_where_they_face_the_light() -> None:
    solids = packed()
    for angle in np.radians(np.arange(10, 171, 10)):  # about the tube, from outside to inside, the light above
        point = np.array([R + THICK * math.cos(angle), THICK * math.sin(angle), 0.0], np.float32)
        assert rays.visibility(solids, *point, *np.array([0, 1, 0], np.float32), FAR, SKIN) == 1
    inner = np.array([R - THICK, 0.0, 0.0], np.float32)  # and hidden by the other side of the ring
    assert rays.visibility(solids, *inner, *np.array([-1, 0, 0], np.float32), FAR, SKIN) == 0


@pytest.mark.parametrize(("solver", "collision"), [
    ("thesis", "collision"), ("rod", "collision"), ("rod", "{collision: {segments: true}}"),
])  # fmt: skip
def test_strands_stay_outside(solver: str, collision: str) -> None:
    deepest = {}
    for rules in ("gravity", f"gravity, {collision}"):
        if solver == "thesis":
            rules += ", elasticity"
        scene = loads(STRANDS.format(solver=solver, rules=rules), rules=registry())
        deepest[rules] = float(depth(positions(scene)[:, 1:].reshape(-1, 3), (0.3, -0.6, 0.1), (20, 0, 10)).max())
    free, kept = deepest.values()
    assert free > 0.1
    assert kept < (0.01 if solver == "thesis" else 1e-4)


def positions(scene: Any) -> NDArray[np.float32]:
    """Those of the last frame, undrawn."""
    solver: Any = (RodSolver if scene.solver == "rod" else ThesisSolver)(scene, emit(scene.emitter, scene.seed))
    solver.advance(16)
    found: NDArray[np.float32] = solver.particles()
    return found


def test_it_stands_in_the_schema_and_its_faults_are_found() -> None:
    assert "Settings" in str(json_schema(registry())["properties"]["solids"])
    loads("solids: [{kind: ring, thickness: 0.2}]", rules=registry())
    with pytest.raises(SceneError, match="thicknes"):
        loads("solids: [{kind: ring, thicknes: 0.2}]", rules=registry())
    with pytest.raises(SceneError, match="above 0"):
        loads("solids: [{kind: ring, radius: -1}]", rules=registry())


def test_a_kind_that_is_taken_or_lacks_a_part_is_refused() -> None:
    class Other:
        kind = "sphere"
        Settings = SphereSolid
        numbers = reach = distance = staticmethod(lambda *_: 0.0)

    with pytest.raises(UsageError, match="another solid has this kind"):
        register(Other)
    with pytest.raises(UsageError, match="has no `reach`"):
        register(type("Part", (), {"kind": "part", "Settings": ring.Settings, "numbers": None, "distance": None}))


def test_scenes_without_it_have_the_type_that_they_had() -> None:
    assert type(pack_all([SphereSolid()], STILL, 0.0)) is Solids
    assert type(packed(SphereSolid())) is not Solids
    assert type(packed(SphereSolid())) is type(packed(SphereSolid(), SphereSolid()))
    assert type(packed()) is not type(packed(SphereSolid()))  # kernels for it have none of the four shapes
