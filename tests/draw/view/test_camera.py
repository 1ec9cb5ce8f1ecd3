"""Views of the camera and of lights, and the projection of vertices."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from strandcli.draw.common.scratch import Scratch
from strandcli.draw.geometry.curves import Polylines
from strandcli.draw.view.camera import View, axes, ball, camera_view, parallel_view, point_views
from strandcli.draw.zbuffer.raster import to_screen
from strandcli.scene.model import Camera, CameraKey

VECTORS = st.tuples(*[st.floats(-100, 100)] * 3).filter(lambda v: np.linalg.norm(v) > 1e-3)
COORDINATES = st.floats(-(2.0**100), 2.0**100, width=32) | st.floats(-10, 10, width=32)
BOX = np.array([[-1.0, -0.5, -2.0], [1.5, 2.0, 1.0]])
PERSPECTIVE = Camera(position=(0.5, 1.0, 5.0), target=(0.2, 0.3, 0.0), fov=50.0, near=0.1)
ORTHOGRAPHIC = Camera(kind="orthographic", position=(0.5, 1.0, 5.0), target=(0.2, 0.3, 0.0), height=4.0, near=0.1)
CAMERAS = pytest.mark.parametrize("camera", [PERSPECTIVE, ORTHOGRAPHIC], ids=["perspective", "orthographic"])


def exact(view: View, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Pixels (n, 2) and depth (n,) in float64."""
    v = np.asarray(points, np.float64) - view.eye
    z = v @ view.forward
    scale = view.focal / z if view.perspective else np.full(len(v), view.focal)
    return np.stack([view.width / 2 + scale * (v @ view.right), view.height / 2 - scale * (v @ view.up)], 1), z


def screen_of(view: View, *strands: np.ndarray) -> np.ndarray:
    """(vertices, 3) as the kernel projects polylines."""
    first = np.cumsum([0, *map(len, strands)])
    world = np.concatenate(strands).astype(np.float32).reshape(-1, 3)
    return to_screen(Polylines(first, world), view, Scratch()).copy()


@settings(max_examples=100, deadline=None)
@given(VECTORS, VECTORS)
def test_axes_are_orthonormal_and_right_handed_even_along_up(forward: tuple[float, ...], up: tuple[float, ...]) -> None:
    for second in (up, forward, tuple(-x for x in forward)):
        right, above, ahead = axes(forward, second)
        frame = np.stack([right, above, ahead])
        np.testing.assert_allclose(frame @ frame.T, np.eye(3), atol=1e-7)
        np.testing.assert_allclose(np.cross(right, above), -ahead, atol=1e-7)
        np.testing.assert_allclose(ahead, np.array(forward) / np.linalg.norm(forward), atol=1e-12)
        assert above @ np.array(second) >= -1e-6 * np.linalg.norm(second)


@CAMERAS
def test_what_is_looked_at_is_in_the_middle_and_up_is_up(camera: Camera) -> None:
    view = camera_view(camera, 0.0, 400, 300, BOX)
    target = np.array(camera.target)
    (middle, above, aside), _ = exact(view, np.stack([target, target + 0.1 * view.up, target + 0.1 * view.right]))
    np.testing.assert_allclose(middle, [200, 150], atol=1e-9)
    assert above[1] < 150
    assert above[0] == pytest.approx(200)
    assert aside[0] > 200
    assert view.up[1] > 0.5
    assert view.right @ np.array(camera.up) == pytest.approx(0, abs=1e-12)


def test_the_field_of_view_is_vertical_and_the_height_is_the_pictures() -> None:
    for size in ((400, 300), (100, 900)):
        view = camera_view(PERSPECTIVE, 0.0, *size, BOX)
        rim = view.eye + 3 * (view.forward + np.tan(np.radians(25)) * view.up)
        assert exact(view, rim[None])[0][0, 1] == pytest.approx(0, abs=1e-9)
        view = camera_view(ORTHOGRAPHIC, 0.0, *size, BOX)
        assert exact(view, (view.eye + 2 * view.up + view.forward)[None])[0][0, 1] == pytest.approx(0, abs=1e-9)


def test_camera_keys_move_the_view() -> None:
    camera = Camera(keys=(CameraKey(time=0.0), CameraKey(time=1.0, position=(4.0, 0.0, 0.0), fov=20.0)))
    start, end = camera_view(camera, 0.0, 64, 48, BOX), camera_view(camera, 1.0, 64, 48, BOX)
    np.testing.assert_allclose(start.eye, [0, 0, 5])
    np.testing.assert_allclose(end.eye, [4, 0, 0])
    np.testing.assert_allclose(end.forward, [-1, 0, 0], atol=1e-12)
    assert end.focal == pytest.approx(24 / np.tan(np.radians(10)))


@CAMERAS
def test_vertices_are_projected_as_in_double_precision(camera: Camera) -> None:
    view = camera_view(camera, 0.0, 400, 300, BOX)
    points = np.random.default_rng(1).uniform(-2, 2, (500, 3))
    screen = screen_of(view, points)
    pixels, z = exact(view, points.astype(np.float32))
    np.testing.assert_allclose(screen[:, :2], pixels, atol=2e-3)
    depth = 1 / z if view.perspective else 1 - (z - view.near) / (view.far - view.near)
    np.testing.assert_allclose(screen[:, 2], depth, rtol=1e-5, atol=1e-6)
    order = np.argsort(z)
    assert (np.diff(screen[order, 2]) <= 1e-6).all()  # nearer is greater


