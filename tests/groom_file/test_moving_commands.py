"""Commands that draw files of strands that move, and what their frames are known by."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from cli_runs import Runner
from strandcli.files import inputs
from tests.groom_file.test_moving_files import FPS, file_of, turned


def test_commands(tmp_path: Path, run: Runner) -> None:
    """`render` and `dataset` draw moments; `info` tells which there are."""
    path = file_of(tmp_path, "ply", turned, [i / FPS for i in range(3)])
    told = json.loads(run("info", str(path), "--json").out)["moments"]
    assert (told["count"], told["first"], told["last"], told["unit"]) == (3, 7, 9, "file")
    assert "3, files 7 to 9" in run("info", str(path)).out
    small = ["--size", "48x36", "--set", "ambient_occlusion=null"]
    assert run("render", str(path), "-o", str(tmp_path / "film"), *small).code == 0
    pictures = {one.read_bytes() for one in (tmp_path / "film").glob("frame_*.png")}
    assert len(pictures) == 3
    for frame in (1, 3):
        options = ["--layout", "nerfstudio", "--views", "1", "--frame", str(frame), "-o", str(tmp_path / f"set{frame}")]
        assert run("dataset", str(path), *options, *small).code == 0
    first, third = (sorted((tmp_path / f"set{frame}").glob("images/*"))[0].read_bytes() for frame in (1, 3))
    assert first != third
    (tmp_path / "moving.0008.ply").unlink()
    done = run("render", str(path), "-o", str(tmp_path / "gap"), *small)
    assert done.code == 2
    assert "moving.0008.ply: there is no such file" in done.err
    assert not list((tmp_path / "gap").glob("frame_*"))


def test_info_tells_the_seconds_of_one_file(tmp_path: Path, run: Runner) -> None:
    path = file_of(tmp_path, "abc", turned, [i / FPS for i in range(3)])
    told = json.loads(run("info", path, "--json").out)["moments"]
    assert (told["count"], told["first"], told["last"], told["unit"]) == (3, 2.0, pytest.approx(2 + 2 / FPS), "s")
    assert "3, 2 to 2.083 s, 24 a second" in run("info", path).out


def test_kept_positions_are_those_of_each_moment(tmp_path: Path, run: Runner) -> None:
    path = file_of(tmp_path, "abc", turned, [i / FPS for i in range(3)])
    cache, first, second = (str(tmp_path / name) for name in ("cache", "a", "b"))
    small = ["--size", "48x36", "--set", "ambient_occlusion=null"]
    run.fine("simulate", path, "-o", cache)
    assert run("render", path, "-o", first, *small).code == 0
    assert run("render", path, "-o", second, "--from-cache", cache, *small).code == 0
    for number in (1, 3):
        name = f"frame_{number:04d}.png"
        assert run("compare", f"{first}/{name}", f"{second}/{name}").code == 0


def test_numbered_files_that_come_in_a_gap_are_seen(tmp_path: Path) -> None:
    path = file_of(tmp_path, "ply", turned, [i / FPS for i in range(4)])
    gap = tmp_path / "moving.0009.ply"
    content = gap.read_bytes()
    gap.unlink()
    with inputs.recording() as found:
        inputs.note(path)
    assert inputs.is_current(*found)
    gap.write_bytes(content)
    assert not inputs.is_current(*found)
    (tmp_path / "moving.png").write_bytes(b"of another name")
    with inputs.recording() as found:
        inputs.note(path)
    assert inputs.is_current(*found)
