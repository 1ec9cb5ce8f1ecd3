"""A film whose frames are the views of a file: `camera.file` and `render --cameras`."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import dataset_kit as kit
import groom_file_kit
import strandcli
from cli_runs import Runner
from strandcli.cameras import colmap
from strandcli.cameras.pinhole import UP, Pinhole, above, upright
from strandcli.cameras.read import views_of
from strandcli.errors import UsageError

SMALL = ("--set", "lights.0.shadow.size=64", "--set", "ambient_occlusion=null", "--no-progress")


@pytest.fixture(scope="module")
def groom(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Strands about (7, 0, 3) in their file."""
    strands = [one + np.float32([7, 0, 3]) for one in groom_file_kit.hanging([12] * 40)]
    return groom_file_kit.write(tmp_path_factory.mktemp("groom") / "some.data", strands)


def test_a_film_has_the_views_of_a_data_set(groom: Path, tmp_path: Path, run: Runner) -> None:
    made = tmp_path / "set"
    run.fine(
        "dataset", groom, "--layout", "nerfstudio", "--views", 3, "--light", "scene", "--colour", "scene", "--size",
        "40x32", "-o", made, *SMALL,
    )  # fmt: skip
    run.fine("render", groom, "--cameras", made / "transforms.json", "-o", tmp_path / "film", *SMALL)
    for number in range(3):
        a, b = (
            np.array(Image.open(path)).astype(int)
            for path in (made / "images" / f"{number:04d}.png", tmp_path / "film" / f"frame_{number + 1:04d}.png")
        )
        assert a.shape == b.shape == (32, 40, 3)
        assert a.std() > 5
        assert np.mean(np.abs(a - b) > 3) < 0.01
    assert not (tmp_path / "film" / "frame_0004.png").exists()


def test_cameras_of_others_see_strands_where_their_file_has_them(groom: Path, tmp_path: Path, run: Runner) -> None:
    look = np.array([[1.0, 0, 0], [0, -1, 0], [0, 0, -1]])  # from +z, y down
    view = Pinhole("a", 48, 48, 40.0, (24.0, 24.0), look, np.array([7.0, 0.0, 9.0]))
    for name, data in colmap.written([view], np.zeros((1, 3))).items():
        (tmp_path / name).write_bytes(data.replace(b"(strandcli)", b""))
    assert not views_of(tmp_path).own
    run.fine("render", groom, "--cameras", tmp_path, "-o", tmp_path / "o", "--aov", "mask", *SMALL)
    mask = np.load(tmp_path / "o" / "mask_0001.npz")["mask"]
    strands = groom_file_kit.hanging([12] * 40)
    places = view.project(np.concatenate(strands) + np.array([7, 0, 3]))
    rows, columns = np.nonzero(mask > 0.02)
    assert len(rows) > 100
    assert abs(columns.mean() + 0.5 - places[:, 0].mean()) < 3
    assert abs(rows.mean() + 0.5 - places[:, 1].mean()) < 3
    assert np.ptp(places[:, 0]) == pytest.approx(np.ptp(columns), abs=4)


def test_a_preset_names_a_file_of_cameras(tmp_path: Path) -> None:
    views = [np.eye(4), np.eye(4)]
    views[1][0, 3] = 0.5
    frames = [{"file_path": f"{k}.png", "transform_matrix": one.tolist()} for k, one in enumerate(views)]
    for frame in frames:
        frame["transform_matrix"][2][3] = 16.0
    (tmp_path / "views.json").write_text(json.dumps({"fl_x": 120, "w": 40, "h": 30, "frames": frames}))
    text = (
        "time: {frames: 5}\nemitter: {strands: 50, particles: 2, length: 1}\nrules: []\n"
        "camera: {file: views.json, aperture: 0.01, samples: 2}\nimage: {aovs: [mask]}\nlights: []\n"
    )
    (tmp_path / "one.yaml").write_text(text)
    scene = strandcli.load(str(tmp_path / "one.yaml"))
    assert scene.image.size == (40, 30)
    assert scene.time.frames == 5
    assert [one.position for one in scene.camera.views] == [(0, 0, 16), (0.5, 0, 16)]
    assert scene.camera.views[1].aperture == 0.01
    first, second, third = (one.aovs["mask"] for one in strandcli.render(scene, [1, 2, 3]))
    assert (second == third).all()  # the last view stays
    a, b = (np.nonzero(one > 0)[1].mean() for one in (first, second))
    assert a - b == pytest.approx(120 * 0.5 / 16, abs=0.5)  # the camera goes right, strands go left
    (tmp_path / "two.yaml").write_text(text.replace("aperture: 0.01", "keys: [{time: 0, position: [0, 0, 3]}]"))
    with pytest.raises(UsageError, match="a camera with keys stands where they say"):
        strandcli.load(str(tmp_path / "two.yaml"))


