"""Cameras of other programs: what is written is read again as the same projection, and agrees with the formats' own
formulas, written out here a second time."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from camera_kit import POINTS, VIEWS, view
from strandcli.cameras import colmap, transforms
from strandcli.cameras.pinhole import Pinhole, from_dict, of_camera, to_camera
from strandcli.cameras.read import views_of
from strandcli.draw.view.camera import camera_view
from strandcli.errors import UsageError


def write(path: Path, kind: str, views: list[Pinhole]) -> Path:
    """The views as a file or folder of a kind."""
    path.mkdir(parents=True, exist_ok=True)
    if kind == "colmap":
        folder = path / "sparse" / "0"
        folder.mkdir(parents=True)
        for name, data in colmap.written(views, POINTS).items():
            (folder / name).write_bytes(data)
        return path
    if kind == "neus":
        file = path / "cameras.npz"
        file.write_bytes(transforms.neus_written(views, np.zeros(3), 1.0))
        return file
    file = path / "transforms.json"
    file.write_text(json.dumps(transforms.written(views, {"file_path": "images/{}.png"}, "1")))
    return file


@pytest.mark.parametrize("kind", ["colmap", "nerfstudio"])
@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 10_000))
def test_views_written_are_read_as_the_same_projection(
    kind: str, seed: int, tmp_path_factory: pytest.TempPathFactory
) -> None:
    views = [view(seed), view(seed + 1)]
    found = views_of(write(tmp_path_factory.mktemp("views"), kind, views))
    assert found.own
    assert not found.notes
    for before, after in zip(views, found.views, strict=True):
        assert (after.width, after.height) == (64, 48)
        assert after.name == before.name
        assert np.abs(before.project(POINTS) - after.project(POINTS)).max() < 1e-6


@pytest.mark.parametrize("perspective", [True, False])
def test_a_scene_camera_is_the_view_and_draws_as_it_projects(perspective: bool) -> None:
    for seed in range(20):
        given_view = view(seed, perspective)
        camera = to_camera(given_view, 0.01)
        drawn = camera_view(camera, 0.0, 64, 48, np.array([[-1.0, -1, -1], [1, 1, 1]]))
        here = POINTS - drawn.eye
        x, y, z = here @ drawn.right, here @ drawn.up, here @ drawn.forward
        scale = drawn.focal / (z if perspective else 1)
        seen = np.stack([drawn.middle[0] + scale * x, drawn.middle[1] - scale * y], 1)
        assert np.abs(seen - given_view.project(POINTS)).max() < 1e-6
        assert np.abs(of_camera(camera, "a", 64, 48).project(POINTS) - seen).max() < 1e-6
        again = from_dict(json.loads(json.dumps(given_view.as_dict())))
        assert (again.project(POINTS) == given_view.project(POINTS)).all()


def test_colmap_projects_by_its_own_formulas(tmp_path: Path) -> None:
    path = write(tmp_path, "colmap", VIEWS) / "sparse" / "0"
    cameras = {line.split()[0]: line.split() for line in (path / "cameras.txt").read_text().splitlines()[3:]}
    lines = (path / "images.txt").read_text().splitlines()[4:]
    assert len(lines) == 2 * len(VIEWS)
    for before, line in zip(VIEWS, lines[::2], strict=True):
        _, *numbers, camera, name = line.split()
        w, x, y, z, *shift = (float(one) for one in numbers)
        assert name == f"{before.name}.png"
        _, model, width, height, fx, fy, cx, cy = cameras[camera]
        assert (model, width, height) == ("PINHOLE", "64", "48")
        # Hamilton's product q p q*
        u = np.array([x, y, z])
        turned = POINTS + 2 * np.cross(u, np.cross(u, POINTS) + w * POINTS)
        here = turned + shift
        seen = np.stack(
            [float(fx) * here[:, 0] / here[:, 2] + float(cx), float(fy) * here[:, 1] / here[:, 2] + float(cy)], 1
        )
        assert np.abs(seen - before.project(POINTS)).max() < 1e-6
    assert len((path / "points3D.txt").read_text().splitlines()) == 3 + len(POINTS)


def test_neus_projects_to_pixels_whose_middles_are_whole_numbers(tmp_path: Path) -> None:
    arrays = np.load(write(tmp_path, "neus", VIEWS))
    ball = arrays["scale_mat_3"]
    assert (ball == np.eye(4)).all()
    for number, before in enumerate(VIEWS):
        assert (arrays["arr_0"][number] == arrays[f"world_mat_{number}"]).all()
        seen = np.c_[POINTS, np.ones(50)] @ arrays[f"world_mat_{number}"].T
        assert np.abs(seen[:, :2] / seen[:, 2:3] + 0.5 - before.project(POINTS)).max() < 1e-6


def test_nerfstudio_has_opengl_cameras_and_z_up(tmp_path: Path) -> None:
    data = json.loads(write(tmp_path, "nerfstudio", VIEWS).read_text())
    world = np.stack([POINTS[:, 0], -POINTS[:, 2], POINTS[:, 1]], 1)  # y up becomes z up
    for before, frame in zip(VIEWS, data["frames"], strict=True):
        inverse = np.linalg.inv(np.array(frame["transform_matrix"]))
        x, y, z, _ = inverse @ np.c_[world, np.ones(50)].T
        seen = np.stack([frame["cx"] + frame["fl_x"] * x / -z, frame["cy"] - frame["fl_y"] * y / -z], 1)
        assert np.abs(seen - before.project(POINTS)).max() < 1e-6


def test_files_of_other_programs(tmp_path: Path) -> None:
    """Shared lenses, names with spaces, an angle of view, the world as it stands in the file."""
    folder = tmp_path / "colmap"
    folder.mkdir()
    (folder / "cameras.txt").write_text("# a\n1 SIMPLE_RADIAL 100 50 200 50 25 0\n7 PINHOLE 100 50 200 201 51 25\n")
    (folder / "images.txt").write_text("# a\n2 1 0 0 0 0 0 4 7 b c.jpg\n1 2 3\n1 1 0 0 0 1 0 4 1 a.jpg\n\n")
    found = views_of(folder)
    assert not found.own
    assert [one.name for one in found.views] == ["a", "b c"]
    first, second = found.views
    assert first.project([[0.0, 1, 0]]).tolist() == [[50 + 200 / 4, 25 + 200 / 4]]
    assert (second.focal, second.centre) == (200.5, (51.0, 25.0))
    assert "0.12 px off" in found.notes[0]
    path = tmp_path / "transforms.json"
    entry = {"file_path": "./train/r_1", "transform_matrix": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 4], [0, 0, 0, 1]]}
    path.write_text(json.dumps({"camera_angle_x": 2 * np.arctan(0.5), "frames": [entry]}))
    with pytest.raises(UsageError, match="add --size"):
        views_of(path)
    (only,) = views_of(path, (100, 100)).views
    assert only.focal == pytest.approx(100)
    assert np.allclose(only.project([[0, 1, 0]]), [[50, 25]])


def _json(**changes: Any) -> str:
    entry = {"file_path": "a.png", "transform_matrix": np.eye(4).tolist()}
    return json.dumps({"fl_x": 100, "w": 64, "h": 48, "frames": [entry], **changes})


ANGLE = json.dumps({"w": 64, "h": 48, "frames": [{"file_path": "a.png", "transform_matrix": np.eye(4).tolist()}]})
"""A file whose lens is told by `camera_angle_x`, which is left out."""


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (_json(k1=0.1), "lens distortion (k1 0.1)"),
        (_json(camera_model="OPENCV_FISHEYE"), "is no pinhole"),
        (_json(frames=[]), "has no view"),
        (_json(fl_x=0), "must be above 0"),
        (_json(frames=[{"file_path": "a"}]), "has no transform_matrix"),
        (_json(frames=[{"transform_matrix": [[1, 0], [0]]}]), "transform_matrix: is no matrix (4, 4) of finite"),
        (_json(frames=[{"transform_matrix": (2 * np.eye(4)).tolist()}]), "is no rotation"),
        (_json(frames=[{"transform_matrix": np.diag([1, 1, -1, 1]).tolist()}]), "mirrors"),
        (_json(fl_x=None, frames=[{"file_path": "9" * 5000, "transform_matrix": [[10**400]]}]), "frames[0]"),
        (_json(w=10**30), "too large"),
        (json.dumps({**json.loads(ANGLE), "camera_angle_x": 0}), "camera_angle_x 0 is no angle of view"),
        ("[1, 2", "is no JSON"),
    ],
)
def test_damaged_transforms_are_refused_in_one_line(text: str, words: str, tmp_path: Path) -> None:
    path = tmp_path / "transforms.json"
    path.write_text(text)
    with pytest.raises(UsageError, match=str(path)) as error:
        views_of(path)
    assert words in str(error.value)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("cameras", "images", "words"),
    [
        ("1 OPENCV 10 10 9 9 5 5 .1 0 0 0", "1 1 0 0 0 0 0 4 1 a.png", "k1 0.1"),
        ("1 P\x01N 10 10 9 9 5 5", "", "model P\\x01N is no pinhole"),
        ("1 PINHOLE inf 10 9 9 5 5", "", "infx10"),
        ("1 PINHOLE 10 10 9 9 5 5", "1 1 0 0 0 0 0 4 2 a.png", "is no picture"),
        ("1 PINHOLE 10 10 9 9 5 5", "1 1 0 0 0 nan 0 4 1 a.png", "is no picture"),
        ("1 PINHOLE 10 10 9 9 5 5", "", "has no picture"),
    ],
)
def test_damaged_colmap_files_are_refused_in_one_line(cameras: str, images: str, words: str, tmp_path: Path) -> None:
    (tmp_path / "cameras.txt").write_text(cameras + "\n")
    (tmp_path / "images.txt").write_text(images + "\n")
    with pytest.raises(UsageError, match=str(tmp_path)) as error:
        views_of(tmp_path)
    assert words in str(error.value)


@pytest.mark.parametrize(
    "changes",
    [
        {"width": 0}, {"width": 10**30}, {"near": -1}, {"centre": [float("inf"), 1]}, {"eye": [10**400, 0, 0]},
    ],
)  # fmt: skip
def test_views_that_cannot_be_drawn_are_refused(changes: dict[str, Any], tmp_path: Path) -> None:
    path = tmp_path / "dataset.json"
    damaged = {**VIEWS[1].as_dict(), **changes}
    path.write_text(json.dumps({"views": [{"camera": VIEWS[0].as_dict()}, {"camera": damaged}]}))
    with pytest.raises(UsageError, match=str(path)) as error:
        views_of(path)
    assert "\n" not in str(error.value)


@pytest.mark.filterwarnings("error")
def test_unknown_files_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "cameras.npz"
    path.write_bytes(b"PK\3\4 nothing")
    (tmp_path / "views.usda").write_text("#usda 1.0")
    (tmp_path / "empty").mkdir()
    for one in (path, tmp_path / "absent.json", tmp_path / "empty", tmp_path / "views.usda"):
        with pytest.raises(UsageError, match=str(one)):
            views_of(one, (10, 10))
