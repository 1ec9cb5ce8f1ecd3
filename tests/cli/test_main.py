"""The command itself: help, errors as one line with the right exit code, and no heavy imports where none are needed."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import click
import pytest

from cli_runs import TINY, Runner, child, environment
from strandcli import __version__
from strandcli.cli import main as module
from strandcli.cli import signals
from strandcli.errors import MismatchError, RefusedError, SimulationError, UsageError


def raising(monkeypatch: pytest.MonkeyPatch, error: BaseException) -> None:
    """Make `strandcli schema` raise."""

    @click.command()
    def command() -> None:
        raise error

    monkeypatch.setattr("strandcli.cli.schema.command", command)


def test_help_lists_every_command_and_each_has_help_of_its_own(run: Runner) -> None:
    result = run.fine("--help")
    for name in module.COMMANDS:
        assert f"  {name} " in result.out
        assert f"Usage: strandcli {name}" in run.fine(name, "-h").out
    assert run("--version").out == f"strandcli {__version__}\n"
    assert run().code == 2


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["rendr"], "no command 'rendr'; did you mean 'render'?"),
        (["render"], "Missing argument 'PRESET|FILE'"),
        (["render", "tiny.yaml", "--colour"], "No such option"),
        (["render", "tiny.yaml", "--strands", "0"], "0 is not in the range 1<=x<=100000000"),
        (["render", "tiny.yaml", "--particles", "1"], "1 is not in the range 2<=x"),
        (["render", "tiny.yaml", "--size", "800"], "not a width and a height in pixels, such as 800x600"),
        (["render", "tiny.yaml", "--threads", "4096"], "4096 threads, but this process may use"),
        (["render", "tiny.yaml", "-f", "5-2"], "runs backwards"),
        (["render", "tiny.yaml", "-f", "1-13"], "frame 13, but the animation has frames 1 to 12"),
        (["render", "tiny.yaml", "--set", "seed"], "'seed' is not KEY=VALUE"),
        (["render", "tiny.yaml", "--animate", "avi"], "'avi' is not an animation that can be written"),
        (["render", "tiny.yaml", "--resume", "--overwrite"], "--overwrite and --resume exclude each other"),
        (["render", "tiny.yaml", "-q", "-v"], "--quiet and --verbose exclude each other"),
        (["simulate", "tiny.yaml"], "Missing option '-o'"),
        (["simulate", "tiny.yaml", "-o", ""], "the path is empty"),
        (["render", "tiny.yaml", "--from-cache", "tiny.yaml"], "tiny.yaml: has no manifest.json; it is no folder of"),
        (["golden"], "error: Missing command (see 'strandcli golden --help')"),
    ],
)
def test_wrong_usage_is_one_line_and_exit_code_2(run: Runner, arguments: list[str], words: str) -> None:
    result = run(*arguments)
    assert result.code == 2
    assert words in result.error()
    assert result.error().startswith("strandcli: error: ")
    assert result.out == ""
    assert os.listdir(run.folder) == ["tiny.yaml"]


def test_faults_of_a_preset_are_printed_plainly_each_on_its_line(run: Runner) -> None:
    (run.folder / "bad.yaml").write_text("title: x\nimage: {size: [0, 4]}\nemitter:\n  strandz: 5\n")
    for command in (["render", "bad.yaml"], ["plan", "bad.yaml"], ["simulate", "bad.yaml", "-o", "p"]):
        result = run(*command)
        assert result.code == 2
        assert len(result.err.splitlines()) == 2
        assert all(line.startswith("bad.yaml:") for line in result.err.splitlines())
        assert "bad.yaml:4:3: emitter.strandz: unknown key; did you mean 'strands'?" in result.err
    assert "strength" in run.refused("plan", "tiny.yaml", "--set", "wind.strenght=3")


@pytest.mark.parametrize(
    ("error", "code"),
    [
        (SimulationError("words"), 1),
        (UsageError("words"), 2),
        (MismatchError("words"), 3),
        (RefusedError("words"), 4),
        (MemoryError(), 4),
        (OSError(28, "words", "a"), 4),
        (OSError(5, "words", "a"), 1),
        (KeyboardInterrupt(), 130),
        (signals.Terminated(), 143),
        (signals.HungUp(), 129),
        (BrokenPipeError(), 1),
    ],
)
def test_every_ending_has_its_exit_code_and_one_line_at_most(
    run: Runner, monkeypatch: pytest.MonkeyPatch, error: BaseException, code: int
) -> None:
    raising(monkeypatch, error)
    monkeypatch.setattr(module, "_abandon_stdout", lambda: None)
    result = run("schema")
    assert result.code == code
    assert "Traceback" not in result.err
    if not isinstance(error, KeyboardInterrupt | BrokenPipeError):
        assert result.error().startswith("strandcli: error: ")
        assert isinstance(error, MemoryError) or "words" in result.error()


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="a device of Linux")
def test_where_standard_output_is_full_it_is_named(run: Runner) -> None:
    with open("/dev/full", "w") as full:
        done = subprocess.run(
            [sys.executable, "-m", "strandcli", "schema"],
            env=environment(), text=True, stdout=full, stderr=subprocess.PIPE, timeout=120,
        )  # fmt: skip
    assert (done.returncode, done.stderr) == (4, "strandcli: error: standard output: No space left on device\n")


@pytest.mark.parametrize("closed", [("stdout",), ("stderr",), ("stdout", "stderr")], ids=" and ".join)
def test_a_run_without_anybody_to_talk_to_is_a_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, closed: tuple[str, ...]
) -> None:
    for name in closed:
        monkeypatch.setattr(sys, name, None)
    preset = tmp_path / "tiny.yaml"
    preset.write_text(TINY)
    assert module.main(["plan", str(preset)]) == 0
    assert module.main(["simulate", str(preset), "-f", "1", "-o", str(tmp_path / "a")]) == 0
    assert module.main(["plan", "nonesuch"]) == 2


def test_a_bug_asks_to_be_reported_and_shows_itself_with_debug(run: Runner, monkeypatch: pytest.MonkeyPatch) -> None:
    raising(monkeypatch, ZeroDivisionError("of\ntwo lines"))
    assert "unexpected ZeroDivisionError: of two lines; please report it with" in run.refused("schema", code=1)
    result = run("--debug", "schema")
    assert result.code == 1
    assert "Traceback" in result.err
    assert result.err.splitlines()[-1] == "strandcli: error: unexpected ZeroDivisionError: of two lines"
    monkeypatch.setenv("STRANDCLI_DEBUG", "1")
    assert "Traceback" in run("schema").err


def test_a_swallowed_signal_is_raised_again() -> None:
    with signals.handled():
        signals.check()
        with pytest.raises(signals.Terminated):
            os.kill(os.getpid(), signal.SIGTERM)
        with pytest.raises(signals.Terminated):
            signals.check()
    with signals.handled():
        signals.check()


@pytest.mark.parametrize(("earlier", "code"), [("pass", 0), ("os.kill(os.getpid(), signal.SIGINT)", 130)])
def test_signals_while_python_ends_are_too_late_to_be_seen(run: Runner, earlier: str, code: int) -> None:
    """In what runs at exit, where a ``KeyboardInterrupt`` would be printed with a traceback."""
    program = (
        "import atexit, os, signal, sys\n"
        "from strandcli.cli import main as module\n"
        "atexit.register(lambda: [os.kill(os.getpid(), number) for number in (signal.SIGINT, signal.SIGTERM)])\n"
        f"def command(**options):\n    {earlier}\n"
        "module.cli.main = command\n"
        "sys.exit(module.main())\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], env=environment(), cwd=run.folder, capture_output=True, text=True
    )
    assert (done.returncode, done.stdout, done.stderr) == (code, "", "")


@pytest.mark.parametrize(
    ("arguments", "needed"),
    [
        (["--help"], []),
        (["--version"], []),
        # to emit the strands that its warnings are about, and to find the folder where the machine's speed is kept
        (["plan", "tiny.yaml"], ["numpy", "platformdirs"]),
    ],
)
def test_no_heavy_library_is_imported_where_nothing_is_drawn(
    run: Runner, arguments: list[str], needed: list[str]
) -> None:
    code = (
        "import sys\nfrom strandcli.cli.main import main\n"
        f"assert main({arguments!r}) == 0\n"
        "heavy = {'numba', 'llvmlite', 'numpy', 'PIL', 'pydantic', 'platformdirs'} & set(sys.modules)\n"
        "print(sorted(heavy), file=sys.stderr)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=run.folder, env=environment(), capture_output=True, text=True, check=True
    )
    assert done.stderr == f"{needed}\n"


def test_a_reader_who_leaves_early_causes_no_noise(run: Runner) -> None:
    process = child(run.folder, "schema")
    process.stdout.close()
    assert process.stderr.read() == ""
    assert process.wait(60) == 1


@pytest.mark.parametrize("no_color", [False, True])
def test_colour_is_for_terminals_that_want_it(run: Runner, no_color: bool) -> None:
    import pty

    leader, follower = pty.openpty()
    settings = {**environment(), "TERM": "xterm"}
    settings.pop("NO_COLOR", None)
    if no_color:
        settings["NO_COLOR"] = "1"
    subprocess.run(
        [sys.executable, "-m", "strandcli", "rendr"], env=settings, cwd=run.folder, stderr=follower, check=False
    )
    os.close(follower)
    words = os.read(leader, 4096).decode()
    os.close(leader)
    assert "no command 'rendr'" in words
    assert ("\x1b[" in words) is not no_color
