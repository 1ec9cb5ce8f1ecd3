"""Looking on: pictures in terminals, --watch, and MP4."""

from __future__ import annotations

import base64
import contextlib
import dataclasses
import io
import os
import pty
import re
import shutil
import signal
import stat
import subprocess
import sys
from collections.abc import Collection
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from cli_runs import TINY, Runner, child, environment
from strandcli import load
from strandcli.cli import preview as shown
from strandcli.cli.watch import _drawn, _with_one_turn
from strandcli.errors import RefusedError, UsageError
from strandcli.files import inputs
from strandcli.output import animation, png
from strandcli.output.compare import write_image
from strandcli.output.png import over
from strandcli.run import pipeline
from tests.run.test_checkpoints import SMALL, counted_steps

SIZES = st.tuples(st.integers(1, 40), st.integers(1, 40))


def picture(size: tuple[int, int], seed: int = 1) -> np.ndarray:
    """A picture (H, W, 3) of few colours, so that a palette holds them all."""
    rng = np.random.default_rng(seed)
    colours = rng.choice([0, 51, 102, 204, 255], (7, 3)).astype(np.uint8)
    return colours[rng.integers(0, 7, size)]


@given(SIZES)
def test_kitty_and_iterm2_are_handed_the_pictures_png(size: tuple[int, int]) -> None:
    image = picture(size)
    pieces = re.findall(r"\x1b_G([^;]*);([^\x1b]*)\x1b\\", shown.kitty(image))
    assert all(len(data) <= shown.CHUNK for _, data in pieces)
    assert [keys.rpartition("m=")[2] for keys, _ in pieces] == ["1"] * (len(pieces) - 1) + ["0"]
    inline = re.fullmatch(r"\x1b\]1337;File=inline=1;size=(\d+);[^:]*:(.*)\x07\n", shown.iterm2(image))
    for text in ("".join(data for _, data in pieces), inline[2]):
        data = base64.b64decode(text)
        assert np.array_equal(np.asarray(Image.open(io.BytesIO(data))), image)
    assert len(base64.b64decode(inline[2])) == int(inline[1])


def test_half_blocks_have_two_pixels_each() -> None:
    image = picture((6, 5))
    lines = shown.blocks(image).splitlines()
    assert [re.sub(r"\x1b\[[0-9;]*m", "", line) for line in lines] == [shown.UPPER_HALF * 5] * 3
    for row, line in enumerate(lines):
        colours: list[str] = []
        for code, blocks in re.findall(r"\x1b\[([0-9;]+)m(\u2580+)", line):
            colours += [code] * len(blocks)
        for x, code in enumerate(colours):
            upper, lower = image[2 * row, x].tolist(), image[2 * row + 1, x].tolist()
            assert code == f"38;2;{upper[0]};{upper[1]};{upper[2]};48;2;{lower[0]};{lower[1]};{lower[2]}"
    assert len(shown.drawn(picture((300, 400)), "blocks", 80, 24).splitlines()) == 20


@pytest.mark.parametrize(("variables", "kind"), [
    ({"TERM": "xterm-kitty"}, "kitty"), ({"LC_TERMINAL": "iTerm2"}, "iterm2"),
    ({"TERM": "tmux-256color", "KITTY_WINDOW_ID": "1"}, "blocks"), ({}, "blocks"),
])  # fmt: skip
def test_terminals_are_told_by_their_variables(variables: dict[str, str], kind: str) -> None:
    assert shown.detected(variables) == kind


def test_a_preview_goes_to_terminals_alone_unless_a_kind_is_named(run: Runner) -> None:
    render = ["render", "tiny.yaml", "-f", "1", "-o", "a", "--overwrite", "-q", "--no-html"]
    assert run(*render, "--preview").out == ""
    forced = run(*render, "--preview", "blocks").out
    assert forced.count("\n") == 20
    follower, leader = pty.openpty()
    process = subprocess.Popen([sys.executable, "-m", "strandcli", *render, "--preview"], stdout=leader, cwd=run.folder,
                               env={**environment(), "TERM": "xterm-256color"})  # fmt: skip
    os.close(leader)
    told = b""
    with contextlib.suppress(OSError):  # which is how Linux tells that the other side is closed
        while piece := os.read(follower, 4096):
            told += piece
    os.close(follower)
    assert process.wait(30) == 0
    assert told.decode().count("\n") == 20
    assert "\u2580" in told.decode()


