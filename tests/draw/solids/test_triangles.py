"""Solids that consist of triangles in the z-buffer: the same keys as when every pixel casts its ray."""

from __future__ import annotations

import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numba
import numpy as np
import pytest
from numpy.typing import NDArray

sys.path.insert(0, str(Path(__file__).parents[2] / "solids"))

import ball_kit
from strand_kit import scene_of
from strandcli.draw import canvas
from strandcli.draw.common.kernels.keys import EMPTY, FIRST, LOW
from strandcli.draw.solids import triangles
from strandcli.draw.solids.kernels import edges, rasterise
from strandcli.draw.solids.kernels import triangles as kernels
from strandcli.draw.solids.solids import frames_of
from strandcli.draw.view.camera import View, camera_view
from strandcli.solids import pack_all

SIZE = 97, 64
SCENE = """
image: {size: [97, 64]}
camera: %s
solids: [{kind: mesh, file: %s, resolution: 16, position: [0.1, 0.2, -0.1], rotation: [20, 35, 50]},
  {kind: sphere, radius: 0.2}, {kind: mesh, file: %s, resolution: 16, position: [-0.4, 0, 0.3]}]
"""
CAMERAS = {
    "near": "{position: [0.7, 0.8, 1.5], target: [0, 0.1, 0], fov: 50}",
    "beside": "{position: [0.3, 0.55, 0.45], target: [-0.5, 0.0, -0.3], fov: 100}",
    "within a ball": "{position: [0.3, 0.1, 0.1], target: [-1, 0, 0.5], fov: 70}",
    "far": "{position: [300, -200, 500], target: [0, 0.1, 0], fov: 0.15}",
    "orthographic": "{kind: orthographic, height: 1.6, position: [2, 1, 3], target: [0.1, 0, 0]}",
    "orthographic, cut": "{kind: orthographic, height: 1.2, position: [0.1, 0.2, 0.3], target: [0.1, 0, 0]}",
}


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> dict[str, tuple[Path, Path]]:
    """A fine ball and a coarse one, and triangles in all directions, among which slivers and very large ones."""
    folder = tmp_path_factory.mktemp("triangles")
    balls = [ball_kit.write(folder / f"{n}.obj", *ball_kit.ball(n, 0.5)) for n in (5, 1)]
    random = np.random.default_rng(4)
    soups = []
    for n in (30, 400):
        corners = random.uniform(-0.6, 0.6, (n, 1, 3)) + random.normal(size=(n, 3, 3)) * random.uniform(
            0.001, 0.5, (n, 1, 1)
        )
        corners[::3, 2] = corners[::3, 1] + 1e-3 * random.normal(size=corners[::3, 2].shape)
        soups.append(ball_kit.write(folder / f"soup_{n}.obj", corners.reshape(-1, 3), np.arange(3 * n).reshape(-1, 3)))
    return {"balls": (balls[0], balls[1]), "soup": (soups[0], soups[1])}


def of(files: tuple[Path, Path], camera: str) -> tuple[Any, View]:
    """The solids of the scene, and its view."""
    scene = scene_of(SCENE % (CAMERAS[camera], *files))
    bounds = np.array([[-1.0, -1, -1], [1, 1, 1]])
    return pack_all(scene.solids, scene.emitter, 0.0), camera_view(scene.camera, 0.0, *SIZE, bounds)


def by_rays(solids: Any, view: View) -> NDArray[np.uint64]:
    keys = np.empty(SIZE[0] * SIZE[1], np.uint64)
    rasterise.draw(solids, frames_of(solids, view), view.pack(), *SIZE, keys)
    return keys


def by_triangles(solids: Any, view: View, shown: Any = None) -> NDArray[np.uint64]:
    """``shown``: (P,) int32, for the triangles that are in front."""
    keys = np.empty(SIZE[0] * SIZE[1], np.uint64)
    lighting: Any = SimpleNamespace(
        solids=solids, view=view, triangles=np.zeros(0, np.int32) if shown is None else shown
    )
    canvas.clear(keys, SIZE, lighting)
    return keys


