"""Kernels are run from a folder that is the user's alone, and what another user could have put there is not."""

from __future__ import annotations

import importlib
import os
import shutil
import stat
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from kernel_kit import begin, called, plus_three, plus_two
from strand_kit import scene_of
from strandcli import doctor
from strandcli.compiling import folder, stores, worker
from strandcli.compiling.clock import clock
from strandcli.compiling.service import service
from strandcli.doctor import NOTE
from strandcli.jit.array_cache import cached_arrays
from strandcli.run import pipeline


@pytest.fixture
def base(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """What STRANDCLI_CACHE_DIR names: nothing is there yet."""
    place = tmp_path / "cache"
    monkeypatch.setenv("STRANDCLI_CACHE_DIR", str(place))
    monkeypatch.setattr(service, "enabled", False)
    begin(monkeypatch)
    return place


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


@pytest.mark.parametrize("open_to", [0o770, 0o1777])
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
    (found,) = doctor.kernels()
    assert (found.state, found.text) == (NOTE, new.trouble)
    inner.chmod(0o755)  # that others may read does no harm
    assert begin(monkeypatch).path == inner
    assert called()


def test_kernels_in_another_users_folder_are_not_run(base: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert not called()
    me = os.getuid()
    monkeypatch.setattr(os, "getuid", lambda: me + 1)
    monkeypatch.setattr(stores, "ROOT", -1)  # who may run these tests
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
    assert f"{entry}: is not used (other users may change it): made anew" in told
    assert mode(entry) == 0o600
    assert called()
    me = os.getuid()
    monkeypatch.setattr(os, "getuid", lambda: me + 1)
    monkeypatch.setattr(stores, "ROOT", -1)
    assert not called()
    assert f"{entry}: is not used (it belongs to another user): made anew" in told


def test_a_module_in_the_cache_is_run_if_its_hash_is_the_one_in_its_name(
    base: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Workers read such modules; the process that has written one runs the text that it has."""
    place = folder.cache.path
    text = "value = 1\n"
    module = folder.module_of(text, "fuzzed", place)
    name, file = module.__name__, module.__file__
    monkeypatch.setattr(sys, "meta_path", [*sys.meta_path, worker.WrittenModules()])
    del sys.modules[name]
    assert importlib.import_module(name).value == 1
    del sys.modules[name]
    Path(file).write_text("value = 2\n", encoding="utf-8")
    with pytest.raises(ImportError, match="not what was written"):
        importlib.import_module(name)
    assert folder.module_of(text, "fuzzed", place).value == 1
    del sys.modules[name]


NOBODY = 65534


@pytest.fixture
def place(monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A folder that STRANDCLI_CACHE_DIR names, into which other users can look."""
    made = Path(tempfile.mkdtemp())
    made.chmod(0o755)
    monkeypatch.setenv("STRANDCLI_CACHE_DIR", str(made))
    monkeypatch.setattr(service, "enabled", False)
    begin(monkeypatch)
    yield made
    made.chmod(0o700)
    shutil.rmtree(made)


@contextmanager
def unwritable(inner: Path, owner: str, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """A block in which a folder is root's, or this user's own, who is not root, and cannot be written."""
    me = os.getuid()
    for one in (*inner.iterdir(), inner):
        one.chmod(0o555 if one == inner else 0o444)
        if me == 0 and owner == "mine":
            os.chown(one, NOBODY, -1)
    with monkeypatch.context() as patch:
        if me == 0:
            patch.setattr(os, "getuid", lambda: NOBODY)
            os.seteuid(NOBODY)
        elif owner == "root's":
            patch.setattr(os, "getuid", lambda: me + 1)
            patch.setattr(stores, "ROOT", me)
        try:
            yield
        finally:
            os.seteuid(me)
            inner.chmod(0o755)


def as_owner(path: Path, mode: int) -> None:
    """Change the rights of a file of another user."""
    now = os.geteuid()
    os.seteuid(path.stat().st_uid if now == NOBODY else now)
    path.chmod(mode)
    os.seteuid(now)


@pytest.mark.parametrize("owner", ["root's", "mine"])
def test_a_folder_that_cannot_be_written_is_read(owner: str, place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Kernels and arrays; what is not in it is compiled for this run alone, which is told once."""
    like, told = {"a": np.arange(3.0)}, list[str]()
    make = lambda: [np.arange(3.0)]  # noqa: E731
    assert not called()
    cached_arrays("table", ("strandcli.constants",), [1], like, make)
    inner = folder.cache.path
    before = {path.name for path in inner.iterdir()}
    with unwritable(inner, owner, monkeypatch):
        new = begin(monkeypatch)
        new.warn = told.append
        assert called()
        cached_arrays("table", ("strandcli.constants",), [1], like, lambda: pytest.fail("made again"))
        assert ([one.path for one in new.read_only], told) == ([inner], [])
        (found,) = doctor.kernels()
        assert "1 kernel or module" not in found.text
        assert "they are read, and cannot be written" in found.text
        assert not called(plus_two)
        assert not called(plus_three)
        assert told == [new.trouble]
        assert str(new.trouble).startswith(f"{inner}: is read and cannot be written: kernels that are not there, or")
        assert mode(new.path) == 0o700
        made = sorted(one.name.partition("-")[0] for one in new.path.glob("*.kernel"))
        assert made == ["kernel_kit.plus_three", "kernel_kit.plus_two"]
        assert not list(new.path.glob("*.arrays"))
    assert {path.name for path in inner.iterdir()} == before


def test_what_others_may_change_in_a_folder_that_cannot_be_written_is_not_run(
    place: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert not called()
    inner = folder.cache.path
    with unwritable(inner, "root's", monkeypatch):
        (entry,) = inner.glob("*.kernel")
        assert [one.path for one in begin(monkeypatch).read_only] == [inner]
        assert called()
        assert "not used" not in next(doctor.kernels()).text
        as_owner(entry, 0o646)
        begin(monkeypatch)
        assert not called()
        assert f"1 not used, such as {entry.name}: damaged, or writable by other users" in next(doctor.kernels()).text
        as_owner(entry, 0o444)
        as_owner(inner, 0o757)
        assert "other users may change it" in str(begin(monkeypatch).trouble)
        assert not folder.cache.read_only
        assert not called()


def test_a_run_tells_of_a_cache_that_keeps_nothing_and_not_of_one_that_is_read(monkeypatch: pytest.MonkeyPatch) -> None:
    scene = scene_of("emitter: {strands: 4, particles: 3}\nrules: []\n")
    for keeps_nothing in ("keeps nothing", None):
        monkeypatch.setattr(pipeline, "cache", SimpleNamespace(keeps_nothing=keeps_nothing))
        found: list[str] = []
        list(pipeline.render(scene, [1], draw=False, warn=found.append))
        assert found == [keeps_nothing] * (keeps_nothing is not None)
