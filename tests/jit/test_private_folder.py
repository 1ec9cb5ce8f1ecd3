"""Kernels are run from a folder that is the user's alone, and what another user could have put there is not."""

from __future__ import annotations

import importlib
import os
import stat
import sys
from pathlib import Path

import pytest

from strandcli import written
from strandcli.compiling import folder, worker
from strandcli.compiling.clock import clock
from strandcli.compiling.service import service
from strandcli.doctor import kernels
from strandcli.doctor.finding import NOTE
from strandcli.jit import function
from strandcli.jit.dispatcher import KernelDispatcher

pytestmark = pytest.mark.skipif(not hasattr(os, "getuid"), reason="this system has no such owners")


@function
def plus_three(x):
    return x + 3


def called() -> bool:
    """Call the kernel as a new process does; return whether it came from the cache."""
    kernel = KernelDispatcher(plus_three.py_func, plus_three._cache._options)
    assert kernel(1) == 4
    return sum(kernel.stats.cache_hits.values()) == 1


@pytest.fixture
def base(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """What STRANDCLI_CACHE_DIR names: nothing is there yet."""
    place = tmp_path / "cache"
    monkeypatch.setenv("STRANDCLI_CACHE_DIR", str(place))
    monkeypatch.setattr(service, "enabled", False)
    begin(monkeypatch)
    return place


def begin(monkeypatch: pytest.MonkeyPatch) -> folder.Folder:
    """Choose the folder anew, as another process would."""
    new = folder.Folder()
    monkeypatch.setattr(folder, "cache", new)
    monkeypatch.setattr(kernels, "cache", new)
    return new


def mode(path: Path) -> int:
    return stat.S_IMODE(path.stat().st_mode)


def test_folders_and_files_that_strandcli_makes_are_the_users_alone(base: Path) -> None:
    mask = os.umask(0)
    try:
        assert not called()
    finally:
        os.umask(mask)
    inner = folder.cache.path
    assert inner.parent == base
    assert (mode(base), mode(inner)) == (0o700, 0o700)
    assert {mode(path) for path in inner.glob("*.kernel")} == {0o600}
    assert called()


@pytest.mark.parametrize("open_to", [0o770, 0o707, 0o777, 0o1777])
def test_kernels_in_a_folder_that_others_may_change_are_not_run(
    base: Path, monkeypatch: pytest.MonkeyPatch, open_to: int
) -> None:
    assert not called()
    inner = folder.cache.path
    before = {path.name for path in inner.iterdir()}
    inner.chmod(open_to)
    new = begin(monkeypatch)
    assert not called()
    assert new.trouble == (
        f"{inner}: kernels that lie there are not run, for other users may change it: every run will compile anew; "
        f"'chmod go-w {inner}' where it is yours, or point STRANDCLI_CACHE_DIR at a folder of your own"
    )
    assert mode(new.path) == 0o700  # a temporary one
    assert {path.name for path in inner.iterdir()} == before
    (found,) = kernels.kept()
    assert (found.state, found.text) == (NOTE, new.trouble)
    inner.chmod(0o755)  # that others may read does no harm
    assert begin(monkeypatch).path == inner
    assert called()


def test_kernels_in_another_users_folder_are_not_run(base: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert not called()
    me = os.getuid()
    monkeypatch.setattr(os, "getuid", lambda: me + 1)
    assert "it belongs to another user" in (begin(monkeypatch).trouble or "")
    monkeypatch.setattr(os, "getuid", lambda: me)
    assert called() is False  # the temporary folder was empty


def test_a_kernel_that_another_user_owns_or_may_change_is_not_run(base: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    told: list[str] = []
    monkeypatch.setattr(clock, "notify", told.append)
    assert not called()
    (entry,) = folder.cache.path.glob("*.kernel")
    entry.chmod(0o666)
    assert not called()
    assert f"{entry}: cached kernel cannot be loaded (other users may change it): compiling anew" in told
    assert mode(entry) == 0o600
    assert called()
    me = os.getuid()
    monkeypatch.setattr(os, "getuid", lambda: me + 1)
    assert not called()
    assert f"{entry}: cached kernel cannot be loaded (it belongs to another user): compiling anew" in told


def test_a_module_in_the_cache_is_run_if_its_hash_is_the_one_in_its_name(
    base: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Workers read such modules; the process that has written one runs the text that it has."""
    monkeypatch.setattr(written, "cache", folder.cache)
    place = folder.cache.path
    text = "value = 1\n"
    module = written.module_of(text, "fuzzed", place)
    name, file = module.__name__, module.__file__
    monkeypatch.setattr(sys, "meta_path", [*sys.meta_path, worker.WrittenModules()])
    del sys.modules[name]
    assert importlib.import_module(name).value == 1
    del sys.modules[name]
    Path(file).write_text("value = 2\n", encoding="utf-8")
    with pytest.raises(ImportError, match="not what was written"):
        importlib.import_module(name)
    assert written.module_of(text, "fuzzed", place).value == 1
    del sys.modules[name]