@pytest.mark.parametrize("kind", ["balls", "soup"])
@pytest.mark.parametrize("camera", CAMERAS)
def test_keys_are_those_of_rays(files: dict[str, tuple[Path, Path]], kind: str, camera: str) -> None:
    solids, view = of(files[kind], camera)
    for one in (view, view.shifted(0.37, -0.21), view.cropped(11, 7, *SIZE)):
        expected = by_rays(solids, one)
        np.testing.assert_array_equal(by_triangles(solids, one), expected)
        assert (expected != EMPTY).any()


def test_pixels_are_told_the_triangle_that_they_show(files: dict[str, tuple[Path, Path]]) -> None:
    """Its plane is where the ray ends, and of what is no mesh nothing is told."""
    solids, view = of(files["balls"], "near")
    shown = np.full(SIZE[0] * SIZE[1], -1, np.int32)
    keys = by_triangles(solids, view, shown)
    number = np.where(keys == EMPTY, -1, (keys & LOW).astype(np.int64) - int(FIRST))
    assert ((shown >= 0) == (number >= 1)).all()  # the sphere is number 0
    depths = np.empty(len(keys), np.float32)
    edges.depths(keys, depths)
    for surface in triangles.surfaces(solids, view):
        here = np.flatnonzero(number == surface.number)
        assert len(here) > 50
        turn = surface.row[3:12].reshape(3, 3).astype(float)
        corners = surface.corners[shown[here]] @ turn.T + surface.row[:3]
        x, y = here % SIZE[0] + 0.5 - view.middle[0], view.middle[1] - here // SIZE[0] - 0.5
        ways = view.forward + (x[:, None] * view.right + y[:, None] * view.up) / view.focal
        off = view.eye + ways / depths[here, None] - corners[:, 0]
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        normals /= np.linalg.norm(normals, axis=1)[:, None]
        assert np.abs((off * normals).sum(1)).max() < 1e-5


def test_an_eye_inside_sees_nothing_of_a_closed_mesh(files: dict[str, tuple[Path, Path]]) -> None:
    solids, view = of(files["balls"], "within a ball")
    assert [one.number for one in triangles.surfaces(solids, view)] == [2]
    assert len(triangles.surfaces(*of(files["balls"], "near"))) == 2
    np.testing.assert_array_equal(by_triangles(solids, view), by_rays(solids, view))


def test_bits_do_not_depend_on_threads(files: dict[str, tuple[Path, Path]]) -> None:
    solids, view = of(files["soup"], "near")
    before = numba.get_num_threads()
    try:
        found = []
        for threads in (1, 2):
            numba.set_num_threads(min(threads, numba.config.NUMBA_NUM_THREADS))  # type: ignore[attr-defined]
            found.append(by_triangles(solids, view))
    finally:
        numba.set_num_threads(before)
    np.testing.assert_array_equal(found[1], found[0])


def test_few_pixels_are_asked_in_vain(files: dict[str, tuple[Path, Path]]) -> None:
    """The pixels in the spans of the fine ball's triangles are about as many as it shows, front and back."""
    solids, view = of(files["balls"], "near")
    surface = triangles.surfaces(solids, view)[0]
    frame = frames_of(solids, view)[surface.number]
    count = len(surface.corners)
    spans = kernels.Spans(np.empty((count, 4), np.int32), np.empty(count, np.float32), np.empty(count, np.uint8))
    rays = triangles._rays(surface.row, frame, view)
    kernels.bound(surface.corners, rays, view.pack(), frame, spans)
    left, right, top, bottom = spans.box.T.astype(int)
    area = np.maximum(right - left, 0) * np.maximum(bottom - top, 0)
    shown = np.count_nonzero(by_rays(solids, view) != EMPTY)
    assert 0.4 < spans.turned.mean() < 0.65
    assert area.sum() < 4 * shown
    assert rays.off * view.focal < 0.02
