"""Every place where a command writes fails once, in every way: one line, exit code 4, what was finished stays whole,
nothing half-written has a final name, and the next run leaves nothing behind.

`make faults` goes through all of it; otherwise a few places of each command, other ones each time, are tried, and
a few renders are killed, as `make kills` kills many.
"""

from __future__ import annotations

import builtins
import errno
import io
import json
import os
import random
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from unittest.mock import patch

import numpy as np
import pytest
from PIL import Image

import strandcli.output.files as written
from cli_runs import TINY, Runner
from kills import kills, terms

KINDS = {
    "disk full": errno.ENOSPC, "input/output error": errno.EIO, "no permission": errno.EACCES, "quota": errno.EDQUOT,
}  # fmt: skip
VANISHED = "folder vanished"
OPENING = os.O_WRONLY | os.O_RDWR | os.O_CREAT


class Faults:
    """Counts operations on files under a folder, in their order, and lets one of them fail; with ``sticky`` all that
    come after it, too."""

    def __init__(self, folder: Path, at: int | None = None, kind: str = "", sticky: bool = False) -> None:
        self.folder, self.at, self.kind, self.sticky = str(folder), at, kind, sticky
        self.seen: list[tuple[str, str]] = []
        """What was done and to which file."""
        self.hit: tuple[str, str] | None = None

    def mine(self, path: Any) -> bool:
        return isinstance(path, str | os.PathLike) and os.path.abspath(os.fsdecode(path)).startswith(self.folder + "/")

    def __call__(self, what: str, path: Any) -> None:
        """An operation is about to be carried out: raise what it is to fail with."""
        self.seen.append((what, os.path.abspath(os.fsdecode(path))))
        place = len(self.seen) - 1
        if self.at is None or place < self.at or (place > self.at and not self.sticky):
            return
        self.hit = self.hit or self.seen[place]
        if self.kind == VANISHED:
            shutil.rmtree(os.path.join(self.folder, "out"), ignore_errors=True)
            return
        raise OSError(KINDS[self.kind], os.strerror(KINDS[self.kind]), os.fsdecode(path))


class FaultyFile(io.FileIO):
    """A file whose writes may fail."""

    def __init__(self, faults: Faults, path: Any, mode: str) -> None:
        super().__init__(path, mode)
        self.faults = faults

    def write(self, data: Any) -> int:
        self.faults("write", self.name)
        return super().write(data)


@contextmanager
def injected(faults: Faults) -> Iterator[Faults]:
    """A block in which files under the folder are handled by way of ``faults``, whoever does it in this process."""
    plain = {"open": builtins.open, "os_open": os.open, "replace": os.replace, "mkdir": os.mkdir}

    def opened(file: Any, mode: str = "r", buffering: int = -1, *more: Any, **named: Any) -> Any:
        if not faults.mine(file) or not set(mode) & set("wax+"):
            return plain["open"](file, mode, buffering, *more, **named)
        faults("open", file)
        raw = FaultyFile(faults, os.fspath(file), mode.replace("b", "").replace("t", ""))
        binary = io.BufferedRandom(raw) if "+" in mode else io.BufferedWriter(raw)
        return binary if "b" in mode else io.TextIOWrapper(binary, **named)

    def os_opened(path: Any, flags: int, *more: Any, **named: Any) -> int:
        if faults.mine(path) and flags & OPENING:
            faults("open", path)
        found: int = plain["os_open"](path, flags, *more, **named)
        return found

    def renamed(source: Any, target: Any, **named: Any) -> None:
        if faults.mine(target):
            faults("rename", target)
        plain["replace"](source, target, **named)

    def made(path: Any, *more: Any, **named: Any) -> None:
        if faults.mine(path):
            faults("mkdir", path)
        plain["mkdir"](path, *more, **named)

    with (
        patch.object(builtins, "open", opened), patch.object(io, "open", opened), patch.object(os, "open", os_opened),
        patch.object(os, "replace", renamed), patch.object(os, "rename", renamed), patch.object(os, "mkdir", made),
    ):  # fmt: skip
        yield faults


