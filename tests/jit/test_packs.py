"""Packs: kernels as one file, which are run where they fit and are what was written, and are compiled elsewhere."""

from __future__ import annotations

import io
import json
import os
import random
import zipfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numba import config

from kernel_kit import begin, called
from strandcli import doctor
from strandcli.compiling import folder, processor, stores
from strandcli.compiling.service import service
from strandcli.errors import UsageError
from strandcli.jit import cache
from strandcli.jit.array_cache import STATES, cached_arrays, find, keep, key_of

pytestmark = pytest.mark.skipif(bool(config.DISABLE_JIT), reason="nothing is compiled")  # type: ignore[attr-defined]


class Home:
    """A user's cache with nothing in it, as a process that starts there sees it, and what that is warned of."""

    def __init__(self, place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        self.place, self.patch, self.number = place, monkeypatch, 0

    def begin(self, *paths: Path) -> list[str]:
        """An empty home, with these in STRANDCLI_CACHE_PATH; returns the list that warnings come into."""
        self.number += 1
        self.patch.setenv("STRANDCLI_CACHE_DIR", str(self.place / f"home {self.number}"))
        self.patch.setenv("STRANDCLI_CACHE_PATH", os.pathsep.join(map(str, paths)))
        told: list[str] = []
        begin(self.patch).warn = told.append
        return told


@pytest.fixture
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Home:
    monkeypatch.setattr(service, "enabled", False)
    monkeypatch.setattr(cache, "MADE_OF", {})
    monkeypatch.setattr(cache.array_cache, "FOR_PACKS", set())
    monkeypatch.setattr(folder, "SHIPPED", tmp_path / "none")
    return Home(tmp_path, monkeypatch)


@pytest.fixture
def pack(home: Home, tmp_path: Path) -> Path:
    """A pack of one kernel."""
    home.begin()
    assert not called()
    path = tmp_path / "one.pack"
    path.write_bytes(stores.packed(*cache.pack_content()))
    return path


def parts(data: bytes) -> dict[str, bytes]:
    """What is in a pack, by name."""
    with zipfile.ZipFile(io.BytesIO(data)) as found:
        return {name: found.read(name) for name in found.namelist()}


def changed(data: bytes, change: Callable[[dict[str, Any]], None]) -> bytes:
    """A pack, whole, that says something else of itself."""
    content = parts(data)
    made = json.loads(content.pop(stores.MANIFEST))
    change(made)
    return stores.packed(made, content)


def test_a_pack_is_run_and_nothing_is_compiled_or_written(home: Home, pack: Path) -> None:
    told = home.begin(pack)
    assert called()
    assert told == []
    assert not list(folder.cache.path.glob("*.kernel"))
    assert [one.text for one in doctor.kernels()][1].startswith(f"{pack}: pack of 1 kernel, ")
    (entry,) = (name for name in parts(pack.read_bytes()) if name != stores.MANIFEST)
    assert entry.startswith("kernel_kit.plus_one-")


def test_arrays_are_computed_for_a_pack_though_they_are_cached(home: Home) -> None:
    """What computes them belongs to it."""
    home.begin()
    made: list[int] = []
    for arrays in (True, True, False):
        folder.cache.arrays = arrays
        table = {"a": np.arange(3.0)}
        cached_arrays("table", ("strandcli.constants",), [1], table, lambda: made.append(1) or [np.arange(3.0)])
    assert len(made) == 2


def test_a_pack_has_the_states_in_which_first_frames_begin(home: Home, tmp_path: Path) -> None:
    home.begin()
    like, key = {"a": np.zeros(3)}, key_of(STATES, ("strandcli.constants",), [1])
    keep(STATES, key, {"a": np.arange(3.0)})
    path = tmp_path / "state.pack"
    path.write_bytes(stores.packed(*cache.pack_content()))
    assert home.begin(path) == []
    found = find(STATES, key, like)
    np.testing.assert_array_equal(found["a"], np.arange(3.0))
    assert find(STATES, key_of(STATES, ("strandcli.constants",), [2]), like) is None
    name, entry = next((name, data) for name, data in parts(path.read_bytes()).items() if name.endswith(".arrays"))
    made = json.loads(parts(path.read_bytes())[stores.MANIFEST])
    path.write_bytes(stores.packed(made, {name: entry[:-40] + bytes([entry[-40] ^ 1]) + entry[-39:]}))
    home.begin(path)
    assert find(STATES, key, like) is None


def test_a_wheels_own_pack_is_found_without_a_variable(home: Home, pack: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(folder, "SHIPPED", pack)
    home.begin()
    assert called()


def test_a_folder_of_another_user_is_read_if_nobody_else_may_change_it(home: Home, tmp_path: Path) -> None:
    home.begin()
    assert not called()
    shared = folder.cache.path
    if os.getuid() == 0:
        for one in (shared, *shared.iterdir()):
            os.chown(one, 65534, 65534)
    told = home.begin(shared.parent)
    assert (called(), told) == (True, [])
    shared.chmod(0o775)
    told = home.begin(shared.parent)
    assert not called()
    assert told == [
        f"{shared.parent}: is not run (other users may change it: 'chmod go-w {shared}' where it is yours): "
        "kernels are compiled instead"
    ]
    shared.chmod(0o755)
    (entry,) = shared.glob("*.kernel")
    entry.chmod(0o646)
    home.begin(shared.parent)
    assert not called()


def other(what: str) -> Callable[[dict[str, Any]], None]:
    def change(made: dict[str, Any]) -> None:
        made["with"][what] = "another"

    return change


def foreign(made: dict[str, Any]) -> None:
    made["processor"] = {"name": "x86-64-v9", "features": "+cmov,+avx4096"}


def of_other_sources(made: dict[str, Any]) -> None:
    made["sources"] = dict.fromkeys(made["sources"], "0" * 64)
    made["with"]["more"] = ""  # so that no kernel is found


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (other("Python"), "is not run, for its Python is another, and here it is "),
        (other("Numba"), "is not run, for its Numba is another, and here it is "),
        (other("llvmlite"), "is not run, for its llvmlite is another, and here it is "),
        (other("system"), "is not run, for its system is another, and here it is "),
        (foreign, "is not run, for it is for processors such as x86-64-v9, and this one has no avx4096"),
        (of_other_sources, "kernels such as those of kernel_kit are not run, for their sources have changed"),
    ],
)
def test_a_pack_of_other_surroundings_is_not_run_and_one_line_says_why(
    home: Home, pack: Path, change: Callable[[dict[str, Any]], None], words: str
) -> None:
    pack.write_bytes(changed(pack.read_bytes(), change))
    told = home.begin(pack)
    assert not called()
    (line,) = told
    assert line.startswith(f"{pack}: {words}")
    assert line.endswith(": kernels are compiled instead")


