"""Rays against solids: where they meet, the normal there, the pixels that a solid can touch, and shadows."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from reference.rules import depth
from strandcli.draw.common.kernels.keys import EMPTY, FIRST
from strandcli.draw.solids.edges import ALL, PIXELS
from strandcli.draw.solids.kernels import rays as kernel
from strandcli.draw.solids.kernels import visible
from strandcli.draw.solids.solids import frames_of
from strandcli.draw.view.camera import View, camera_view
from strandcli.scene.model import BoxSolid, Camera, CapsuleSolid, Emitter, PlaneSolid, Solid, SphereSolid
from strandcli.solids import Solids, pack_all

STILL = Emitter()
SPHERE = SphereSolid(radius=0.6, position=(0.2, -0.1, 0.3))
CAPSULE = CapsuleSolid(radius=0.3, length=1.1, position=(-0.1, 0.2, 0.0), rotation=(30.0, 20.0, 50.0))
PLANE = PlaneSolid(position=(0.0, -0.4, 0.1), rotation=(10.0, 0.0, -15.0))
BOX = BoxSolid(size=(0.8, 0.5, 1.2), position=(0.1, 0.1, -0.2), rotation=(20.0, 40.0, 10.0))
EVERY: list[Solid] = [SPHERE, CAPSULE, PLANE, BOX]
KINDS = pytest.mark.parametrize("solid", EVERY, ids=[solid.kind for solid in EVERY])
BOUNDS = np.array([[-2.0, -2, -2], [2, 2, 2]])


def packed(solids: list[Any], emitter: Emitter = STILL, time: float = 0.0) -> Solids:
    return pack_all(solids, emitter, time)


def meets(solid: Solid, origin: np.ndarray, way: np.ndarray) -> float:
    o, d = np.asarray(origin, np.float32), np.asarray(way, np.float32)
    return float(kernel.meet(packed([solid]), 0, *o, *d))


def inside(solid: Solid, points: np.ndarray) -> np.ndarray:
    return depth(points, solid, STILL, 0.0)


@KINDS
def test_a_ray_meets_a_solid_where_it_first_goes_inside(solid: Solid) -> None:
    rng = np.random.default_rng(1)
    hits = misses = 0
    for _ in range(400):
        origin = rng.uniform(-3, 3, 3)
        if inside(solid, origin) > -0.05:
            continue
        way = (rng.uniform(-1, 1, 3) - origin) * rng.uniform(0.3, 3)
        t = meets(solid, origin, way)
        share = np.linspace(0, t if 0 < t < np.inf else 20, 4001)[:-1, None]
        before = inside(solid, origin + share * way)
        if np.isfinite(t) and t > 0:
            hits += 1
            assert abs(inside(solid, origin + t * way)) < 1e-5
            assert before.max() < 1e-5
            after = origin + (t + 1e-3 / np.linalg.norm(way)) * way
            assert inside(solid, after) > -1e-5
        else:
            misses += 1
            assert before.max() < 1e-4  # nothing is ahead (behind, a negative number may say)
    assert hits > 60
    assert misses > 20


@KINDS
def test_far_away_a_ray_still_meets_to_a_small_share_of_the_solids_size(solid: Solid) -> None:
    """From a thousand metres b² − a c would be noise."""
    if isinstance(solid, PlaneSolid):
        return
    rng = np.random.default_rng(2)
    for far in (100.0, 1000.0):
        centre = np.array(solid.position)
        for _ in range(60):
            way = rng.normal(size=3)
            way /= np.linalg.norm(way)
            t = meets(solid, centre - far * way, way)
            assert np.isfinite(t)
            assert abs(inside(solid, centre + (t - far) * way)) < 3e-7 * far


@KINDS
def test_nothing_is_met_from_inside_or_behind(solid: Solid) -> None:
    rng = np.random.default_rng(3)
    points = rng.uniform(-1, 1, (3000, 3))
    deep = points[inside(solid, points) > 0.02][:100]
    assert len(deep) > 20
    for point in deep:
        t = meets(solid, point, rng.normal(size=3))
        assert t == np.inf or t < 0


@KINDS
def test_normals_are_unit_and_point_outward(solid: Solid) -> None:
    """Along them the depth inside falls as fast as it can."""
    rng = np.random.default_rng(4)
    checked = 0
    for _ in range(300):
        origin = rng.uniform(-3, 3, 3)
        way = rng.uniform(-0.5, 0.5, 3) - origin
        t = meets(solid, origin, way)
        if inside(solid, origin) > 0 or not 0 < t < np.inf:
            continue
        point = origin + t * way
        normal = np.array(kernel.normal(packed([solid]), 0, *point.astype(np.float32)))
        assert np.linalg.norm(normal) == pytest.approx(1, abs=1e-6)
        away = inside(solid, point + 1e-3 * normal) - inside(solid, point)
        if solid.kind != "box" or np.sort(np.abs(np.array(solid.size) / 2 - np.abs(_local(solid, point))))[1] > 2e-3:  # type: ignore[union-attr]
            assert away == pytest.approx(-1e-3, rel=5e-3)
            checked += 1
    assert checked > 60


def _local(solid: Solid, point: np.ndarray) -> np.ndarray:
    numbers = packed([solid])[3][0].astype(np.float64)
    return np.asarray((point - numbers[:3]) @ numbers[3:12].reshape(3, 3))


def picture(solids: list[Any], view: View, frames: np.ndarray | None = None) -> np.ndarray:
    """(height, width) keys with the solids drawn."""
    width, height = int(view.width), int(view.height)
    numbers = packed(solids)
    if frames is None:
        frames = np.array([[0, width, 0, height]] * len(solids), np.int64).reshape(-1, 4)
    keys = np.zeros(width * height, np.uint64)
    visible.find(PIXELS, ALL, width, view.pack(), numbers, frames, keys)
    return keys.reshape(height, width)


PLACES = st.tuples(*[st.floats(-3, 3)] * 3)
TURNS = st.tuples(*[st.floats(-180, 180)] * 3)
SOLIDS = st.one_of(
    st.builds(SphereSolid, radius=st.floats(0.01, 2), position=PLACES),
    st.builds(CapsuleSolid, radius=st.floats(0.01, 1), length=st.floats(0, 3), position=PLACES, rotation=TURNS),
    st.builds(PlaneSolid, position=PLACES, rotation=TURNS),
    st.builds(BoxSolid, size=st.tuples(*[st.floats(0.01, 2)] * 3), position=PLACES, rotation=TURNS),
)
CAMERAS = st.builds(
    Camera,
    kind=st.sampled_from(["perspective", "orthographic"]),
    position=st.tuples(st.floats(-6, 6), st.floats(-6, 6), st.floats(3.5, 9)),
    target=st.tuples(*[st.floats(-2, 2)] * 3),
    fov=st.floats(5, 160),
    height=st.floats(0.1, 10),
)


@settings(max_examples=50, deadline=None)
@given(st.lists(SOLIDS, min_size=1, max_size=4), CAMERAS)
def test_frames_hold_every_pixel_that_a_solid_touches(solids: list[Solid], camera: Camera) -> None:
    view = camera_view(camera, 0.0, 40, 30, BOUNDS)
    frames = frames_of(packed(solids), view)
    assert (frames >= 0).all()
    assert (frames[:, :2] <= 40).all()
    assert (frames[:, 2:] <= 30).all()
    np.testing.assert_array_equal(picture(solids, view, frames), picture(solids, view))


def test_the_nearest_solid_is_drawn_and_nothing_before_the_near_plane() -> None:
    view = camera_view(Camera(position=(0.0, 0.0, 5.0), near=1.0), 0.0, 60, 60, BOUNDS)
    behind, front = SphereSolid(radius=0.6), SphereSolid(radius=0.3, position=(0.0, 0.0, 1.0))
    for solids, middle in (([behind, front], 1), ([front, behind], 0)):
        keys = picture(solids, view)
        assert int(keys[30, 30] & np.uint64(0xFFFFFFFF)) - int(FIRST) == middle
        depths = (np.uint64(0xFFFFFFFF) - (keys >> np.uint64(32))).astype(np.uint32).view(np.float32)
        assert 1 / depths[30, 30] == pytest.approx(3.7, rel=1e-3)
        assert keys[0, 0] == EMPTY
    close = picture([SphereSolid(radius=0.3, position=(0.0, 0.0, 4.5))], view)
    assert (close == EMPTY).all()


@pytest.mark.parametrize("kind", ["perspective", "orthographic"])
def test_the_outline_of_a_sphere_is_where_it_should_be(kind: str) -> None:
    view = camera_view(Camera(kind=kind, position=(0.0, 0.0, 5.0), height=3.0), 0.0, 300, 300, BOUNDS)
    covered = (picture([SphereSolid(radius=0.7)], view) != EMPTY).sum()
    reach = view.focal * (0.7 / np.sqrt(25 - 0.49) if kind == "perspective" else 0.7)
    assert covered == pytest.approx(np.pi * reach**2, rel=5e-3)


@settings(max_examples=60, deadline=None)
@given(SOLIDS, st.integers(0, 10**6), st.booleans())
def test_a_point_is_in_shadow_where_a_solid_is_between_it_and_the_light(solid: Solid, seed: int, near: bool) -> None:
    """Deeper than the skin on the way: dark; nowhere inside on the way: lit."""
    rng = np.random.default_rng(seed)
    skin = 0.01
    point, lamp = rng.uniform(-4, 4, (2, 3))
    if near:  # a lamp close to the solid's own place
        lamp = np.array(solid.position) + rng.normal(0, 1, 3)
    if depth(point, solid, STILL, 0.0) > -0.05 or depth(lamp, solid, STILL, 0.0) > -0.05:
        return
    reach = np.linalg.norm(lamp - point)
    way = (lamp - point) / reach
    share = np.linspace(0, 1, 3001)[:, None]
    deepest = depth(point + share * (lamp - point), solid, STILL, 0.0).max()
    numbers = [x.astype(np.float32) for x in (*point, *way)]
    lit = kernel.visibility(packed([solid]), *numbers, np.float32(reach), np.float32(skin))
    if deepest > 2 * skin:
        assert lit == 0
    elif deepest < -1e-4:
        assert lit == 1


def test_a_root_on_a_solid_is_not_shaded_by_the_skin_that_it_grows_from() -> None:
    ball = SphereSolid(radius=0.5)
    rng = np.random.default_rng(5)
    for _ in range(200):
        normal, light = rng.normal(size=(2, 3))
        normal, light = normal / np.linalg.norm(normal), light / np.linalg.norm(light)
        for off in (-1e-7, 1e-7, 5e-3):
            root = ((0.5 + off) * normal).astype(np.float32)
            numbers = (*root, *light.astype(np.float32), np.float32(1e30), np.float32(0.01))
            cosine = float(normal @ light)
            if cosine > 0.02:
                assert kernel.visibility(packed([ball]), *numbers) == 1
            elif cosine < -0.3:
                assert kernel.visibility(packed([ball]), *numbers) == 0
