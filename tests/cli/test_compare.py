"""Commands that look at pictures: compare, sheet and golden."""

from __future__ import annotations

import json
import os
from pathlib import Path
from xml.etree import ElementTree

import pytest
from PIL import Image

from cli_runs import TINY, Runner
from strandcli.output import png
from strandcli.output.compare import write_image
from tests.cli.test_tools import picture


def test_compare_tells_equal_from_different_by_its_exit_code(run: Runner) -> None:
    picture("a.png")
    picture("b.png", 9)
    Image.open("a.png").save("c.png")
    same = run("compare", "a.png", "c.png")
    assert (same.code, same.out, same.err) == (0, "the same pixels\n", "")
    other = run("compare", "a.png", "b.png", "-o", "d.png")
    assert other.code == 3
    assert "1 of 600 pixels (0.167 %) differ, the most by 9/255" in other.error()
    assert "differ" not in other.out  # once is enough
    assert "PSNR" in other.out
    assert "differ, the most by 9/255" in run("compare", "a.png", "b.png", "--allow", "1").out
    assert png.read(Path("d.png")).shape == (20, 30, 3)
    data = json.loads(run("compare", "a.png", "b.png", "--json").out)
    assert (data["over"], data["max_difference"], data["equal"]) == (1, 9, False)
    assert data["rmse"] == pytest.approx((81 / 1800) ** 0.5)
    assert run("compare", "a.png", "b.png", "--threshold", "9").code == 0
    assert run("compare", "a.png", "b.png", "--threshold", "8").code == 3
    assert run("compare", "a.png", "b.png", "--allow", "0.2").code == 0
    assert run("compare", "a.png", "b.png", "--allow", "0.1").code == 3
    assert run("compare", "a.png", "b.png", "--threshold", "9", "--rmse", "0.2").code == 3


def test_pictures_are_written_under_names_that_say_what_they_are(run: Runner) -> None:
    picture("a.png")
    assert "is written as PNG" in run("compare", "a.png", "a.png", "-o", "d.jpg").error()
    assert "is written as PNG" in run("sheet", "a.png", "-o", "d.gif").error()
    assert sorted(os.listdir()) == ["a.png", "tiny.yaml"]


def test_compare_of_what_cannot_be_compared(run: Runner) -> None:
    picture("a.png")
    Image.new("RGB", (3, 3)).save("small.png")
    assert run("compare", "a.png", "small.png").code == 3
    assert "30x20 against 3x3" in run("compare", "a.png", "small.png").error()
    assert run("compare", "a.png", "none.png").code == 2
    assert run("compare", "a.png", "tiny.yaml").code == 2
    assert run("compare", "a.png", "a.png", "-o", "no/such/d.png").code == 4


def test_sheet_gathers_folders_and_does_not_overwrite_unasked(run: Runner) -> None:
    for folder in ("figs/fig02", "figs/fig03"):
        os.makedirs(folder)
        picture(f"{folder}/frame_0001.png")
    assert "2 images" in run.fine("sheet", "figs", "-o", "sheet.png", "--columns", "2").err
    assert png.read(Path("sheet.png")).shape[1] == 8 + 2 * 38
    assert run("sheet", "figs", "-o", "sheet.png").code == 2
    assert run("sheet", "figs", "-o", "sheet.png", "--overwrite", "-q").err == ""
    assert run("sheet", "none", "-o", "b.png").code == 2
    assert run("sheet", "figs", "-o", "b.png", "--columns", "0").code == 2


