"""How runs of `render` end: refused, out of room, by a signal; and what is left."""

from __future__ import annotations

import fcntl
import os
import pty
import select
import signal
import subprocess
import sys
import termios
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from PIL import Image

from cli_runs import Runner, child, environment, listen, report
from strandcli.errors import RefusedError, SimulationError
from strandcli.output import frames, png
from strandcli.run import pipeline
from tests.cli.test_render import names


@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_a_signal_while_an_animation_is_written_is_told(
    run: Runner, monkeypatch: pytest.MonkeyPatch, number: int, code: int
) -> None:
    read = png.read

    def late(path: Path) -> png.Pixels:
        if Path("a", ".here").exists() and any(name.endswith(".tmp") for name in names("a")):
            os.kill(os.getpid(), number)
        return read(path)

    assert run("render", "tiny.yaml", "-o", "a", "-f", "1-5").code == 0
    Path("a/.here").touch()
    monkeypatch.setattr(png, "read", late)
    result = run("render", "tiny.yaml", "-o", "a", "-f", "1-5", "--resume", "--animate", "gif,webp")
    assert result.code == code
    words = "animation.gif is not written; 5 finished frames stay, --resume continues"
    assert result.err.strip() == f"a: interrupted; {words}"
    assert names("a") == [".here", *(frames.frame_file(n) for n in range(1, 6)), "report.html", "report.json"]
    Path("a/.here").unlink()
    assert run("render", "tiny.yaml", "-o", "a", "-f", "1-5", "--resume", "--animate", "gif").code == 0
    with Image.open("a/animation.gif") as film:
        assert getattr(film, "n_frames", 1) == 5


def test_an_output_that_is_a_file_is_refused_before_anything_runs(run: Runner, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pipeline, "render", lambda *arguments, **options: pytest.fail("rendered"))
    Path("a").write_text("mine")
    for command in ("render", "simulate"):
        assert "a: is a file, not a folder" in run.refused(command, "tiny.yaml", "-o", "a", code=4)
        assert run(command, "tiny.yaml", "-o", "a/b").code == 4
    assert Path("a").read_text() == "mine"


@pytest.mark.parametrize(
    ("error", "code", "status"),
    [
        (SimulationError("frame 3: strand 7 is not finite"), 1, "failed"),
        (MemoryError(), 4, "failed"),
        (KeyboardInterrupt(), 130, "interrupted"),
    ],
)
def test_whatever_ends_a_run_there_is_a_report_of_what_is_finished(
    run: Runner, monkeypatch: pytest.MonkeyPatch, error: BaseException, code: int, status: str
) -> None:
    render = pipeline.render

    def until_three(*arguments: Any, **options: Any) -> Any:
        for frame in render(*arguments, **options):
            if frame.number == 3:
                raise error
            yield frame

    monkeypatch.setattr(pipeline, "render", until_three)
    assert run("render", "tiny.yaml", "-o", "a", "-f", "1-5").code == code
    assert names("a") == ["frame_0001.png", "frame_0002.png", "report.html", "report.json"]
    data = report("a")
    assert data["status"] == status
    assert [entry["frame"] for entry in data["frames"]] == [1, 2]
    assert data["machine"]["threads"] >= 1


def test_a_report_that_cannot_be_written_does_not_hide_what_ended_the_run(
    run: Runner, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(directory: Path, data: object) -> None:
        raise RefusedError("report.json: no")

    monkeypatch.setattr("strandcli.output.report.write_report", refuse)
    assert run("render", "tiny.yaml", "-o", "a", "-f", "1").error().endswith("report.json: no")

    def interrupted(*arguments: Any, **options: Any) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(pipeline, "render", interrupted)
    assert run("render", "tiny.yaml", "-o", "b", "-f", "1").code == 130


def test_a_signal_keeps_finished_frames_and_writes_the_report(run: Runner) -> None:
    process = child(run.folder, "render", "tiny.yaml", "-o", "a", "--set", "time.frames=100000")
    deadline = time.monotonic() + 120
    while not Path("a/frame_0004.png").exists():
        assert process.poll() is None, process.communicate()
        assert time.monotonic() < deadline
        time.sleep(0.02)
    process.send_signal(signal.SIGTERM)
    out, err = process.communicate(timeout=60)
    assert process.returncode == 143
    assert out == ""
    assert "Traceback" not in err
    assert "Exception" not in err
    data = report("a")
    assert data["status"] == "interrupted"
    done = [entry["file"] for entry in data["frames"]]
    assert len(done) >= 4
    assert names("a") == [*done, "report.html", "report.json"]
    for entry in data["frames"]:
        assert png.pixels_sha256(png.read(Path("a", entry["file"]))) == entry["pixels_sha256"]


def test_a_terminal_that_is_closed_keeps_finished_frames_and_writes_the_report(run: Runner) -> None:
    """Nobody reads what is printed then, and to print it fails."""
    ours, theirs = pty.openpty()
    command = [sys.executable, "-m", "strandcli", "render", "tiny.yaml", "-o", "a", "--set", "time.frames=100000"]
    process = subprocess.Popen(
        command, cwd=run.folder, env=environment(), stdout=theirs, stderr=theirs, start_new_session=True,
        preexec_fn=lambda: (listen(), fcntl.ioctl(1, termios.TIOCSCTTY, 0)),
    )  # fmt: skip
    os.close(theirs)
    reader = threading.Thread(target=drained, args=(ours, lambda: Path("a/frame_0004.png").exists()))
    reader.start()
    reader.join(120)
    os.close(ours)  # which sends SIGHUP
    assert process.wait(60) == 129
    assert report("a")["status"] == "interrupted"
    assert names("a") == [*(entry["file"] for entry in report("a")["frames"]), "report.html", "report.json"]


def drained(terminal: int, enough: Callable[[], bool]) -> None:
    """Read what is printed, for the program not to wait."""
    while not enough():
        if select.select([terminal], [], [], 0.05)[0]:
            try:
                os.read(terminal, 65536)
            except OSError:  # it has ended
                return
