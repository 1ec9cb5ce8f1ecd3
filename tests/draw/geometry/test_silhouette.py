"""Where tubes without caps end on the screen, and which places of their side toward the eye are seen, against points on
their surface that are projected one by one."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import yaml

import strandcli
from strandcli.draw.common.scratch import Scratch
from strandcli.draw.coverage import coverage
from strandcli.draw.geometry.curves import Polylines
from strandcli.draw.geometry.kernels import silhouette
from strandcli.draw.shadows.kernels import traced
from strandcli.draw.view.camera import View, axes
from strandcli.draw.zbuffer.raster import to_screen
from strandcli.jit import function
from strandcli.study.axes import Request
from strandcli.study.pictures.settings import changed
from strandcli.study.pictures.subject import Subject

RADIUS = 0.003
VIEWS = ["perspective", "orthographic"]


def seen_from(kind: str) -> View:
    eye, perspective = np.array([0.3, 0.2, 4.0]), kind == "perspective"
    return View(eye, *axes(-eye, (0.0, 1.0, 0.0)), perspective, 900.0 if perspective else 225.0, 0.1, 9.0, 400, 300)


def straight(count: int = 40) -> np.ndarray:
    """(count, 5, 3), slanted by up to 60 degrees from the plane of the view, which looks along z, or nearly."""
    rng = np.random.default_rng(2)
    slant, turn = rng.uniform(-np.pi / 3, np.pi / 3, count), rng.uniform(0, 2 * np.pi, count)
    way = np.stack([np.cos(slant) * np.cos(turn), np.cos(slant) * np.sin(turn), np.sin(slant)], 1)
    begin = rng.uniform(-0.5, 0.5, (count, 1, 3))
    return np.asarray((begin + 0.3 * way[:, None] * np.linspace(0, 1, 5)[:, None]).astype(np.float32), np.float64)


def project(view: View, points: np.ndarray) -> np.ndarray:
    away = points - view.eye
    scale = view.focal / (away @ view.forward if view.perspective else 1.0)
    return np.asarray(np.stack([view.middle[0] + scale * (away @ view.right),
                                view.middle[1] - scale * (away @ view.up)], -1))  # fmt: skip


def toward(view: View, points: np.ndarray) -> np.ndarray:
    """Unit vectors to the eye."""
    way = view.eye - points if view.perspective else np.broadcast_to(-view.forward, points.shape)
    return np.asarray(way / np.linalg.norm(way, axis=-1, keepdims=True))


def surface(line: np.ndarray, at: np.ndarray, eye: np.ndarray, h: np.ndarray) -> np.ndarray:
    """Points about a point of a straight line's axis, on the perpendicular section of the tube, where the eye sees the
    offsets h."""
    t = line[-1] - line[0]
    t /= np.linalg.norm(t)
    b = np.cross(t, eye)
    b /= np.linalg.norm(b)
    n = eye - (eye @ t) * t
    n /= np.linalg.norm(n)
    return np.asarray(at + RADIUS * (h[:, None] * b + np.sqrt(1 - h**2)[:, None] * n))


def moved(view: View, lines: np.ndarray, width: float = 2 * RADIUS, taper: float = 0.0) -> np.ndarray:
    count, n, _ = lines.shape
    flat = Polylines(np.arange(count + 1) * n, lines.reshape(-1, 3).astype(np.float32))
    screen = to_screen(flat, view, Scratch())
    silhouette.move_ends(flat.first, flat.world, view.pack(), np.float32(width), np.float32(taper), None, None, screen)
    return np.asarray(screen.reshape(count, n, 3), np.float64)


@pytest.mark.parametrize("kind", VIEWS)
def test_strands_end_where_the_rim_that_is_seen_does_on_average(kind: str) -> None:
    view, lines = seen_from(kind), straight()
    found = moved(view, lines)
    h = (np.arange(400) + 0.5) / 200 - 1
    for line, screen in zip(lines, found, strict=True):
        middle = project(view, line)
        way = (middle[-1] - middle[0]) / np.linalg.norm(middle[-1] - middle[0])
        for end in (0, -1):
            rim = project(view, surface(line, line[end], toward(view, line[end]), h))
            off = (rim.mean(0) - middle[end]) @ way
            # a point half a radius nearer to the eye is larger by that much, which this leaves out
            assert (screen[end, :2] - middle[end]) @ way == pytest.approx(off, abs=0.01)
            depth = (line[end] - view.eye) @ view.forward
            assert abs(depth * (screen[end, 2] if view.perspective else 1) - (1 if view.perspective else depth)) < 3e-3


@pytest.mark.parametrize("kind", VIEWS)
def test_a_strand_that_points_at_the_eye_ends_before_its_middle_does(kind: str) -> None:
    view = seen_from(kind)
    lines = np.array([[[0, 0, 0], [0.1, 0, 0.1], [0.2, 0, 0.2]], [[0, 0, 0], [0.1, 0, -0.1], [0.2, 0, -0.2]]])
    by = moved(view, lines)[:, -1, 0] - project(view, lines[:, -1])[:, 0]
    assert by[0] < -0.1
    assert by[1] > 0.1


@pytest.mark.parametrize("kind", VIEWS)
def test_ends_are_those_of_the_strand_the_other_way_round(kind: str) -> None:
    view, lines = seen_from(kind), straight()
    np.testing.assert_allclose(moved(view, lines), moved(view, lines[:, ::-1])[:, ::-1], atol=2e-4)


def test_nothing_but_ends_moves_and_they_by_half_a_piece_at_most() -> None:
    view, lines = seen_from("perspective"), straight()
    plain, found = moved(view, lines, 0.0), moved(view, lines, 0.3)
    np.testing.assert_allclose(plain[..., :2], project(view, lines), atol=2e-3)
    np.testing.assert_array_equal(found[:, 1:-1], plain[:, 1:-1])
    np.testing.assert_array_equal(moved(view, lines, 0.3, taper=1.0)[:, -1], plain[:, -1])
    for end, beside in ((0, 1), (-1, -2)):
        most = np.linalg.norm(project(view, 1.5 * lines[:, end] - 0.5 * lines[:, beside]) - plain[:, end, :2], axis=1)
        least = np.linalg.norm(project(view, (lines[:, end] + lines[:, beside]) / 2) - plain[:, end, :2], axis=1)
        went = np.linalg.norm(found[:, end, :2] - plain[:, end, :2], axis=1)
        assert (went < np.maximum(most, least) + 1e-3).all()
        assert (went > 0).all()


def test_strands_of_one_vertex_or_none_have_no_ends_to_move() -> None:
    view, lines = seen_from("perspective"), straight(2)
    world = np.concatenate([lines[0], lines[1], lines[0, :1]]).astype(np.float32)
    flat = Polylines(np.array([0, 0, 5, 5, 10, 11, 11]), world)
    screen = to_screen(flat, view, Scratch())
    plain = screen.copy()
    silhouette.move_ends(flat.first, flat.world, view.pack(), np.float32(2 * RADIUS), np.float32(0), None, None, screen)
    np.testing.assert_array_equal(screen[:10], moved(view, lines).reshape(-1, 3).astype(np.float32))
    np.testing.assert_array_equal(screen[10], plain[10])


@function
def put_surface(world: Any, radius: Any, h: Any, eye: Any, pair: Any) -> None:
    """Vertex 2 of 4 pieces, into the second row of a pair."""
    traced.surface(world, np.int64(0), np.int64(4), np.int64(2), radius, h, eye, pair, np.int64(1))


@pytest.mark.parametrize("kind", VIEWS)
def test_points_of_a_surface_are_seen_beside_their_middle(kind: str) -> None:
    """Shadows are traced at them, and read at the place along the strand that a sample shows."""
    view, pair = seen_from(kind), np.empty((2, 3), np.float32)
    for line in straight():
        world = line.astype(np.float32)
        t = (line[-1] - line[0]) / np.linalg.norm(line[-1] - line[0])
        middle = project(view, line)
        way = (middle[-1] - middle[0]) / np.linalg.norm(middle[-1] - middle[0])
        for h in (-0.9, 0.0, 0.5):
            put_surface(world, np.float32(RADIUS), np.float32(h), view.pack(), pair)
            point = pair[1].astype(np.float64)
            away = point - line[0]
            assert np.linalg.norm(away - (away @ t) * t) == pytest.approx(RADIUS, rel=2e-3)
            off = project(view, point) - middle[2]
            assert off @ way == pytest.approx(0, abs=0.01)
            aside = off @ np.array([-way[1], way[0]])
            depth = (line[2] - view.eye) @ view.forward if view.perspective else 1.0
            assert aside == pytest.approx(h * RADIUS * view.focal / depth, rel=0.03, abs=1e-3)


SCENE: dict[str, Any] = {
    "emitter": {"shape": {"kind": "disc", "radius": 0.5}, "strands": 150, "particles": 6, "length": 0.9, "jitter": 40},
    "rules": [],
    "camera": {"position": [0, 1.1, 2], "target": [0, 0.3, 0], "fov": 40},
    "image": {"size": [60, 45], "background": [0, 0, 0], "resolver": "sorted", "supersample": 2},
    "ambient": [0, 0, 0],
    "lights": [{"kind": "directional", "direction": [-0.3, -0.5, -0.8], "intensity": 3, "shadow": {"model": "traced"}}],
    "material": {"model": "chiang", "pigment": "brown", "diffuse": 0, "width": 0.05, "taper": 0.4},
    "curves": {"mode": "off"},
}


@pytest.mark.parametrize("settings", [{}, {"material.width": 0.012}, {"material.opacity": 0.6}],
                         ids=["wide", "narrow", "letting light through"])  # fmt: skip
def test_shadows_are_traced_where_they_are_seen_and_no_pixel_knows(
    tmp_path: Any, monkeypatch: pytest.MonkeyPatch, settings: dict[str, Any]
) -> None:
    (tmp_path / "scene.yaml").write_text(yaml.safe_dump(SCENE))
    subject = Subject(Request(strandcli.load(str(tmp_path / "scene.yaml")), "scene", size=(60, 45), strands=150))
    subject.move()
    shares = []
    original = coverage.Layer.shown

    def watched(self: Any, body: Any, scratch: Any) -> Any:
        found = original(self, body, scratch)
        shares.append(np.mean((found[..., None] >> np.arange(64, dtype=np.uint64)) & np.uint64(1)))
        return found

    monkeypatch.setattr(coverage.Layer, "shown", watched)
    found = subject.draw(changed(subject.scene, settings), draws=1).image
    monkeypatch.setattr(coverage.Layer, "shown", lambda self, body, scratch: None)
    whole = subject.draw(changed(subject.scene, settings), draws=1).image
    assert whole.max() > 0.01
    np.testing.assert_allclose(found, whole, atol=2e-5 * float(whole.max()))
    assert 0 < max(shares) < 0.9