@pytest.mark.parametrize(
    "name", ["/etc/a.f-{}.kernel", "../a.f-{}.kernel", "a/b.f-{}.kernel", "a.f-{}.py", "", "C:\\f"]
)
def test_a_pack_with_names_that_are_no_kernels_is_refused(home: Home, pack: Path, name: str) -> None:
    content = parts(pack.read_bytes())
    made = json.loads(content.pop(stores.MANIFEST))
    pack.write_bytes(stores.packed(made, {**content, name.format("a" * 24): b"x"}))
    told = home.begin(pack)
    assert not called()
    (line,) = told
    assert line.startswith(f"{pack}: is not run (it holds ")


def test_what_is_no_pack_or_may_be_changed_by_others_is_refused(home: Home, pack: Path, tmp_path: Path) -> None:
    for mode in (0o664, 0o646):
        pack.chmod(mode)
        told = home.begin(pack)
        assert not called()
        assert told[0].startswith(f"{pack}: is not run (other users may change it")
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    for path, words in ((tmp_path / "none.pack", "No such file"), (pipe, "it is no file")):
        told = home.begin(path)
        assert not called()
        assert told[0].startswith(f"{path}: is not run ({words}")


def damages(data: bytes) -> Iterator[bytes]:
    """Two hundred packs: cut short, longer, with bytes replaced or turned, with whole ranges lost, and such as have a
    right hash all the same, for whoever made them computed it."""
    chance = random.Random(1)
    start = len(stores.MAGIC) + 65
    for _ in range(50):
        yield data[: chance.randrange(len(data))]
        place = chance.randrange(len(data))
        yield data[:place] + bytes([data[place] ^ 1 << chance.randrange(8)]) + data[place + 1 :]
        begin, end = sorted(chance.sample(range(start, len(data)), 2))
        rest = data[start:begin] + data[end:]
        yield stores.MAGIC + stores._hash(rest) + rest
        place = chance.randrange(start, len(data))
        rest = data[start:place] + chance.randbytes(8) + data[place + 8 :]
        yield stores.MAGIC + stores._hash(rest) + rest


def test_nothing_of_two_hundred_damaged_packs_is_run(home: Home, pack: Path) -> None:
    """The kernel is compiled, or is the one that was packed where the damage is in what is not looked at."""
    whole = pack.read_bytes()
    name, entry = next((name, data) for name, data in parts(whole).items() if name != stores.MANIFEST)
    compiled = 0
    for number, content in enumerate(damages(whole)):
        pack.write_bytes(content)
        told = home.begin(pack)
        if called():
            (store,) = folder.cache.read_only
            assert store.load(name, lambda file: file.read()) == entry, number
            continue
        compiled += 1
        assert len(told) == 1, number
        assert str(pack) in told[0]
    assert (number, compiled > 120) == (199, True)


def test_kernels_of_a_pack_are_checked_by_their_own_hash(home: Home, pack: Path) -> None:
    content = parts(pack.read_bytes())
    made = json.loads(content.pop(stores.MANIFEST))
    (name, entry) = content.popitem()
    for place in (0, 20, 60, len(entry) - 1):
        wrong = entry[:place] + bytes([entry[place] ^ 4]) + entry[place + 1 :]
        pack.write_bytes(stores.packed(made, {name: wrong}))
        told = home.begin(pack)
        assert not called()
        assert told == [f"{pack}/{name}: is not used (its content is not what was written): made anew"]


def test_only_processors_that_this_machine_has_are_compiled_for(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(processor.platform, "machine", lambda: "x86_64")
    monkeypatch.setattr(processor, "_features", lambda: dict.fromkeys(processor.V3, True))
    with pytest.raises(UsageError, match="this machine's processor has no avx512bw"):
        processor.choose("x86-64-v4")
    with pytest.raises(UsageError, match="this machine's processor is x86_64"):
        processor.choose("generic")
    with pytest.raises(UsageError, match="Numba has been imported"):
        processor.choose("x86-64-v3")
    assert "NUMBA_CPU_NAME" not in os.environ
    assert processor.lacking("+avx2,-sse4a,+amx-tile,+avx512f") == ["amx-tile", "avx512f"]
