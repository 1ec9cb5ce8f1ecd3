"""The cache of kernels: an entry is run only if it is what was written, and no state of the folder stops a run."""

from __future__ import annotations

import errno
import os
import random
import shutil
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from numba import config

from kernel_kit import called, fresh, hits, plus_one, plus_two
from strandcli.compiling import folder
from strandcli.compiling.clock import clock
from strandcli.compiling.service import service
from strandcli.jit import function, sources

pytestmark = pytest.mark.skipif(bool(config.DISABLE_JIT), reason="nothing is compiled")  # type: ignore[attr-defined]


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty cache folder."""
    monkeypatch.setattr(folder.cache, "_path", tmp_path)
    monkeypatch.setattr(folder.cache, "_trouble", None)
    monkeypatch.setattr(service, "enabled", False)
    return tmp_path


@pytest.fixture
def entry(place: Path) -> Path:
    """The entry of `plus_one` for an integer."""
    assert not called()
    (path,) = place.glob("*.plus_one-*.kernel")
    return path


@pytest.fixture
def told(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """What is told while kernels are loaded."""
    words: list[str] = []
    monkeypatch.setattr(clock, "notify", words.append)
    return words


def test_a_kernel_from_the_cache_is_read_whole_where_another_is_linked_with_it(place: Path) -> None:
    assert fresh(plus_one)(1) == 2
    loaded = fresh(plus_one)
    assert loaded(1) == 2
    assert hits(loaded) == 1
    (kernel,) = loaded.overloads.values()
    assert kernel.library._unread is not None

    @function
    def plus_three(x):
        return loaded(x) + 2

    assert plus_three(1) == 4
    assert kernel.library._unread is None
    assert kernel.library.get_pointer_to_function("no_such_function") == 0


def test_a_kernel_is_compiled_once_for_each_signature(place: Path) -> None:
    first = fresh(plus_one)
    assert (first(1), first(1.5)) == (2, 2.5)
    assert hits(first) == 0
    again = fresh(plus_one)
    assert (again(1), again(1.5)) == (2, 2.5)
    assert hits(again) == 2
    assert not list(place.glob("*.part"))


def damaged(data: bytes) -> Iterator[bytes]:
    """Truncated, longer, empty, and with one bit the other way round, from the first byte to the last."""
    yield from (b"", data[:10], data[: len(data) // 2], data[:-1], data + b"x")
    chance = random.Random(1)
    for k in (0, 19, 30, 51, len(data) - 1, *(chance.randrange(len(data)) for _ in range(9))):
        yield data[:k] + bytes([data[k] ^ 1 << chance.randrange(8)]) + data[k + 1 :]


def test_a_damaged_entry_is_noticed_and_costs_that_entry_alone(entry: Path, told: list[str]) -> None:
    assert fresh(plus_two)(1) == 3
    whole = entry.read_bytes()
    for content in damaged(whole):
        entry.write_bytes(content)
        assert not called()
        assert told[-2:] == [
            f"{entry}: is not used (its content is not what was written): made anew",
            "compiling plus_one",
        ]
        assert called()  # what was damaged is whole again
    assert called(plus_two)


def test_swapped_entries_are_not_run_as_each_other(entry: Path, place: Path) -> None:
    assert fresh(plus_two)(1) == 3
    (other,) = place.glob("*.plus_two-*.kernel")
    a, b = entry.read_bytes(), other.read_bytes()
    entry.write_bytes(b)
    other.write_bytes(a)
    assert (fresh(plus_one)(1), fresh(plus_two)(1)) == (2, 3)


@pytest.mark.parametrize("kind", ["folder", "folder with a file", "fifo", "link to nothing"])
def test_what_is_no_file_in_an_entrys_place_stops_nothing(entry: Path, kind: str) -> None:
    entry.unlink()
    if kind == "fifo":
        os.mkfifo(entry)
    elif kind == "link to nothing":
        entry.symlink_to(entry.with_name("nothing"))
    else:
        entry.mkdir()
        if kind != "folder":
            (entry / "mine").write_text("kept", encoding="utf-8")
    assert fresh(plus_one)(1) == 2
    if kind == "folder with a file":  # nobody but its owner removes that
        assert (entry / "mine").read_text(encoding="utf-8") == "kept"
    else:
        assert entry.is_file()


def test_a_full_disk_is_told_once_and_stops_nothing(place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    warnings: list[str] = []
    monkeypatch.setattr(folder.os, "replace", full)
    monkeypatch.setattr(folder.cache, "warn", warnings.append)
    assert (fresh(plus_one)(1), fresh(plus_two)(1)) == (2, 3)
    assert warnings == [
        f"{place}: compiled kernels cannot be kept there (No space left on device): every run will compile anew; "
        "point STRANDCLI_CACHE_DIR at a folder that can be written"
    ]
    assert not list(place.glob("*.part"))


def test_an_entry_follows_the_text_of_all_modules_that_a_kernel_is_made_of(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    package = tmp_path / "strandcli"
    shutil.copytree(sources.ROOT, package, ignore=shutil.ignore_patterns("__pycache__"))
    monkeypatch.setattr(sources, "ROOT", str(package))
    kernel, written = "strandcli.draw.coverage.kernels.resolve", "strandcli.solids.custom"
    counting = ("simd/lanes.py", "constants.py", "jit/__init__.py", "draw/coverage/kernels/resolve.py")
    others = (
        "pipeline.py", "__init__.py", "jit/cache.py", "jit/array_cache.py", "compiling/service.py",
        "simulate/rules/wind.py",
    )  # fmt: skip

    def digest(module: str = kernel) -> str:
        for one in vars(sources).values():
            if hasattr(one, "cache_clear"):
                one.cache_clear()
        return sources.digest(module)

    before, imports_from_the_package = digest(), digest(written)
    for name in others:
        (package / name).write_text("# other text\n", encoding="utf-8")
        assert (digest(), digest(written)) == (before, imports_from_the_package), name
    known = {before}
    for name in counting:
        with open(package / name, "a", encoding="utf-8") as text:
            text.write("\n# one more line\n")
        assert digest() not in known, name
        known.add(digest())
    monkeypatch.undo()
    digest()


def test_what_nobody_has_used_for_long_is_removed_and_nothing_that_is_not_ours(tmp_path: Path) -> None:
    mine = tmp_path / "kernels-0.1.0"
    mine.mkdir()
    old, now = time.time() - 40 * folder.DAY, time.time()
    entries = {
        f"raster.line-{'a' * 24}.kernel": (old, True), f"raster.line-{'b' * 24}.kernel": (now, False),
        f"step_{'c' * 16}.py": (old, True), "123-abc_def.part": (now - 3600, True), "124-abcdefg.part": (now, False),
        "notes.kernel": (old, False), "photo.jpg": (old, False),
    }  # fmt: skip
    folders = {"kernels-0.0.9": (old, True), "kernels-0.0.8": (now, False),
               "photographs": (old, False), "0.0.9": (old, False)}  # fmt: skip
    for name in entries:
        (mine / name).write_text("content", encoding="utf-8")
    for name in folders:
        (tmp_path / name).mkdir()
        (tmp_path / name / "data").write_text("content", encoding="utf-8")
    for place, found in ((mine, entries), (tmp_path, folders)):
        for name, (moment, _) in found.items():
            os.utime(place / name, (moment, moment))
    folder.sweep(tmp_path, mine)
    for place, found in ((mine, entries), (tmp_path, folders)):
        for name, (_, gone) in found.items():
            assert (place / name).exists() != gone, name


def test_the_entries_that_were_not_used_for_longest_go_where_there_are_too_many(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(folder, "MOST_BYTES", 2500)
    paths = [tmp_path / f"raster.line-{k:024x}.kernel" for k in range(4)]
    for k, path in enumerate(paths):
        path.write_bytes(b"x" * 1000)
        os.utime(path, (time.time() - 3600 * k,) * 2)
    folder.sweep(tmp_path, tmp_path)
    assert [path.exists() for path in paths] == [True, True, False, False]