def lines_of(process: subprocess.Popen[str], word: str) -> str:
    """The next line on stderr that holds a word."""
    for line in process.stderr:
        if word in line:
            return line
    raise AssertionError(f"it ended without {word!r}")


def saved(text: str) -> None:
    """Replace the preset at once, as editors do: it is never seen empty."""
    Path("new.yaml").write_text(text)
    os.replace("new.yaml", "tiny.yaml")


def test_watch_draws_again_when_the_preset_changes_and_tells_faults(run: Runner) -> None:
    process = child(run.folder, "render", "tiny.yaml", "--watch", "-o", "w", "--threads", 1)
    try:
        lines_of(process, "watch.png: frame 1 in")
        first = png.read(Path("w/watch.png"))
        saved(TINY.replace("strength: 2", "strength: x"))
        assert "tiny.yaml:7:22: wind.strength" in lines_of(process, "tiny.yaml:")
        assert np.array_equal(png.read(Path("w/watch.png")), first)
        saved(TINY.replace("length: 0.6", "length: 0.9"))
        lines_of(process, "watch.png: frame 1 in")
        assert not np.array_equal(png.read(Path("w/watch.png")), first)
        process.send_signal(signal.SIGINT)
        assert process.wait(30) == 0
    finally:
        process.kill()
        process.communicate()


def test_watch_simulates_again_only_what_moves_strands(tmp_path: Path) -> None:
    given = {"preset": "minimal", "threads": 1, "keep_going": False, "quiet": True, "no_progress": True}
    changes: list[dict[str, Any]] = [
        {}, {"lights.0.intensity": 1.0}, {"camera.fov": 30.0}, {"wind.strength": 5.0},
        {"camera.shutter": 0.5, "camera.samples": 2}, {"camera.shutter": 0.25, "camera.samples": 2},
    ]  # fmt: skip
    found = []
    for more in changes:
        scene = load("hair", settings={**SMALL, **more})
        with counted_steps() as steps:
            image, _ = _drawn(scene, 3, given, tmp_path)
        found.append(steps.count)
        (plain,) = pipeline.render(scene, [3], threads=1)
        assert np.array_equal(image, plain.image), more
    step = load("hair").time.substeps
    assert [one > 0 for one in found[:4]] == [True, False, False, True]
    assert found[4] > found[5] == step  # the frame before is known, and the frame is simulated from there


def test_watch_simulates_a_loop_for_one_turn_before_its_first_frame() -> None:
    for loop, preroll, left in ((True, 6, 3), (True, 1, 1), (False, 6, 6)):
        scene = load("hair", settings={"time.loop": loop, "time.preroll": float(preroll)})
        assert _with_one_turn(scene).time == dataclasses.replace(scene.time, preroll=left)


def test_watch_goes_with_no_run_of_many_frames_and_replaces_no_file_of_others(run: Runner) -> None:
    assert "--resume does not go with it" in run("render", "tiny.yaml", "--watch", "--resume").error()
    assert "--sweep does not go" in run("render", "tiny.yaml", "--watch", "--sweep", "seed=1-2").error()
    Path("w").mkdir()
    write_image(Path("w/watch.png"), picture((4, 4)))
    Image.open("w/watch.png").save("w/watch.png")
    assert "was not written by strandcli" in run("render", "tiny.yaml", "--watch", "-o", "w").error()


FFMPEG = f"""\
#!{sys.executable}
import pathlib, sys
words = sys.argv[1:]
if "libx264" in words:
    sys.exit("Unknown encoder 'libx264'")
if "fail" in words[-1]:
    sys.exit("no such luck")
data = sys.stdin.buffer.read()
pathlib.Path(words[-1].removeprefix("file:")).write_bytes(" ".join(words[:-1]).encode() + b"\\n" + data)
"""