def test_compare_of_two_folders_looks_at_every_frame_and_blames_the_side_that_is_missing(run: Runner) -> None:
    for name in ("one/frame_0001.png", "one/frame_0002.png", "two/frame_0001.png", "two/frame_0002.png"):
        os.makedirs(Path(name).parent, exist_ok=True)
        picture(name, 9 * ("2" in name))
    same = run("compare", "one", "two")
    assert (same.code, same.out) == (0, "frame_0001.png: the same pixels\nframe_0002.png: the same pixels\n")
    picture("two/frame_0002.png")
    differ = run("compare", "one", "two")
    assert (differ.code, "frame_0002.png differ" in differ.error()) == (3, True)
    os.remove("two/frame_0002.png")
    picture("one/frame_0003.png")
    os.makedirs("empty")
    assert run("compare", "empty", "empty").code == 2
    assert run("compare", "one", "two").error().endswith("two: has no frame_0002.png and 1 more, as one has")
    assert run("compare", "two", "one").error().endswith("two: has no frame_0002.png and 1 more, as one has")
    for missing in (("one", "none"), ("none", "one"), ("one/frame_0001.png", "none"), ("none", "one/frame_0001.png")):
        done = run("compare", *missing)
        assert (done.code, done.error()) == (2, "strandcli: error: none: no such image or folder")
    for mixed in (("one", "two/frame_0001.png"), ("two/frame_0001.png", "one")):
        assert "one: is a folder, and two/frame_0001.png an image" in run("compare", *mixed).error()


def test_golden_images_catch_a_pixel_and_a_parameter(run: Runner, monkeypatch: pytest.MonkeyPatch) -> None:
    os.makedirs("g")
    Path("g/tiny.yaml").write_text(TINY)
    Path("g/golden.yaml").write_text("- {preset: tiny.yaml, frame: 3, size: 40x30}\n- {preset: tiny.yaml, name: b}\n")
    missing = run("golden", "check", "g", "-o", "d")
    assert missing.code == 3
    assert "MISMATCH tiny: tiny.png is missing" in missing.err
    update = run.fine("golden", "update", "g")
    assert update.err.splitlines() == ["tiny: new", "b: new", "g: 2 of 2 golden images changed"]
    assert png.read(Path("g/tiny.png")).shape == (30, 40, 3)
    check = run.fine("golden", "check", "g", "-o", "d")
    assert check.err.splitlines() == ["ok       tiny: exact", "ok       b: exact"]
    assert not Path("d").exists()

    image = png.read(Path("g/b.png")).copy()
    image[3, 4, 0] ^= 1
    whole = Path("g/b.png").read_bytes()
    write_image(Path("g/b.png"), image)
    planted = run("golden", "check", "g", "-o", "d", "--json", "--junit", "ci/golden.xml")
    assert planted.code == 3
    assert json.loads(planted.err.splitlines()[-1])["error"] == "1 of 2 golden images do not match: b"
    (suite,) = ElementTree.parse("ci/golden.xml").getroot()
    assert (suite.get("tests"), suite.get("failures")) == ("2", "1")
    assert [(case.get("name"), len(case)) for case in suite] == [("tiny", 0), ("b", 1)]
    assert "not the image that hashes.json" in str(suite[1][0].get("message"))
    assert suite[1][0].text == "d/b.diff.png"
    assert all(float(str(case.get("time"))) >= 0 for case in suite)
    data = json.loads(planted.out)
    assert [one["matches"] for one in data["images"]] == [True, False]
    assert data["images"][1]["comparison"]["over"] == 1
    assert os.listdir("d") == ["b.diff.png"]
    Path("g/b.png").write_bytes(whole)

    Path("g/tiny.yaml").write_text(TINY.replace("length: 0.6", "length: 0.61"))
    for other_class in (False, True):
        if other_class:
            monkeypatch.setattr("strandcli.study.golden.machine_class", lambda: "another machine")
        changed = run("golden", "check", "g", "tiny", "-o", "d")
        assert changed.code == 3
        assert "MISMATCH tiny: " in changed.err
        assert Path("d/tiny.diff.png").exists()
    monkeypatch.undo()


def test_golden_names_and_faults(run: Runner) -> None:
    os.makedirs("g")
    assert run("golden", "check", "g").code == 2
    Path("g/golden.yaml").write_text("- {preset: ../tiny.yaml, name: a, frame: 99}\n")
    assert "no golden image is named 'zzz'" in run("golden", "check", "g", "zzz").error()
    assert "a: frame 99 is beyond the last, 12" in run("golden", "update", "g").error()
    Path("g/golden.yaml").write_text("- {preset: nonesuch}\n")
    assert run("golden", "update", "g").code == 2
    assert os.listdir("g") == ["golden.yaml"]
