"""Settings with which nothing works are refused in one line; arithmetic has no shortcuts; signals wait for kernels."""

from __future__ import annotations

import os
import resource
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numba
import pytest
from numba.np.ufunc import parallel

from cli_runs import TINY, Runner, environment
from strandcli import doctor
from strandcli.cli import signals
from strandcli.compiling import runtime
from strandcli.compiling.interrupts import interrupts
from strandcli.doctor import BROKEN
from strandcli.draw.zbuffer.kernels import lines, raster
from strandcli.errors import UsageError


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        *(("NUMBA_NUM_THREADS", value, "must be a whole number from 1 to 4096")
          for value in ("0", "abc", "4097")),
        ("NUMBA_DISABLE_JIT", "1", "unset it"),
    ],
)  # fmt: skip
def test_settings_of_numba_with_which_nothing_works_are_refused_in_one_line(
    tmp_path: Path, name: str, value: str, words: str
) -> None:
    (tmp_path / "one.yaml").write_text(TINY, encoding="utf-8")
    command = [sys.executable, "-m", "strandcli", "render", "one.yaml", "-f", "1", "-o", "a"]
    done = subprocess.run(
        command, cwd=tmp_path, env={**environment(), name: value}, capture_output=True, text=True, timeout=120
    )
    assert done.returncode == 2, done.stderr
    assert done.stdout == ""
    assert len(done.stderr.splitlines()) == 1, done.stderr
    assert done.stderr.startswith(f"strandcli: error: {name}")
    assert words in done.stderr


def test_kernels_are_compiled_without_shortcuts_in_arithmetic() -> None:
    """Fast maths would let pictures depend on the machine and on the number of threads."""
    for kernel in (lines.draw_line, raster.draw_strands):
        options = kernel.targetoptions
        assert not options.get("fastmath", False)
        assert options["error_model"] == "numpy"
        assert options["nogil"]
    assert raster.draw_strands.targetoptions["parallel"]


def test_a_threading_layer_that_is_not_there_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(numba.config, "THREADING_LAYER", "nowhere")
    monkeypatch.setattr(parallel, "_is_initialized", False)
    with pytest.raises(UsageError, match=r"NUMBA_THREADING_LAYER=nowhere: .*[^.]; unset it"):
        runtime.checked_threads(None)
    monkeypatch.setattr(numba.config, "THREADING_LAYER", "default")
    assert runtime.checked_threads(None) >= 1


def test_too_few_addresses_for_the_libraries_are_refused(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, run: Runner
) -> None:
    monkeypatch.setattr(resource, "getrlimit", lambda _: (409_600_000, resource.RLIM_INFINITY))
    told = run.refused("render", "minimal", "-o", tmp_path / "out", code=4)
    assert "this process may use 410 MB of addresses, and the libraries take 800; raise the limit" in told
    assert not (tmp_path / "out").exists()
    assert run("presets").code == 0
    assert run("render", "--help").code == 0
    (found,) = doctor.numba_settings()
    assert (found.state, found.advice) == (BROKEN, "ulimit -v unlimited")
    monkeypatch.setattr(resource, "getrlimit", lambda _: (900_000_000, resource.RLIM_INFINITY))
    runtime.require_addresses()


def interrupted(work: Callable[[list[str]], None], number: int = signal.SIGINT) -> list[str]:
    """What ``work``, in which a signal comes, had done when that was raised."""
    done: list[str] = []
    kind = signals.Terminated if number == signal.SIGTERM else KeyboardInterrupt
    with signals.handled(), pytest.raises(kind):
        work(done)
    return done


def test_it_is_raised_at_the_end_of_the_block() -> None:
    def work(done: list[str]) -> None:
        with interrupts.deferred():
            with interrupts.deferred():
                os.kill(os.getpid(), signal.SIGTERM)
                done.append("inner")
            done.append("outer")
        done.append("never")

    assert interrupted(work, signal.SIGTERM) == ["inner", "outer"]


def test_where_it_is_allowed_it_is_raised_at_once() -> None:
    def work(done: list[str]) -> None:
        with interrupts.deferred(), interrupts.allowed():
            os.kill(os.getpid(), signal.SIGINT)
            done.append("never")

    assert interrupted(work) == []


def test_it_is_raised_where_a_wait_begins() -> None:
    def work(done: list[str]) -> None:
        with interrupts.deferred():
            os.kill(os.getpid(), signal.SIGINT)
            done.append("loading")
            with interrupts.allowed():
                done.append("never")

    assert interrupted(work) == ["loading"]
