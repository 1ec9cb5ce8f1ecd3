"""Files are whole or absent, folders are refused before any work, and of two runs at once none has the other's."""

from __future__ import annotations

import errno
import json
import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from cli_runs import TINY, Runner, environment
from strandcli.errors import RefusedError
from strandcli.output import files
from strandcli.output.claim import Claim
from strandcli.output.frames import FrameWriter


def test_a_failure_leaves_the_old_file_and_nothing_else(tmp_path: Path) -> None:
    path = tmp_path / "a.bin"
    path.write_bytes(b"old")

    def pieces() -> Iterator[bytes]:
        yield b"new, but only half of it"
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        files.write_pieces(path, pieces())
    assert path.read_bytes() == b"old"
    assert os.listdir(tmp_path) == ["a.bin"]
    files.write_pieces(path, [b"ne", b"w"])
    assert path.read_bytes() == b"new"
    assert os.listdir(tmp_path) == ["a.bin"]


@pytest.mark.parametrize(
    ("number", "words"),
    [(errno.ENOSPC, "disk is full"), (errno.EACCES, "no permission"), (errno.EROFS, "read-only")],
)
def test_the_system_s_refusals_become_one_clear_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, number: int, words: str
) -> None:
    def fail(source: object, target: object) -> None:
        raise OSError(number, os.strerror(number))

    monkeypatch.setattr(os, "replace", fail)
    with pytest.raises(RefusedError, match=words) as caught:
        files.write_pieces(tmp_path / "a.bin", [b"x"])
    assert "a.bin" in str(caught.value)
    assert "--resume" not in str(caught.value)  # which most commands do not have
    assert "\n" not in str(caught.value)
    assert os.listdir(tmp_path) == []


def test_what_a_stopped_library_has_begun_beside_its_file_goes_too(tmp_path: Path) -> None:
    (tmp_path / "b.usd").write_bytes(b"old")

    def stop() -> None:
        with files.placed(tmp_path / "b.usd", ".usd") as temporary:
            temporary.write_bytes(b"half")
            temporary.with_name(f"{temporary.stem}.Z3tJAN").write_bytes(b"half")
            raise ValueError("stopped")

    with pytest.raises(ValueError, match="stopped"):
        stop()
    assert os.listdir(tmp_path) == ["b.usd"]


def test_json_is_whole_and_has_no_nan(tmp_path: Path) -> None:
    files.write_json(tmp_path / "a.json", {"é": [1, None]})
    assert json.loads((tmp_path / "a.json").read_text(encoding="utf-8")) == {"é": [1, None]}
    with pytest.raises(ValueError, match="JSON"):
        files.write_json(tmp_path / "b.json", {"x": float("nan")})
    assert os.listdir(tmp_path) == ["a.json"]


def test_strays_of_dead_processes_go_and_those_of_living_ones_stay(tmp_path: Path) -> None:
    mine = files.temporary_name(tmp_path / "frame_0001.png")
    dead = mine.with_name(mine.name.replace(str(os.getpid()), "4194399"))
    elsewhere = tmp_path / ".frame_0002.png.another-host.4194399.tmp"
    old = tmp_path / ".frame_0003.png.another-host.7.tmp"
    foreign = tmp_path / ".something.tmp"
    for path in (mine, dead, elsewhere, old, foreign):
        path.write_bytes(b"half")
    os.utime(old, (0, 0))
    assert set(files.remove_strays(tmp_path)) == {dead, old}
    assert set(tmp_path.iterdir()) == {mine, elsewhere, foreign}


def test_a_folder_without_room_is_refused_with_the_estimate(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(shutil, "disk_usage", lambda path: shutil._ntuple_diskusage(10**9, 10**9, 5_000_000))
    with pytest.raises(RefusedError, match="about 12 MB are needed and 5 MB are free"):
        files.prepare_folder(tmp_path / "out", 12_000_000)
    files.prepare_folder(tmp_path / "out", 4_000_000)
    assert list((tmp_path / "out").iterdir()) == []


def test_a_folder_that_takes_no_files_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(self: Path, data: bytes) -> int:
        raise PermissionError(errno.EACCES, "Permission denied", str(self))

    monkeypatch.setattr(Path, "write_bytes", fail)
    with pytest.raises(RefusedError, match="no permission to write there"):
        files.prepare_folder(tmp_path, 0)


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
        refused = run.refused(name, "tiny.yaml", "-o", "out", *options, code=4)
        assert f"out: another run is writing the same {what} there" in refused
        assert os.listdir("out") == [f".{what}.lock"]
    assert run(name, "tiny.yaml", "-o", "out", *options).code == 0
    assert not [name for name in os.listdir("out") if name.startswith(".")]
