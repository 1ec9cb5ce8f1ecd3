"""`strandcli stress`: the small matrix, replaying by name, and a preset's own scene."""

from __future__ import annotations

import json
import signal
import subprocess
import sys

import pytest

from cli_runs import Runner
from strandcli.study.stress import drive
from strandcli.study.stress import run as matrix
from strandcli.study.stress.matrix import AXES, case_named


@pytest.fixture(scope="module")
def small() -> matrix.Result:
    """The small matrix of both solvers."""
    return matrix.run(matrix.tasks(["rod", "thesis"], quick=True))


def test_the_small_matrix_of_the_source_is_as_it_is_known(small: matrix.Result) -> None:
    mine = [one for one in small.verdicts if one.name.partition("/")[0] == "thesis"]
    assert [one.name for one in mine if one.verdict == "fail"] == []
    assert any(one.verdict == "expected_failure" for one in mine)
    assert small.passed_after_all == []


def test_rods_fail_at_nothing_in_the_small_matrix(small: matrix.Result) -> None:
    mine = [one for one in small.verdicts if one.name.partition("/")[0] == "rod"]
    assert len(mine) > 70
    assert [(one.name, one.why) for one in mine if one.verdict != "pass"] == []
    measured = set().union(*(one.metrics for one in mine))
    assert measured >= {"nonfinite", "moved_by_nothing", "penetration", "residual", "stretch", "pinned_off"}


def test_the_command_lists_replays_and_tells(run: Runner) -> None:
    names = run("stress", "--list", "--solver", "thesis").out.split()
    assert len(names) > 18_000
    listed = run("stress", "--list", "--filter", "contact=through start=random dt=10").out.split()
    words = ("contact=through", "start=random", "dt=10")
    every = run("stress", "--list").out.split()
    assert listed == [name for name in every if all(word in name for word in words)]
    data = json.loads(run.fine("stress", "--case", "thesis/start=random/contact=through", "--json").out)
    assert set(data) >= {"solver", "cases", "summary"}
    (case,) = data["cases"]
    assert set(case) == {"name", "parameters", "metrics", "verdict", "why"}
    assert case["name"] == "thesis/contact=through/start=random"
    assert case["parameters"]["contact"] == "through"
    assert "pass" in run("stress", "--case", "thesis").out
    assert "no case has such a name" in run("stress", "--filter", "nothing").error()
    for empty in ("", "  "):  # as of a shell's variable that is not set
        assert "--filter: the text is empty" in run.refused("stress", "--filter", empty)


def test_a_failing_case_ends_in_exit_code_3_and_is_named(run: Runner, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(matrix.LIMITS, "stretch", ("<=", -1.0, "error"))
    result = run("stress", "--quick", "--solver", "thesis", "--filter", "*L=1e6*", "--no-progress")
    assert result.code == 3
    assert "again with: strandcli stress --case thesis/" in result.err
    assert "failed:" in result.out
    assert run("stress", "--case", "thesis/L=1e6").code == 3


def test_a_replay_gives_the_same_numbers(run: Runner) -> None:
    name = "thesis/dt=10/wind=gale/start=random"
    found = [json.loads(run("stress", "--case", name, "--json").out)["cases"] for _ in range(2)]
    assert found[0] == found[1]
    batch = drive.run([case_named(name).with_labels(start=start) for start in AXES["start"]])
    metrics = next(one.metrics for one in batch if one.case.name == name)
    assert found[0][0]["metrics"] == {key: float(f"{value:.4g}") for key, value in metrics.items()}


def test_a_process_ends_when_the_one_that_began_it_is_killed() -> None:
    code = (
        "import os, signal\n"
        "from concurrent.futures import ProcessPoolExecutor\n"
        "from multiprocessing import get_context\n"
        "from strandcli.study.stress import run\n"
        "pool = ProcessPoolExecutor(1, get_context('spawn'), initializer=run._begin)\n"
        "print(pool.submit(os.getppid).result() == os.getpid(), flush=True)\n"
        "os.kill(os.getpid(), signal.SIGKILL)\n"
    )
    # whoever is left holds on to the pipe of the standard output, and its end would not come
    found = subprocess.run([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True, timeout=60, check=False)
    assert found.stdout == "True\n"
    assert found.returncode == -signal.SIGKILL


def test_several_processes_come_to_the_same_verdicts() -> None:
    work = matrix.tasks(["thesis"], quick=True)
    assert len(work) >= 4 * matrix.CHUNK  # fewer are not worth a second process
    counted: list[int] = []
    shared = matrix.run(work, processes=2, done=lambda verdicts: counted.append(len(verdicts)))
    alone = matrix.run(work, processes=1)
    assert [one.as_dict() for one in shared.verdicts] == [one.as_dict() for one in alone.verdicts]
    assert sum(counted) == len(alone.verdicts)