@CAMERAS
def test_a_piece_that_crosses_the_near_plane_is_clipped_there(camera: Camera) -> None:
    view = camera_view(camera, 0.0, 400, 300, BOX)
    ahead = view.eye + 0.5 * view.forward + 0.02 * view.right
    behind = view.eye - 0.8 * view.forward + 0.05 * view.up
    share = (0.5 - view.near) / (0.5 + 0.8)
    crossing = exact(view, (ahead + share * (behind - ahead))[None])[0][0]
    for line in (np.stack([ahead, behind]), np.stack([behind, ahead])):
        screen = screen_of(view, line)
        place = int(line[0] is not ahead and np.allclose(line[0], ahead))
        np.testing.assert_allclose(screen[place, :2], crossing, rtol=1e-4)
        assert screen[place, 2] == pytest.approx(1 / view.near if view.perspective else 1.0, rel=1e-5)
    # with no neighbour in front a vertex is marked as not seen
    screen = screen_of(view, np.stack([behind, behind - view.forward, behind]), np.stack([ahead, ahead]))
    assert (screen[:3, 2] == 0).all()
    assert (screen[3:, 2] > 0).all()


@settings(max_examples=100, deadline=None)
@given(
    st.lists(st.tuples(*[COORDINATES] * 3), min_size=1, max_size=5),
    st.sampled_from([PERSPECTIVE, ORTHOGRAPHIC]),
)
def test_no_coordinate_gives_anything_but_numbers(points: list[tuple[float, float, float]], camera: Camera) -> None:
    view = camera_view(camera, 0.0, 400, 300, BOX)
    screen = screen_of(view, np.array(points))
    assert np.isfinite(screen).all()
    assert (np.abs(screen[:, :2]) <= 1e8).all()
    assert (screen[:, 2] >= 0).all()


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
def test_an_orthographic_camera_tells_depths_apart_at_every_scale(scale: float) -> None:
    """A thousandth of the scene's size is enough to be in front."""
    place = (0.0, 0.0, 5 * scale)
    camera = Camera(kind="orthographic", position=place, height=3 * scale, near=0.01 * scale)
    view = camera_view(camera, 0.0, 64, 48, np.array([[-1, -1, -1], [1, 1, 1]]) * scale)
    screen = screen_of(view, np.array([[0, 0, z * scale] for z in (-0.9, -0.001, 0.0, 0.001, 0.9)]))
    assert (np.diff(screen[:, 2]) > 0).all()


@settings(max_examples=60, deadline=None)
@given(VECTORS, st.tuples(*[st.floats(0.01, 100)] * 3), VECTORS, st.sampled_from([1, 2, 16, 512]))
def test_a_directional_lights_view_just_holds_the_box(
    low: tuple[float, ...], size: tuple[float, ...], direction: tuple[float, ...], texels: int
) -> None:
    box = np.array([low, np.array(low) + size])
    view = parallel_view(direction, texels, box)
    corners = np.array(np.meshgrid(*box.T)).reshape(3, -1).T
    pixels, z = exact(view, corners)
    assert (z > 0).all()
    assert (z < view.far).all()
    margin = 1 if texels > 2 else 0
    assert pixels.min() >= margin - 1e-6
    assert pixels.max() <= texels - margin + 1e-6
    # no more room than needed, and that of a thousandth of its half diagonal for a box that is seen end on
    across = max(np.ptp((corners - view.eye) @ axis) for axis in (view.right, view.up)) / 2
    least = 1e-3 * float(np.linalg.norm(box[1] - box[0])) / 2
    if texels == 512:
        assert max(np.ptp(pixels, axis=0)) == pytest.approx(510 * min(across / least, 1), rel=1e-6)


@settings(max_examples=60, deadline=None)
@given(VECTORS, st.floats(0.01, 100), VECTORS)
def test_a_point_lights_views_hold_the_box(low: tuple[float, ...], size: float, place: tuple[float, ...]) -> None:
    """One view from outside; six from inside, so that every way falls into one of them."""
    box = np.array([low, np.array(low) + size])
    centre, radius = ball(box)
    distance = np.linalg.norm(np.array(place) - centre)
    assume(abs(distance / radius - 1.3) > 1e-6)
    views = point_views(place, 64, box)
    assert len(views) == (1 if distance > 1.3 * radius else 6)
    points = np.random.default_rng(0).uniform(box[0], box[1], (200, 3))
    held = np.zeros(200, bool)
    for view in views:
        pixels, z = exact(view, points)
        held |= (z >= view.near) & (z <= view.far) & (pixels >= -1e-6).all(1) & (pixels <= 64 + 1e-6).all(1)
    away = np.linalg.norm(points - np.array(place), axis=1)
    assert (held | (away < 3 * views[0].near)).all()