ALL = os.environ.get("STRANDCLI_TEST_FAULTS") == "all"
FEW = 3
SMALL = ("--strands", 12, "--particles", 3, "--size", "16x12", "--threads", 1, "-q")
FILM = ("render", "tiny.yaml", *SMALL, "-f", "1-3", "-o", "out/film")
COMMANDS: dict[str, tuple[object, ...]] = {
    "render": FILM,
    "render with layers": (*FILM, "--aov", "depth,mask", "--animate", "gif,webp"),
    "render with checkpoints": (*FILM, "--checkpoint", 2),
    "simulate": ("simulate", "tiny.yaml", *SMALL, "-f", "1-2", "-o", "out/cache"),
    **{
        f"export .{kind}": ("export", "tiny.yaml", f"out/strands.{kind}", *SMALL, "-f", frames)
        for kind, frames in (("abc", "1-2"), ("usda", "1-2"), ("npz", 1), ("hair", "1-2"), ("ply", 1))
    },
    **{f"convert .{one}": ("convert", "in.npz", f"out/strands.{one}", "-q") for one in ("data", "usd", "abc")},
    "dataset": (
        "dataset", "in.npz", "--layout", "hairstep", "--views", 2, "--size", "16x16", "--threads", 1, "-q",
        "-o", "out/set",
    ),
    "study": ("study", "still.yaml", "--substeps", "1,2", "--threads", 1, "-q", "-o", "out/study"),
    "sheet": ("sheet", "a.png", "b.png", "-o", "out/sheet.png", "-q"),
    "compare": ("compare", "a.png", "b.png", "-o", "out/difference.png"),
    "golden": ("golden", "update", "out/golden", "one", "--threads", 1, "-q"),
    "info": ("info", "in.npz", "--picture", "out/picture.png"),
    "schema": ("schema", "-o", "out/schema.json"),
    "presets": ("presets", "copy", "fox", "out/fox.yaml"),
}  # fmt: skip
IN_CI = ("render with layers", "render with checkpoints", "simulate", "export .npz", "convert .abc", "sheet", "schema")
MISMATCH_IS_FINE = ("compare",)
"""Commands that end with 3 where all is well: the pictures differ."""


