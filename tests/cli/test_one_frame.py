"""A frame drawn into a finished shot replaces that frame alone: report, page and animation are still of the shot."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
from PIL import Image

from cli_runs import Runner
from strandcli.output import png


@pytest.fixture
def run(run: Runner) -> Runner:
    assert run("render", "tiny.yaml", "-o", "a", "-f", "1-4", "--animate", "gif").code == 0
    return run


def shown() -> int:
    with Image.open("a/animation.gif") as film:
        return getattr(film, "n_frames", 1)


def damage(number: int) -> None:
    """Put another frame's picture in the place of one, still of the scene."""
    Path(f"a/frame_000{number}.png").write_bytes(Path("a/frame_0001.png").read_bytes())


@pytest.mark.parametrize("option", [["--overwrite"], ["--resume"], ["--overwrite", "--animate", "gif"]])
def test_one_frame_into_a_finished_shot_leaves_the_rest_whole(run: Runner, option: list[str]) -> None:
    before = {path.name: path.read_bytes() for path in Path("a").glob("frame_*.png")}
    film = Path("a/animation.gif").read_bytes()
    damage(3)
    if option == ["--resume"]:
        Path("a/frame_0003.png").unlink()
    Path("a/animation.gif").write_bytes(b"GIF of a damaged frame")
    done = run.fine("render", "tiny.yaml", "-o", "a", "-f", "3", *option)
    assert "1 frame in" in done.err
    assert "; animation.gif; " in done.err
    assert {path.name: path.read_bytes() for path in Path("a").glob("frame_*.png")} == before
    assert Path("a/animation.gif").read_bytes() == film
    assert shown() == 4
    data = json.loads(Path("a/report.json").read_text())
    assert [entry["frame"] for entry in data["frames"]] == [1, 2, 3, 4]
    for entry in data["frames"]:
        assert entry["pixels_sha256"] == png.pixels_sha256(png.read(Path("a") / entry["file"]))
    assert re.search("4 frames, 1 to 4", Path("a/report.html").read_text())


@pytest.mark.parametrize(
    ("options", "told"),
    [("-f 5", ""), ("-f 3 --overwrite --set wind.strength=9", "3 frames there of another scene")],
    ids=["nobody lets replace it", "a frame of another scene"],
)
def test_an_animation_stays(run: Runner, options: str, told: str) -> None:
    film = Path("a/animation.gif").read_bytes()
    assert told in run.fine("render", "tiny.yaml", "-o", "a", *options.split()).err
    assert Path("a/animation.gif").read_bytes() == film
