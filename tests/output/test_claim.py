"""Two runs at once in one folder: each may have frames of its own, and none may have another's."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from cli_runs import TINY, Runner, environment
from strandcli.errors import RefusedError
from strandcli.output.claim import Claim
from strandcli.output.frames import FrameWriter

HOLD = """
import sys
from pathlib import Path
from strandcli.output.claim import Claim
folder, what, numbers = sys.argv[1:]
claim = Claim(Path(folder), what, eval(numbers))
print("claimed", flush=True)
sys.stdin.readline()
claim.release()
"""


@contextmanager
def another(folder: Path, what: str, numbers: list[int] | None) -> Iterator[subprocess.Popen[str]]:
    """Another process that has claimed files, until it is sent a line."""
    with subprocess.Popen(
        [sys.executable, "-c", HOLD, str(folder), what, repr(numbers)],
        env=environment(), text=True, stdin=subprocess.PIPE, stdout=subprocess.PIPE,
    ) as process:  # fmt: skip
        assert process.stdout is not None
        assert process.stdout.readline() == "claimed\n"
        try:
            yield process
        finally:
            process.kill()


def test_what_another_process_writes_is_refused_and_all_else_is_not(tmp_path: Path) -> None:
    with another(tmp_path, "frames", [1, 2, 3, 7]) as process:
        for numbers in ([3], [2, 10], [7, 8], [0, 1], None):
            with pytest.raises(RefusedError, match="another run is writing the same frames"):
                Claim(tmp_path, "frames", numbers)
        ours = Claim(tmp_path, "frames", [0, 4, 5, 6, 8, 9])
        Claim(tmp_path, "positions").release()
        process.communicate("\n")
        Claim(tmp_path, "frames", [100]).release()  # the other one has let go
        ours.release()
    assert os.listdir(tmp_path) == []


def test_where_there_are_no_locks_runs_go_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def none(*arguments: object) -> None:
        raise OSError(37, "No locks available")

    monkeypatch.setattr("fcntl.lockf", none)
    Claim(tmp_path, "frames", [1]).release()
    FrameWriter(tmp_path, [1], (4, 4))


@pytest.mark.parametrize(
    ("command", "what"), [(["render", "-f", "1-3", "--overwrite"], "frames"), (["simulate", "-f", "2"], "positions")]
)
def test_a_second_run_is_refused_in_one_line_before_anything_is_computed(
    tmp_path: Path, run: Runner, command: list[str], what: str
) -> None:
    (tmp_path / "tiny.yaml").write_text(TINY)
    (tmp_path / "out").mkdir()
    name, *options = command
    with another(tmp_path / "out", what, [2]):
        refused = run(name, "tiny.yaml", "-o", "out", *options)
        assert refused.code == 4
        assert f"out: another run is writing the same {what} there" in refused.error()
        assert os.listdir("out") == [f".{what}.lock"]
    assert run(name, "tiny.yaml", "-o", "out", *options).code == 0
    assert not [name for name in os.listdir("out") if name.startswith(".")]