def test_ffmpeg_is_handed_every_frame_for_its_time(run: Runner, monkeypatch: pytest.MonkeyPatch) -> None:
    """By a stand-in that was built without x264."""
    monkeypatch.setenv("PATH", "")
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    refused = run("render", "tiny.yaml", "-f", "1", "--animate", "mp4", "-o", "a")
    assert (refused.code, "there is no ffmpeg; install ffmpeg" in refused.error()) == (2, True)
    assert not Path("a").exists()
    Path("ffmpeg").write_text(FFMPEG)
    Path("ffmpeg").chmod(stat.S_IRWXU)
    monkeypatch.setenv("PATH", str(run.folder))
    images = []
    for number in (1, 3, 4):
        images.append(Path(f"frame_{number:04d}.png"))
        write_image(images[-1], picture((3, 5), number))
    assert animation.write_video(Path("film.mp4"), images, [1, 3, 4], 23.976) == 23.976
    words, _, data = Path("film.mp4").read_bytes().partition(b"\n")
    assert b"-video_size 5x3 -framerate 2997/125" in words
    assert data == b"".join(picture((3, 5), number).tobytes() for number in (1, 1, 3, 4))
    bare = np.dstack([picture((3, 5), 1), np.full((3, 5), 90, np.uint8)])
    write_image(images[0], bare)
    animation.write_video(Path("bare.mp4"), images[:1], [1], 24, (9, 99, 199))
    assert Path("bare.mp4").read_bytes().partition(b"\n")[2] == over(bare, (9, 99, 199)).tobytes()
    with pytest.raises(RefusedError, match="ffmpeg could not write it: no such luck"):
        animation.write_video(Path("fail.mp4"), images, [1, 3, 4], 24)
    assert sorted(path.suffix for path in Path().iterdir() if path.name.startswith((".", "fail"))) == []


def test_a_real_ffmpeg_makes_a_film_of_the_right_length(run: Runner) -> None:
    try:
        command = animation.ffmpeg()
    except UsageError:
        pytest.skip("no ffmpeg")
    assert run("render", "tiny.yaml", "-f", "1-9x4", "--size", "63x47", "--animate", "mp4", "-o", "a", "-q").code == 0
    raw = subprocess.run([command, "-v", "error", "-i", "a/animation.mp4", "-f", "rawvideo", "-pix_fmt", "rgb24", "-"],
                         capture_output=True, check=True).stdout  # fmt: skip
    films = np.frombuffer(raw, np.uint8).reshape(9, 48, 64, 3)
    for place, number in ((0, 1), (3, 1), (4, 5), (8, 9)):
        image = png.read(Path(f"a/frame_{number:04d}.png")).astype(int)
        assert np.abs(films[place, :47, :63] - image).mean() < 6
    assert shutil.which("ffmpeg") or "imageio" in command


def test_a_file_that_a_preset_names_is_seen_where_it_goes_and_where_it_comes_back(tmp_path: Path) -> None:
    path, sky = tmp_path / "a.yaml", tmp_path / "sky.png"
    path.write_text(TINY + "environment: {image: sky.png}\n", encoding="utf-8")
    found: Collection[inputs.Input] | None = None
    for step in (lambda: None, lambda: sky.write_bytes(b"sky"), sky.unlink, lambda: sky.write_bytes(b"sea")):
        step()
        assert found is None or not all(map(inputs.is_current, found))
        with inputs.recording() as found, contextlib.suppress(UsageError):
            load(str(path))
            inputs.note(sky)  # as drawing does
        assert all(map(inputs.is_current, found))


def test_a_preset_that_becomes_a_pipe_or_a_device_is_seen_and_not_opened(tmp_path: Path) -> None:
    path = tmp_path / "a.yaml"
    path.write_text(TINY, encoding="utf-8")
    with inputs.recording() as found:
        inputs.note(path)
    steps = (path.unlink, lambda: os.mkfifo(path), lambda: None, path.unlink, lambda: path.symlink_to("/dev/zero"))
    signal.alarm(20)  # to open either never ends
    try:
        for step, seen in zip(steps, (True, True, False, True, True), strict=True):
            step()
            assert all(map(inputs.is_current, found)) != seen
            with inputs.recording() as found:
                inputs.note(path)
    finally:
        signal.alarm(0)
    path.unlink()
    path.write_text(TINY, encoding="utf-8")
    assert not all(map(inputs.is_current, found))
