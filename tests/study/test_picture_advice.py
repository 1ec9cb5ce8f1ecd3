"""Windows of a frame, the choice by their errors, and `render --max-error picture=ERROR` on a small groom."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import strandcli
from cli_runs import Runner
from strandcli.errors import MismatchError, UsageError
from strandcli.study import advice, sweep
from strandcli.study.pictures import windows as module
from strandcli.study.pictures.windows import Windows, spread
from strandcli.study.sweep import Request, changed

SMALL = """\
title: a small brush
emitter: {shape: {kind: sphere, radius: 0.3}, strands: 60, particles: 5, length: 0.8, jitter: 20, curl_turns: 0.5}
camera: {position: [0, 0.3, 4], fov: 34}
image: {size: [48, 36], horizon: [0.3, 0.2, 0.1], resolver: sorted}
material: {width: 0.01}
lights: [{kind: directional, direction: [0.3, -1, -0.5], shadow: {size: 64, model: opacity}}]
rules: {elasticity: {}}
"""


@pytest.fixture
def run(run: Runner, monkeypatch: pytest.MonkeyPatch) -> Runner:
    Path("brush.yaml").write_text(SMALL)
    monkeypatch.setattr(advice, "folder", lambda: run.folder / "kept")
    monkeypatch.setattr(module, "SIDE", 12)
    monkeypatch.setattr("strandcli.study.pictures.frame.PATIENCE", 1e9)
    return run


def test_windows_are_tiles_with_strands_in_the_order_of_how_rough_they_are(monkeypatch: pytest.MonkeyPatch) -> None:
    """Tiles of two by two pixels, of which those in the lower rows hold no strands, and one is rougher than the
    next."""
    monkeypatch.setattr(module, "SIDE", 2)
    picture, mask = np.zeros((8, 12, 3)), np.zeros((8, 12), np.float32)
    for tile in range(12):
        row, column = divmod(tile, 6)
        picture[2 * row, 2 * column] = tile
        mask[2 * row + 1, 2 * column] = 0.1
    found, mean, tiles = spread(mask, picture, (100, 10), 3)
    assert tiles == 12
    assert mean == pytest.approx(sum(range(12)) / 4 / 12)
    assert found == [(104, 10, 2, 2), (100, 12, 2, 2), (108, 12, 2, 2)]  # the tiles 2, 6 and 10
    assert len(set(spread(mask, picture, (100, 10), 40)[0])) == 12
    assert spread(0 * mask, picture, (100, 10), 3) == ([], 0.0, 0)


@pytest.mark.parametrize("resolver", ["sorted", "zbuffer"])
def test_windows_are_what_the_whole_picture_has_there(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, resolver: str
) -> None:
    monkeypatch.setattr(module, "SIDE", 12)
    (tmp_path / "brush.yaml").write_text(SMALL)
    scene = strandcli.load(str(tmp_path / "brush.yaml"), overrides=[f"image.resolver={resolver}"])
    subject = Windows(Request(scene=scene, name="brush"))
    subject.move()
    assert len(subject.windows) == 8
    fine = changed(subject.scene, {"curves.mode": "adaptive", "curves.level": 5, "curves.tolerance": 0.05})
    found, whole = subject.draw(fine), subject.draw_whole(fine)
    assert found.pixels is not None
    assert whole.pixels is not None

    def cut(picture: Any) -> Any:
        return [picture[y : y + high, x : x + wide] for x, y, wide, high in subject.windows]

    np.testing.assert_allclose(found.image, np.concatenate(cut(whole.image)), rtol=5e-6)
    seen = np.concatenate(cut(whole.pixels))
    np.testing.assert_array_equal(subject.apart(seen)[2], cut(whole.pixels)[2])
    frame = next(iter(strandcli.render(scene, frames=[1])))
    # light is the same to some 1e-6, for views round otherwise: a value between two levels may fall to either
    for pixels, other in ((found.pixels, seen), (subject.draw_whole(subject.scene).pixels, frame.image)):
        apart = np.abs(np.asarray(pixels).astype(int) - other)
        assert apart.max() <= 1
        assert np.count_nonzero(apart) <= 2


def test_what_a_frame_takes_grows_with_its_pixels() -> None:
    subject = object.__new__(Windows)
    subject._share, subject._own = 10.0, {"raster": (3.0, 0.5), "shadow": (4.0, 2.0)}
    assert subject._of_frame({"raster": 0.7, "shadow": 3.0, "film": 1.0}) == {
        "raster": pytest.approx(5.0), "shadow": pytest.approx(6.0), "film": 1.0
    }  # fmt: skip
    assert subject._of_frame({"raster": 0.25}) == {"raster": pytest.approx(1.5)}


def data(*points: tuple[float | None, float | None, float]) -> dict[str, Any]:
    """A study of points (rmse, flip, seconds)."""
    return {
        "reference": {"what": "a finer one", "windows": [[0, 0, 4, 4]], "width": {}},
        "points": [
            {"parameters": {"image.supersample": n}, "error": {"rmse": rmse, "flip": flip}, "seconds": seconds}
            for n, (rmse, flip, seconds) in enumerate(points, 1)
        ],
    }


def test_the_cheapest_that_keeps_under_all_errors_is_chosen() -> None:
    study = data((0.2, 0.01, 1.0), (0.04, 0.2, 2.0), (0.04, 0.02, 5.0), (0.03, 0.02, 4.0), (None, None, 0.0))

    def chosen(**asked: float) -> int:
        return int(advice.choose_picture(study, True, "a", asked).settings["image.supersample"])

    assert chosen(rmse=0.2) == 1
    assert chosen(rmse=0.1) == 2
    assert chosen(rmse=0.1, flip=0.05) == 4
    assert chosen(flip=0.015) == 1
    report = advice.choose_picture(study, False, "a", {"rmse": 0.1}).report
    assert report["predicted"] == {"rmse": 0.04, "flip": 0.2, "frame": 1, "seconds": 2.0}
    assert report["reference"]["nearest"] == 0.03
    assert report["study"] == {"remembered": False, "untried": 1}


def test_what_is_said_where_nothing_keeps_under_the_error() -> None:
    with pytest.raises(MismatchError) as caught:
        advice.choose_picture(data((0.2, 0.1, 1.0), (0.05, 0.1, 3.0), (None, None, 0.0)), False, "fur", {"rmse": 0.01})
    assert str(caught.value) == (
        "fur: no settings of drawing keep under 1 % of the mean light; the least is 5 % in 3 s a frame (supersample 2)"
    )
    with pytest.raises(MismatchError, match="are black"):
        advice.choose_picture(data((None, None, 1.0)), False, "fur", {"rmse": 0.01})


def test_advice_of_pictures_follows_from_the_scene_and_what_is_fixed() -> None:
    def follows(*overrides: str, fixed: tuple[str, ...] = ()) -> str:
        return json.dumps(advice.picture_of(strandcli.load("minimal", overrides=overrides), fixed), default=str)

    first = follows()
    assert first == follows("image.aovs=depth")
    rest = {follows("material.width=0.005"), follows("rules.gravity.acceleration=[0, -1, 0]")}
    assert len({first, follows(fixed=("image.supersample",)), *rest}) == 4


def test_render_keeps_under_an_error_and_says_how_it_knows(run: Runner, monkeypatch: pytest.MonkeyPatch) -> None:
    few = ("brush.yaml", "-f", "1", "--no-progress")
    first = run.fine("render", *few, "-o", "a", "--max-error", "picture=10%,flip=0.5")
    assert "brush: under picture 10 %, flip 50 %: " in first.err
    assert "by a study" in first.err
    told = json.loads(Path("a/report.json").read_text())["picture_error"]
    assert told["asked"] == {"rmse": 0.1, "flip": 0.5}
    assert 0 < told["predicted"]["rmse"] <= 0.1
    assert told["study"] == {"remembered": False, "untried": 0}

    monkeypatch.setattr(sweep, "run", lambda *arguments: pytest.fail("studied again"))
    assert "by an earlier study" in run.fine("render", *few, "-o", "b", "--max-error", "picture=100%").err
    told = json.loads(Path("b/report.json").read_text())["picture_error"]
    assert told["study"]["remembered"]

    missed = run.refused("render", *few, "-o", "c", "--max-error", "picture=1e-9", code=3)
    assert "no settings of drawing keep under 1e-07 % of the mean light; the least is" in missed
    assert not Path("c").exists()


def test_what_is_set_by_hand_stays(run: Runner) -> None:
    fixed = ("--set", "image.supersample=2", "--set", "curves.tolerance=0.25")
    run.fine("render", "brush.yaml", "-f", "1", "-o", "a", "--no-progress", "--max-error", "picture=100%", *fixed)
    told = json.loads(Path("a/report.json").read_text())["picture_error"]["settings"]
    assert told.get("image.supersample", 2) == 2
    assert told.get("curves.tolerance", 0.25) == 0.25


def test_what_studies_do_not_draw_is_refused(tmp_path: Path) -> None:
    (tmp_path / "away.yaml").write_text(
        SMALL.replace("position: [0, 0.3, 4]", "position: [0, 0.3, 4], target: [9, 0.3, 4]")
    )
    scene = strandcli.load(str(tmp_path / "away.yaml"))
    with pytest.raises(UsageError, match="shows no strands"):
        Windows(Request(scene=scene, name="away")).move()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--max-error", "picture=0"], "more than 0"),
        (["--max-error", "flip=nan"], "is not an error"),
        (["--max-error", "light=2%"], "'light' has no error; write motion=2%, picture=2%, flip=2%"),
        (["--max-error", "picture=2%,picture=3%"], "two errors of picture"),
        (["--max-error", "picture=2%,motion=1%", "--from-cache", "x"], "exclude each other"),
        (["--max-error", "picture=2%", "--quality", "best"], "leave one of the two out"),
        (["--max-error", "picture=2%", "--set", "quality=best"], "leave one of the two out"),
    ],
)
def test_bad_input_is_one_line_and_exit_code_2(run: Runner, arguments: list[str], words: str) -> None:
    assert words in run.refused("render", "brush.yaml", "-f", "1", *arguments)
    assert not Path("out").exists()
