"""Workers compile kernels, ahead of a frame those that it calls, end with their process, and are not needed."""

from __future__ import annotations

import dataclasses
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from numba import config

from kernel_kit import fresh, hits
from strand_kit import frames_of, groom_of, scene_of
from strandcli.compiling import folder, service
from strandcli.compiling.folder import module_of
from strandcli.compiling.service import PARTS
from strandcli.draw.common.kernels import approximations
from strandcli.draw.compile_parts import compile_part
from strandcli.draw.coverage.kernels import resolve, tile_binning
from strandcli.draw.film.film import curve_of
from strandcli.draw.film.kernels import film
from strandcli.draw.geometry.kernels import curves, ribbon
from strandcli.draw.lighting.kernels import shade_strands, shade_surfaces
from strandcli.draw.renderer import Renderer
from strandcli.draw.solids.kernels import visible
from strandcli.draw.view.kernels import project

pytestmark = pytest.mark.skipif(bool(config.DISABLE_JIT), reason="nothing is compiled")  # type: ignore[attr-defined]
ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty cache folder, and a service without workers yet."""
    monkeypatch.setattr(folder.cache, "_path", tmp_path)
    mine = service.Service()
    monkeypatch.setattr("strandcli.jit.cache.service", mine)
    monkeypatch.setenv("STRANDCLI_COMPILERS", "1")
    return tmp_path


def mine() -> service.Service:
    """The service of `place`."""
    from strandcli.jit import cache

    return cache.service


def test_a_worker_compiles_what_a_process_of_its_own_compiles_without_patches(place: Path) -> None:
    """The same pixels, whoever approximations."""
    values = np.linspace(-1.5, 1.5, 999, dtype=np.float32)
    image = np.random.default_rng(1).uniform(-0.1, 3, (24, 32, 3)).astype(np.float32)
    found = []
    for enabled in (True, False):
        mine().enabled = enabled
        kernels = [fresh(one) for one in (approximations.asin, approximations.exp, film.develop)]
        out = np.zeros((12, 16, 3), np.uint8)
        kernels[2](image, 2, np.float32(1.5), *curve_of("filmic"), out)
        found.append(np.concatenate([[kernel(x) for x in values] for kernel in kernels[:2]] + [out.ravel()]))
        assert [hits(kernel) for kernel in kernels] == [int(enabled)] * 3
        for path in place.glob("*.kernel"):
            path.unlink()
    mine().stop()
    np.testing.assert_array_equal(found[0], found[1])


def test_workers_compile_ahead_once_a_kernel_is_missing(place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    one, begun = mine(), []
    monkeypatch.setattr(one, "_begin_ahead", lambda *what: begun.append(what))
    monkeypatch.setattr(one, "_on_demand", lambda: None)
    one.ahead("first", 2)
    assert begun == [("first", 2)]  # there is no kernel at all
    fresh(approximations.asin)(np.float32(0.5))
    begun.clear()
    one.ahead("scene", 2)
    fresh(approximations.asin)(np.float32(0.5))
    assert begun == []
    fresh(approximations.exp)(np.float32(0.5))
    assert begun == [("scene", 2)]


@pytest.mark.skipif(not hasattr(os, "fork"), reason="there are no children")
def test_children_compile_what_a_frame_needs_and_their_parent_what_is_asked_for(
    place: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("STRANDCLI_COMPILERS", "2")
    mine().ahead(scene_of(SCENE), 2)
    kernel = fresh(approximations.asin)
    assert kernel(np.float32(0)) == 0
    assert hits(kernel) == 1
    until = time.monotonic() + 120
    wanted = ("surfaces-*", "strands-*", "develop-*", "resolve-*", "find-*", "flatten-*", "bin_segments-*")
    while not all(list(place.glob(f"*.{one}")) for one in wanted) and time.monotonic() < until:
        time.sleep(0.1)
    assert [one for one in wanted if not list(place.glob(f"*.{one}"))] == []
    mine().stop()


def test_a_folder_that_was_removed_meanwhile_ends_no_run(place: Path) -> None:
    place.rmdir()
    assert not service.nothing_compiled()
    mine().ahead(scene_of(SCENE), 2)
    assert mine()._worker is None
    place.mkdir()
    assert service.nothing_compiled()


PAIR = "from typing import NamedTuple\n\nclass Pair(NamedTuple):\n    a: float\n    b: float\n"
TOTAL = "from strandcli.jit import function\n\n@function\ndef total(pair):\n    return pair.a + pair.b\n"


def test_a_worker_knows_the_types_of_written_modules_and_runs_none_that_was_changed(place: Path) -> None:
    """Solids of a scene are such types: it would refuse to read the signature, and this process compile."""
    pair, total = (module_of(text, name, place) for text, name in ((PAIR, "pair"), (TOTAL, "total")))
    assert total.total(pair.Pair(1.0, 2.5)) == 3.5
    assert hits(total.total) == 1
    other, total = (module_of(text, name, place) for text, name in ((PAIR + "\n", "pair"), (TOTAL, "total")))
    ran = place / "ran"
    Path(other.__file__).write_text(f"open({str(ran)!r}, 'w')\n{PAIR}", encoding="utf-8")
    assert total.total(other.Pair(1.0, 2.5)) == 3.5
    assert hits(total.total) == 0
    assert not ran.exists()


def test_without_workers_kernels_are_compiled_here(place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("STRANDCLI_COMPILERS", "0")
    kernel = fresh(approximations.asin)
    assert kernel(np.float32(0)) == 0
    assert hits(kernel) == 0
    assert mine()._worker is None


def test_a_worker_that_ends_is_done_without_and_after_three_there_are_no_more(
    place: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(service, "PROGRAM", "import sys; sys.exit(1)")
    told: list[str] = []
    monkeypatch.setattr(folder.cache, "warn", told.append)
    monkeypatch.setattr(folder.cache, "_reported", set())
    for kernel in (approximations.asin, approximations.exp, approximations.exp2, approximations.acos):
        assert np.isfinite(fresh(kernel)(np.float32(0.5)))
    assert not mine().enabled
    assert told == [service.ALONE]


def alive(process: int) -> bool:
    """Whether a process runs; one that has ended and nobody has waited for does not."""
    try:
        return Path(f"/proc/{process}/stat").read_text(encoding="ascii").rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


PARENT = """
import sys, time
from pathlib import Path
from strandcli import load
from strandcli.compiling import folder
from strandcli.compiling.service import service
folder.cache.use(Path(sys.argv[1]))
service._begin_ahead(load("minimal"), 2)
worker = service._worker._process.pid
children = []
while service._usable() and not children:
    time.sleep(0.1)
    children = Path(f"/proc/{worker}/task/{worker}/children").read_text().split()
