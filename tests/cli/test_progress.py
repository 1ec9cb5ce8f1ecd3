"""The progress line: what it says, and that it is silent where nobody looks."""

from __future__ import annotations

import io
import time

import pytest

from strandcli.cli.progress import Progress, compiling
from strandcli.compiling import clock as costs
from strandcli.compiling.clock import Clock


class Terminal(io.StringIO):
    """A stderr that is a terminal."""

    def isatty(self) -> bool:
        return True


@pytest.fixture(autouse=True)
def new_process(monkeypatch: pytest.MonkeyPatch) -> None:
    """No kernel has been called yet."""
    monkeypatch.setattr("strandcli.cli.progress.clock", Clock())


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    now = [100.0]
    monkeypatch.setattr("strandcli.cli.progress.time.monotonic", lambda: now[0])
    return now


def test_time_left_is_that_of_the_frames_so_far(clock: list[float]) -> None:
    progress = Progress(10, "hair")
    progress.__enter__()
    assert progress.text(clock[0]) == "hair: [........................] 0/10"
    for _ in range(5):
        clock[0] += 2.0
        progress.step()
    assert progress.text(clock[0]) == "hair: [############............] 5/10 2.0 s a frame, 10 s left"
    progress.__exit__(None, None, None)


def test_time_left_never_grows_while_a_frame_is_drawn(clock: list[float]) -> None:
    progress = Progress(10, "hair")
    progress.__enter__()
    for _ in range(2):
        clock[0] += 60.0
        progress.step()
    lines = []
    for _ in range(9):
        lines.append(progress.text(clock[0]).rpartition(", ")[2])
        clock[0] += 10.0
    assert lines == ["8:00 left", "7:50 left", "7:40 left", "7:30 left", "7:20 left", "7:10 left", *["7:00 left"] * 3]
    assert "1:00" not in progress.text(clock[0])
    assert "60.0 s a frame" in progress.text(clock[0])  # that of finished frames, and never 0.0 frames/s
    progress.__exit__(None, None, None)


def test_compiling_is_told_while_it_runs_and_not_counted_as_drawing(clock: list[float]) -> None:
    progress = Progress(4, "hair")
    progress.__enter__()
    progress.note("compiling step")
    clock[0] += 3.0
    progress.note("compiling raster")
    clock[0] += 0.25
    assert progress.text(clock[0]) == "hair: compiling kernel 1 ... 3.2 s (only on first use) raster"
    progress.step()
    clock[0] += 0.5
    progress.step()
    assert progress.text(clock[0]).endswith("2/4 4.0 frames/s, 0 s left")
    progress.__exit__(None, None, None)


def test_a_terminal_gets_one_line_redrawn_and_cleared(monkeypatch: pytest.MonkeyPatch) -> None:
    terminal = Terminal()
    monkeypatch.setattr("sys.stderr", terminal)
    monkeypatch.setenv("TERM", "xterm")
    with Progress(2, "hair") as progress:
        progress.note("compiling step")
        while "compiling kernel 1" not in terminal.getvalue():
            pass
        progress.step()
    assert "\n" not in terminal.getvalue()
    assert terminal.getvalue().endswith("\r\x1b[K")


@pytest.mark.parametrize(
    ("terminal", "term", "hidden"), [(False, "xterm", False), (True, "dumb", False), (True, "xterm", True)]
)
def test_nothing_is_drawn_where_nobody_looks(
    monkeypatch: pytest.MonkeyPatch, terminal: bool, term: str, hidden: bool
) -> None:
    stream = Terminal() if terminal else io.StringIO()
    monkeypatch.setattr("sys.stderr", stream)
    monkeypatch.setenv("TERM", term)
    with Progress(2, "hair", hidden=hidden) as progress:
        progress.note("compiling step")
        progress.step("frame 1")
    assert stream.getvalue() == ""


