"""Pictures without background on the command line: files, animations, sheets, comparisons, golden images."""

from __future__ import annotations

import json
import os
from pathlib import Path

import numpy as np
import pytest
from PIL import Image, ImageSequence

import strandcli
from cli_runs import TINY, Runner
from strandcli.output import png
from strandcli.output.png import GREY, over
from strandcli.run import pipeline

NONE = ("--set", "image.background=none")


def test_frames_have_straight_alpha_and_are_resumed(run: Runner) -> None:
    assert run("render", "tiny.yaml", "-o", "a", "-f", "1-2", *NONE).code == 0
    with Image.open("a/frame_0001.png") as image:
        assert image.mode == "RGBA"
    (frame,) = pipeline.render(strandcli.load("tiny.yaml", overrides=["image.background=none"]), [2])
    np.testing.assert_array_equal(png.read(Path("a/frame_0002.png")), frame.image)
    more = run("render", "tiny.yaml", "-o", "a", "-f", "1-3", "--resume", *NONE)
    assert (more.code, "2 kept" in more.err) == (0, True)
    assert "another scene" in run.refused("render", "tiny.yaml", "-o", "a", "-f", "1-3", "--resume")


def test_animations_without_alpha_are_over_a_colour_that_is_named_or_told(run: Runner) -> None:
    told = run.fine("render", "tiny.yaml", "-o", "a", "-f", "1-2", "--animate", "gif,webp", *NONE)
    note = "a/animation.gif: gif has no alpha: frames are over mid grey; name another colour by --over"
    assert note in told.err.splitlines()
    assert "webp has no alpha" not in told.err
    with Image.open("a/animation.webp") as film:
        shown = [np.asarray(one.convert("RGBA")) for one in ImageSequence.Iterator(film)]
    assert np.abs(shown[0][..., 3].astype(int) - png.read(Path("a", "frame_0001.png"))[..., 3]).max() < 3
    words = ("-o", "b", "-f", "1", "--animate", "gif", "--over", "#ff0000")
    named = run("render", "tiny.yaml", *words, *NONE)
    assert (named.code, "has no alpha" in named.err) == (0, False)
    for path, colour in (("a", GREY), ("b", (255, 0, 0))):
        with Image.open(f"{path}/animation.gif") as film:
            assert np.abs(np.asarray(film.convert("RGB"))[0, 0].astype(int) - colour).max() <= 6  # of a palette


@pytest.mark.parametrize(
    ("words", "error"),
    [
        (("--over", "red"), "--over is for GIF and MP4, which have no alpha"),
        (("--over", "red", "--animate", "gif"), "--over: the frames have a background"),
        (("--over", "#ff000080", "--animate", "gif", *NONE), "is not a colour"),
    ],
)
def test_a_colour_that_is_none_or_that_nothing_is_put_over_is_refused(
    run: Runner, words: tuple[str, ...], error: str
) -> None:
    refused = run("render", "tiny.yaml", "-o", "a", *words)
    assert refused.code == 2
    assert error in refused.err
    assert not Path("a").exists()


def test_sheets_and_comparisons_know_alpha(run: Runner) -> None:
    pixels = np.zeros((40, 60, 4), np.uint8)
    pixels[:20] = 200, 100, 50, 255
    pixels[20:30] = 200, 100, 50, 128
    for name, changes in (("a", []), ("colour", [((35, 5), (9, 9, 9, 0))]), ("alpha", [((5, 5), (200, 100, 50, 254))])):
        for at, value in changes:
            pixels[at] = value
        Path(f"{name}.png").write_bytes(b"".join(png.encode(pixels)))
    np.testing.assert_array_equal(png.read(Path("alpha.png")), pixels)
    assert run("compare", "a.png", "colour.png").out == "the same pixels\n"  # what shows nothing has no colour
    assert run("compare", "colour.png", "alpha.png").code == 3
    Image.fromarray(pixels[..., :3]).save("plain.png")
    mixed = run("compare", "a.png", "plain.png", "--flip")
    assert mixed.code == 3
    assert "plain.png has no alpha, as the other has: taken as opaque" in mixed.err.splitlines()
    for words, paper in (((), (24, 25, 28)), (("--over", "white"), (255, 255, 255))):
        assert run("sheet", "a.png", "-o", "sheet.png", "--overwrite", *words).code == 0
        found = png.read(Path("sheet.png"))[8:48, 8:68]
        np.testing.assert_array_equal(found, over(png.read(Path("a.png")), paper))
        assert (found[39, 59] == paper).all()


def test_panels_without_background_leave_gaps_and_labels_opaque(run: Runner) -> None:
    Path("two.yaml").write_text("extends: tiny.yaml\npanels: [{label: a, set: {image.background: none}}, {label: b}]\n")
    assert run("render", "two.yaml", "-f", "1", "-o", "a", "--animate", "gif", "--over", "white").code == 0
    found = png.read(Path("a/frame_0001.png"))
    (alone,) = pipeline.render(strandcli.load("tiny.yaml", overrides=["image.background=none"]), [1])
    np.testing.assert_array_equal(found[:48, :64], alone.image)
    assert (found[:, 64:, 3] == 255).all()
    assert (found[48:, :, 3] == 255).all()


def test_terminals_are_sent_pictures_over_grey(run: Runner) -> None:
    shown = run("render", "tiny.yaml", "-f", "1", "-o", "a", "--preview", "blocks", "-q", *NONE).out
    red, green, blue = GREY
    assert shown.startswith(f"\x1b[38;2;{red};{green};{blue};48;2;{red};{green};{blue}m")


def test_golden_images_have_alpha(run: Runner) -> None:
    os.makedirs("g")
    Path("g/tiny.yaml").write_text(TINY.replace("image: {", "image: {background: none, "))
    Path("g/golden.yaml").write_text("- {preset: tiny.yaml, frame: 2, size: 40x30}\n")
    assert run("golden", "update", "g").code == 0
    assert png.read(Path("g/tiny.png")).shape == (30, 40, 4)
    assert run("golden", "check", "g", "-o", "d").code == 0
    Path("g/tiny.yaml").write_text(TINY)
    lost = run("golden", "check", "g", "-o", "d", "--json")
    assert lost.code == 3
    assert json.loads(lost.out)["images"][0]["why"] == "sizes differ: 40x30 with alpha against 40x30"


def test_over_is_a_mean_in_linear_light() -> None:
    half = np.array([[[255, 255, 255, 128], [7, 8, 9, 255], [7, 8, 9, 0]]], np.uint8)
    found = over(half, (0, 0, 0))
    light = 128 / 255
    assert found[0, 0].tolist() == [round(255 * (1.055 * light ** (1 / 2.4) - 0.055))] * 3
    assert found[0, 1:].tolist() == [[7, 8, 9], [0, 0, 0]]
    assert over(half[..., :3]) is not None