print(worker, *children, flush=True)
if sys.argv[2] == "waits": time.sleep(600)
"""


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="there is no /proc")
@pytest.mark.parametrize("ends", ["by itself", "killed"])
def test_workers_end_with_their_parent_however_that_ends(tmp_path: Path, ends: str) -> None:
    place = {**os.environ, "PYTHONPATH": str(ROOT), "STRANDCLI_COMPILERS": "2"}
    words = [sys.executable, "-c", PARENT, str(tmp_path), "waits" if ends == "killed" else "ends"]
    with subprocess.Popen(words, env=place, stdout=subprocess.PIPE, text=True) as parent:
        workers = [int(number) for number in parent.stdout.readline().split()]
        if ends == "killed":
            time.sleep(0.5)
            parent.send_signal(signal.SIGKILL)
        parent.wait()
    assert workers
    until = time.monotonic() + 30
    while any(alive(one) for one in workers) and time.monotonic() < until:
        time.sleep(0.05)
    assert not any(alive(one) for one in workers)
    assert not list(tmp_path.glob("*.part"))


CLAIM = """
import sys
from pathlib import Path
from strandcli.compiling.service import claims
claims.take(Path(sys.argv[1]), bytes(32))
print("taken", flush=True)
sys.stdin.read()
"""


def test_an_entry_is_claimed_by_one_process_until_it_ends(tmp_path: Path) -> None:
    words = [sys.executable, "-c", CLAIM, str(tmp_path)]
    place = {**os.environ, "PYTHONPATH": str(ROOT)}
    with subprocess.Popen(words, env=place, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as other:
        assert other.stdout.readline() == "taken\n"
        claims = service.Claims()
        claims.take(tmp_path, bytes([1] * 32))  # another entry
        assert claims.count() == 1
        began = time.monotonic()
        killer = subprocess.Popen(["sh", "-c", f"sleep 0.5; kill -9 {other.pid}"])
        claims.take(tmp_path, bytes(32))
        assert time.monotonic() - began > 0.3
        assert claims.count() == 2
        killer.wait()
    claims.release(0)
    assert claims.count() == 0


def test_a_forked_process_leaves_its_parents_workers_alone(place: Path) -> None:
    one = mine()
    worker = one._on_demand()
    assert worker is not None
    child = os.fork()
    if child == 0:
        one.stop()
        os._exit(0 if one._worker is None else 1)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0
    assert alive(worker._process.pid)
    one.stop()
    assert not alive(worker._process.pid)


SCENE = """
emitter: {strands: 1, particles: 2, length: 4, direction: [0, 1, 0], position: [0.05, -2, 1.5],
  shape: {kind: disc, radius: 0.000001}}
rules: []
camera: {kind: perspective, position: [0.1, 0.6, 5], target: [0, 0, 0], fov: 30}
image: {size: [64, 48], resolver: sorted}
curves: {mode: "off"}
material: {width: 0.004, taper: 0, colour: [0.1, 0.9, 0.2], specular: 0, diffuse: 0}
lights: []
solids: [{kind: sphere, radius: 0.5, position: [0.25, 0, 0], colour: [0.2, 0.2, 0.9]}]
"""
KERNELS = {
    "surfaces": (shade_surfaces.surfaces, visible.find),
    "strands": (shade_strands.strands, resolve.resolve, resolve.blend, film.develop),
    "coverage": (visible.find, ribbon.find_on_screen, tile_binning.bin_segments, resolve.resolve),
    "lines": (curves.flatten, project.points, project.widths),
}


@pytest.mark.parametrize("part", PARTS)
def test_a_part_compiles_what_a_frame_calls_and_nothing_else(part: str) -> None:
    scene = scene_of(SCENE)
    frames_of(scene, 1)
    drawn = {kernel: list(kernel.signatures) for kernel in KERNELS[part]}
    assert all(drawn.values())
    calls = {kernel: sum(kernel.stats.cache_hits.values()) for kernel in KERNELS[part]}
    small = dataclasses.replace(scene, image=dataclasses.replace(scene.image, size=(8, 8)))
    compile_part(Renderer(small, groom_of(scene)), part)
    assert {kernel: list(kernel.signatures) for kernel in KERNELS[part]} == drawn
    assert {kernel: sum(kernel.stats.cache_hits.values()) for kernel in KERNELS[part]} == calls