def test_kernels_that_take_long_to_compile_are_told_once_in_a_pipe(monkeypatch: pytest.MonkeyPatch) -> None:
    stream = io.StringIO()
    monkeypatch.setattr("sys.stderr", stream)
    monkeypatch.setattr("strandcli.cli.progress._TICK", 0.01)
    monkeypatch.setattr("strandcli.cli.progress._LONG", 0.02)
    monkeypatch.setattr("strandcli.cli.progress._AGAIN", 0.02)
    for hidden in (True, False):
        with Progress(2, "hair", hidden=hidden) as progress:
            for _ in range(2):
                for kernel in ("step", "depth"):
                    progress.note(f"compiling {kernel}")
                    time.sleep(0.05)
                progress.step("frame 1")
        lines = stream.getvalue().splitlines()
        assert (len(lines) > 2) != hidden
        assert set(lines) <= {"hair: compiling kernel 1 (only on first use)"}


def test_how_many_kernels_are_left_and_how_long_that_takes(monkeypatch: pytest.MonkeyPatch) -> None:
    """The seconds that each took elsewhere, in proportion to those that the first ones took here."""
    table = {"presets": {"hair": {"film.develop": 1, "raster.draw": 2, "step.step": 1}},
             "seconds": {"film.develop": 10.0, "raster.draw": 20.0, "step.step": 30.0}}  # fmt: skip
    monkeypatch.setattr(costs, "_table", lambda: table)
    now = [100.0]
    monkeypatch.setattr("strandcli.compiling.clock.time.perf_counter", lambda: now[0])
    clock = Clock()
    monkeypatch.setattr("strandcli.cli.progress.clock", clock)

    def compiled(name: str, seconds: float) -> str:
        with clock.call(name):
            clock.missed(name)
            now[0] += seconds
            return compiling()

    assert compiled("film.develop", 1) == "compiling kernel 1"
    clock = Clock()
    monkeypatch.setattr("strandcli.cli.progress.clock", clock)
    clock.expect("/somewhere/presets/hair.yaml")
    assert compiled("film.develop", 5) == "compiling 1 of 4 kernels, 1:15 left"
    clock.waited["film.develop"] = 25.0  # twice what it took elsewhere: 30 s of 15
    assert compiled("raster.draw", 0) == "compiling 2 of 4 kernels, 2:20 left"
    with clock.call("raster.draw"):  # comes from the cache
        pass
    assert compiled("unknown.kernel", 1) == "compiling 4 of 5 kernels, 16 s left"
    assert clock.compiled == 3


def test_a_long_step_is_told_while_it_goes_on(monkeypatch: pytest.MonkeyPatch) -> None:
    stream = io.StringIO()
    monkeypatch.setattr("sys.stderr", stream)
    monkeypatch.setattr("strandcli.cli.progress._TICK", 0.01)
    monkeypatch.setattr("strandcli.cli.progress._SILENT", 0.03)
    with Progress(6, "study layer", each="run", lines=True) as progress:
        progress.step("rod: 3 s")
        time.sleep(0.2)
    lines = stream.getvalue().splitlines()
    assert lines[0] == "study layer: 1/6 rod: 3 s"
    assert set(lines[1:]) == {"study layer: at work on run 2 of 6"}


def test_long_runs_are_heard_of_without_a_terminal_too(monkeypatch: pytest.MonkeyPatch, clock: list[float]) -> None:
    stream = io.StringIO()
    monkeypatch.setattr("sys.stderr", stream)
    with Progress(3, "study", lines=True) as progress:
        progress.note("compiling step")
        progress.note("compiling depth")
        progress.step("rod, 8 substeps: 3 s")
    assert stream.getvalue() == "study: 1/3 rod, 8 substeps: 3 s\n"
    stream.truncate(0)
    stream.seek(0)
    with Progress(2000, "stress", each="case", lines=True) as progress:
        for _ in range(401):
            clock[0] += 0.1
            progress.step(count=1)
    assert stream.getvalue().splitlines() == [
        "stress: 200 of 2,000 cases, 3:00 left", "stress: 400 of 2,000 cases, 2:40 left"
    ]  # fmt: skip
    stream.truncate(0)
    with Progress(3, "study", hidden=True, lines=True) as progress:
        progress.note("compiling step")
        progress.step("rod")
    assert stream.getvalue().strip("\0") == ""