@pytest.fixture
def run(tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> Iterator[Runner]:
    monkeypatch.chdir(tmp_path)
    prepare(tmp_path / "out")
    (tmp_path / "tiny.yaml").write_text(TINY)
    (tmp_path / "still.yaml").write_text(TINY.replace("frames: 12", "frames: 2").replace("strands: 150", "strands: 9"))
    runner = Runner(tmp_path, capsys)
    assert runner("export", "tiny.yaml", "in.npz", *SMALL, "-f", 1).code == 0
    for number, name in enumerate("ab", 1):
        assert runner("render", "tiny.yaml", *SMALL, "-f", number, "-o", name).code == 0
        (tmp_path / name / f"frame_{number:04d}.png").rename(tmp_path / f"{name}.png")
    yield runner
    written._swept.clear()


def prepare(out: Path) -> None:
    """The folder of results, with the list of golden images."""
    (out / "golden").mkdir(parents=True, exist_ok=True)
    small = "size: 16x12, set: [emitter.strands=9]"
    (out / "golden/golden.yaml").write_text(f"- {{preset: minimal, name: one, frame: 1, {small}}}\n")


def files(folder: Path) -> dict[str, bytes]:
    """What lies under a folder, by name; locks are nobody's but their holders'."""
    found = [path for path in sorted(folder.rglob("*")) if path.is_file() and not path.name.endswith(".lock")]
    return {str(path.relative_to(folder)): path.read_bytes() for path in found}


def alike(name: str, found: bytes, whole: bytes, tmp_path: Path) -> bool:
    """Whether a file is one that a run writes: the same bytes, or where it holds times or statuses, whole."""
    if found == whole:
        return True
    if name.endswith((".json", ".csv", ".svg")) and found:
        return not name.endswith(".json") or isinstance(json.loads(found), dict)
    if name.endswith(".html"):  # holds times
        return found.startswith(b"<!doctype html>") and found.endswith(b"</html>\n")
    if name.endswith(".npz"):  # holds the time of day
        (tmp_path / "left.npz").write_bytes(found)
        (tmp_path / "right.npz").write_bytes(whole)
        with np.load(tmp_path / "left.npz") as left, np.load(tmp_path / "right.npz") as right:
            return set(left) == set(right) and all(np.array_equal(left[one], right[one]) for one in left)
    if name.endswith("cameras.usda"):  # lists the views that are there
        return found.endswith(b"}\n")
    if name.startswith("study/"):  # a chart of times
        Image.open(io.BytesIO(found)).load()
        return True
    return name.endswith((".usd", ".abc", ".usda")) and len(found) == len(whole)


def again(command: tuple[object, ...]) -> tuple[object, ...]:
    """The command once more, where something may lie already."""
    return command if command[0] in ("golden", "compare") else (*command, "--overwrite")


def plans(count: int, name: str) -> list[tuple[int, str, bool]]:
    """Which operation fails, how, and whether all after it do."""
    every = [(at, kind, sticky) for at in range(count) for kind in KINDS for sticky in (False, True)]
    every += [(at, VANISHED, False) for at in range(count)]
    if ALL:
        return every
    chance = random.Random(f"{name} {os.environ.get('PYTEST_XDIST_TESTRUNUID', '')}")
    return chance.sample(every, FEW)


@pytest.mark.parametrize("name", COMMANDS if ALL else IN_CI)
def test_faults(name: str, run: Runner, tmp_path: Path) -> None:
    command, out = COMMANDS[name], tmp_path / "out"
    fine = (0, 3) if name in MISMATCH_IS_FINE else (0,)
    with injected(Faults(tmp_path)) as counted:
        result = run(*command)
    assert result.code in fine, result.err
    whole = files(out)
    for at, kind, sticky in plans(len(counted.seen), name):
        written._swept.clear()
        for path in sorted(out.rglob("*"), reverse=True):
            path.unlink() if path.is_file() else path.rmdir()
        prepare(out)
        with injected(Faults(tmp_path, at, kind, sticky)) as faults:
            result = run(*command)
        case = (
            f"{name}: {kind} at {at} of {len(counted.seen)}, {faults.hit}, sticky: {sticky}: {result.code} {result.err}"
        )
        assert result.code in (4, *fine), case
        harmless = result.code in fine
        touched, where = faults.hit or ("", "")
        if not harmless:
            assert len(result.err.splitlines()) == 1, case
            assert "Traceback" not in result.err, case
            assert "unexpected" not in result.err, case
        else:  # a lock that cannot be had claims nothing; a folder may be there, or be made again
            assert kind == VANISHED or touched == "mkdir" or where.endswith(".lock"), case
        left = files(out)
        for one, data in left.items():
            assert one in whole, f"{case}: left {one}"
            assert alike(one, data, whole[one], tmp_path), f"{case}: {one} is not whole"
        prepare(out)
        result = run(*again(command))
        assert result.code in fine, f"{case}: then {result.err}"
        after = files(out)
        assert after.keys() == whole.keys(), case
        assert all(alike(one, after[one], whole[one], tmp_path) for one in whole), case


def test_killed_renders_lose_nothing(tmp_path: Path) -> None:
    for found in kills(range(4), tmp_path):
        assert found["frames that differ"] == found["frames missing"] == found["left behind"] == 0


def test_sigterm_ends_in_good_order(tmp_path: Path) -> None:
    (found,) = terms(range(1), tmp_path)
    assert found["done"] == 1, found
    assert found["temporary files"] == 0