def test_sizes_that_disagree_are_refused(groom: Path, tmp_path: Path, run: Runner) -> None:
    kit.run(kit.order(groom, tmp_path / "set", "nerfstudio", range(2)))
    path = tmp_path / "set" / "transforms.json"
    command = ("render", groom, "--cameras", path, "-o", tmp_path / "o")
    assert "leave out --size" in run.refused(*command, "--size", "32x32")
    data = json.loads(path.read_text())
    data["frames"][0]["w"] = 60
    path.write_text(json.dumps(data))
    assert "of several sizes" in run.refused(*command)


def test_light_comes_from_above_whatever_is_up_in_the_cameras_world(groom: Path, tmp_path: Path, run: Runner) -> None:
    """Strands and cameras that are turned together have the same pictures."""
    up = (0.6, 0.64, 0.48)
    turn = upright(up)
    assert turn @ UP == pytest.approx(up)
    assert turn @ turn.T == pytest.approx(np.eye(3))
    views = []
    for angle in (0.0, 2.0):
        x, z = np.sin(angle), np.cos(angle)
        look = np.array([[z, 0, -x], [0, -1, 0], [-x, 0, -z]])
        views.append(Pinhole(f"{angle}", 40, 40, 60.0, (20.0, 20.0), look, 4 * np.array([x, 0.0, z])))
    pictures = {}
    for name, how in (("plain", np.eye(3)), ("turned", turn)):
        folder = tmp_path / name
        folder.mkdir()
        strands = [(one @ how.T).astype(np.float32) for one in groom_file_kit.hanging([12] * 40)]
        path = groom_file_kit.write(folder / "some.data", strands)
        moved = [one.moved(how, np.zeros(3)) for one in views]
        for file, data in colmap.written(moved, np.zeros((1, 3))).items():
            (folder / file).write_bytes(data.replace(b"(strandcli)", b""))
        assert above(views_of(folder).views) == pytest.approx(how @ UP)
        run.fine("render", path, "--cameras", folder, "-o", folder / "film", *SMALL)
        more = ("--light", "set", "--colour", "scene", "--layout", "neuralhaircut")
        run.fine("dataset", path, "--cameras", folder, "-o", folder / "set", *more, *SMALL)
        found = [folder / "film" / "frame_0001.png", folder / "film" / "frame_0002.png", folder / "set/image/0001.png"]
        pictures[name] = np.array([np.array(Image.open(one)) for one in found]).astype(int)
    off = np.abs(pictures["plain"] - pictures["turned"]).mean(axis=(1, 2, 3))
    assert (off < 1).all(), off
    assert pictures["plain"].std(axis=(1, 2, 3)).min() > 5


def test_cameras_that_agree_on_no_up_leave_it_as_it_is() -> None:
    looks = [np.diag([1.0, -1, -1]), np.diag([-1.0, 1, -1])]
    assert above([Pinhole("", 8, 8, 8.0, (4, 4), look, np.zeros(3)) for look in looks]) == UP
    assert above([]) == UP
    down = np.array([[1, 0, 0], [0, 0.5, -(0.75**0.5)], [0, 0.75**0.5, 0.5]])  # looks down by 30 degrees, z is up
    assert above([Pinhole("", 8, 8, 8.0, (4, 4), down, np.zeros(3))]) == (0, 0, 1)
    assert upright((0, 0, 1)) == pytest.approx(np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]]))
