"""A data set as a whole: views by chance, taking it up again, cameras out and in, and what is refused."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import dataset_kit as kit
import groom_file_kit
from cli_runs import Runner
from strandcli.cameras.pinhole import from_dict
from strandcli.cameras.read import views_of
from strandcli.dataset.run import Talk
from strandcli.dataset.views import Chance
from strandcli.draw.renderer import Renderer
from strandcli.errors import UsageError

BY_CHANCE: dict[str, Any] = {
    "light": "view", "colour": "view", "azimuth": (-180, 180), "elevation": (-10, 40), "size": (32, 32),
    "scene": {"material.width": 0.1},
}  # fmt: skip


@pytest.fixture(scope="module")
def groom(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return groom_file_kit.write(tmp_path_factory.mktemp("groom") / "some.data", groom_file_kit.hanging([12] * 60))


def contents(folder: Path) -> dict[str, bytes]:
    """The files of single views, but for what tells of time."""
    return {
        str(path.relative_to(folder)): path.read_bytes()
        for path in sorted(folder.rglob("*"))
        if path.is_file() and not path.is_symlink() and path.suffix not in (".json", ".usda")
    }


def test_views_depend_on_the_seed_and_their_number_alone(groom: Path, tmp_path: Path) -> None:
    kit.run(kit.order(groom, tmp_path / "five", "hairstep", range(5), **BY_CHANCE))
    kit.run(kit.order(groom, tmp_path / "third", "hairstep", [3], **BY_CHANCE))
    kit.run(kit.order(groom, tmp_path / "other", "hairstep", [3], seed=2, **BY_CHANCE))
    five, third, other = (contents(tmp_path / name) for name in ("five", "third", "other"))
    assert all(five[name] == data for name, data in third.items())
    assert len(third) == 6
    assert other["img/0003.png"] != third["img/0003.png"]
    entries = kit.manifest(tmp_path / "five")["views"]
    assert [one["view"] for one in entries] == list(range(5))
    assert len({one["colour"]["grey"] + one["light"]["ambient"][0] for one in entries}) == 5
    assert all(0.05 < one["hair_share"] < 0.9 for one in entries)
    forward = np.array([one["camera"]["rotation"][2] for one in entries])
    assert (forward @ forward.T - np.eye(5)).max() < 0.99  # all from other sides


def test_a_set_of_one_light_has_it_in_every_view(groom: Path, tmp_path: Path) -> None:
    kit.run(kit.order(groom, tmp_path, "nerfstudio", range(3), **{**BY_CHANCE, "light": "set", "colour": "set"}))
    first, *rest = kit.manifest(tmp_path)["views"]
    for one in rest:
        assert one["light"] == first["light"]
        assert one["colour"] == first["colour"]
        assert one["camera"]["focal"] == first["camera"]["focal"]
        assert one["camera"]["eye"] != first["camera"]["eye"]


@pytest.mark.parametrize("mode", ["off", "adaptive"])
def test_shadows_that_stay_are_drawn_once_and_change_no_view(
    mode: str, groom: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """They stay where light does, and where strands are the same lines from every side."""
    filled = []
    fill = Renderer._fill_maps
    monkeypatch.setattr(Renderer, "_fill_maps", lambda self, *rest: (filled.append(1), fill(self, *rest)))
    look = {**BY_CHANCE, "light": "set", "colour": "set", "scene": {"material.width": 0.1, "curves.mode": mode}}
    kit.run(kit.order(groom, tmp_path / "all", "nerfstudio", range(4), **look))
    assert len(filled) == (1 if mode == "off" else 4)
    kit.run(kit.order(groom, tmp_path / "last", "nerfstudio", [3], **look))
    whole, last = contents(tmp_path / "all"), contents(tmp_path / "last")
    assert len(last) == 4
    assert all(whole[name] == data for name, data in last.items())


def test_directions_are_spread_and_within_bounds() -> None:
    from strandcli.scene.model import Camera

    chance = Chance(3, "a", azimuth=(-90, 90), elevation=(0, 45))
    base = Camera(position=(2.0, 1.0, 0.0), target=(0.0, 0.0, 0.0))  # to the right of the origin: azimuth 90
    found = np.array([chance.direction(view, base)[0] for view in range(64)])
    assert np.abs(np.linalg.norm(found, axis=1) - 1).max() < 1e-12
    assert (found[:, 1] >= 0).all()
    assert (found[:, 1] <= np.sin(np.pi / 4)).all()
    assert (found[:, 0] >= -1e-9).all()  # half a turn about the scene's own camera
    gap = np.sort(found[:, 1])
    assert np.diff(gap).max() < 0.05


def test_a_set_is_taken_up_again(groom: Path, tmp_path: Path) -> None:
    """A run that is stopped leaves whole views; the rest are made, and what is there is kept."""
    kit.run(kit.order(groom, tmp_path / "whole", "nerfstudio", range(4), **BY_CHANCE))
    part = tmp_path / "part"
    asked = kit.order(groom, part, "nerfstudio", range(4), **BY_CHANCE)

    def stop(text: str) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        kit.run(asked, Talk(step=stop))
    before = [one["view"] for one in kit.manifest(part)["views"]]
    assert before
    assert before[0] == 0
    assert len(before) < 4
    assert len(json.loads((part / "transforms.json").read_text())["frames"]) == len(before)
    (part / "depths" / "0000.npy").unlink()  # a view that lacks a file is made again
    drawn: list[str] = []
    with pytest.raises(UsageError, match="add --overwrite to replace or --resume"):
        kit.run(asked)
    data = kit.run(replace(asked, resume=True), Talk(step=drawn.append))
    assert [one["view"] for one in data["views"]] == list(range(4))
    assert len(drawn) == 4 - len(before) + 1
    assert contents(part) == contents(tmp_path / "whole")
    assert (
        json.loads((part / "transforms.json").read_text())["frames"]
        == json.loads((tmp_path / "whole" / "transforms.json").read_text())["frames"]
    )
    drawn.clear()
    kit.run(replace(asked, resume=True), Talk(step=drawn.append))
    assert not drawn
    more = replace(asked, resume=True, views=range(5))
    assert len(kit.run(more, Talk(step=drawn.append))["views"]) == 5
    assert len(drawn) == 1


def test_other_options_and_another_groom_are_noticed(groom: Path, tmp_path: Path) -> None:
    mine = tmp_path / "mine.data"
    mine.write_bytes(groom.read_bytes())
    asked = kit.order(mine, tmp_path / "set", "nerfstudio", range(2), **BY_CHANCE, resume=True)
    kit.run(asked)
    for other in (
        replace(asked, chance=replace(asked.chance, seed=9)),
        kit.order(mine, tmp_path / "set", "nerfstudio", range(2), **{**BY_CHANCE, "size": (32, 24)}, resume=True),
    ):
        with pytest.raises(UsageError, match="another groom, version or options"):
            kit.run(other)
    groom_file_kit.write(mine, groom_file_kit.hanging([12] * 60, seed=2))
    with pytest.raises(UsageError, match="another groom, version or options"):
        kit.run(asked)
    kit.run(replace(asked, resume=False, overwrite=True))


def test_cameras_written_are_read_as_the_same_views(groom: Path, tmp_path: Path) -> None:
    """To 1e-6 pixels, and with them the same pictures."""
    kit.run(kit.order(groom, tmp_path / "a", "hairstep", range(2), **{**BY_CHANCE, "light": "scene"}))
    path = tmp_path / "a"
    found = views_of(path)
    assert found.own
    points = np.random.default_rng(2).uniform(-1, 1, (30, 3))
    entries = json.loads((path / "dataset.json").read_text())["views"]
    for view, entry in zip(found.views, entries, strict=True):
        assert np.abs(view.project(points) - from_dict(entry["camera"]).project(points)).max() < 1e-6
    again = kit.order(groom, tmp_path / "b", "hairstep", range(2), **{**BY_CHANCE, "light": "scene"})
    kit.run(replace(again, places=found.views))
    a, b = (contents(tmp_path / name) for name in "ab")
    for name in a:
        if name.endswith(".png"):
            one, other = (kit.picture(tmp_path / part / name).astype(int) for part in "ab")
            assert np.mean(np.abs(one - other) > 2) < 0.01, name
    assert a.keys() == b.keys()


def _views(folder: Path, groom: Path) -> Path:
    kit.run(kit.order(groom, folder, "nerfstudio", range(2), **BY_CHANCE))
    return folder / "transforms.json"


def test_the_command(groom: Path, tmp_path: Path, run: Runner) -> None:
    small = ("--set", "lights.0.shadow.size=64", "--set", "ambient_occlusion=null", "--size", "32x32")
    other = groom.with_name("other.data")
    other.write_bytes(groom.read_bytes())
    result = run.fine(
        "dataset", groom, other, "--layout", "nerfstudio", "--views", 2, "-o", tmp_path / "set", "--json", *small
    )
    first, second = json.loads(result.out)
    assert [len(one["views"]) for one in (first, second)] == [2, 2]
    assert (tmp_path / "set" / "some" / "transforms.json").exists()
    assert (tmp_path / "set" / "other" / "images" / "0001.png").exists()
    assert first["views"][0]["camera"]["eye"] != second["views"][0]["camera"]["eye"]
    # cameras of its own: in metres, so the groom is placed as before; those of others: where the file has it
    cameras = tmp_path / "set" / "some" / "transforms.json"
    run.fine("dataset", groom, "--layout", "neuralhaircut", "--cameras", cameras, "-o", tmp_path / "n", *small[:-2])
    assert [one["camera"] for one in kit.manifest(tmp_path / "n")["views"]] == [one["camera"] for one in first["views"]]
    data = json.loads(cameras.read_text())
    del data["strandcli"]
    cameras.write_text(json.dumps(data))
    run.fine("dataset", groom, "--layout", "nerfstudio", "--cameras", cameras, "-o", tmp_path / "f", *small[:-2])


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--layout", "hairstop"], "layouts are hairstep,"),
        (["absent.hair", "--layout", "nerfstudio", "--views", "1"], "absent.hair: there is no such file"),
        (["--layout", "hairstep", "--size", "64x48"], "square pictures alone"),
        (["--layout", "hairstep", "--cameras", "CAMERAS"], "has orthographic views alone"),
        (["--layout", "nerfstudio", "--cameras", "CAMERAS", "--views", "9"], "holds 2 views, 9 are asked for"),
        (["--layout", "nerfstudio", "--elevation", "40,10"], "the lesser first"),
        (["--layout", "nerfstudio", "--frame", "7"], "the preset has 1 frames"),
        (["--layout", "nerfstudio", "--set", "image.background=none"], "masks beside its pictures, not alpha"),
    ],
)
def test_what_is_refused(arguments: list[str], words: str, groom: Path, tmp_path: Path, run: Runner) -> None:
    given = [str(_views(tmp_path / "v", groom)) if one == "CAMERAS" else one for one in arguments]
    assert words in run.refused("dataset", groom, "-o", tmp_path / "out", *given)
    assert not (tmp_path / "out").exists()


def test_off_middle_views_are_refused_where_they_would_be_misread(groom: Path, tmp_path: Path, run: Runner) -> None:
    path = _views(tmp_path / "v", groom)
    data = json.loads(path.read_text())
    data["frames"][1]["cx"] += 0.25
    path.write_text(json.dumps(data))
    command = ("dataset", groom, "-o", tmp_path / "o", "--layout", "gaussianhaircut", "--cameras", path)
    assert "0.25 pixels off the middle" in run.refused(*command)
    assert "no.hair" in run.refused("dataset", "no.hair", "-o", tmp_path / "o", "--layout", "hairstep")
