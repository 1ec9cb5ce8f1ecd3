"""The cache of compiled kernels: where it is, when it is not used again, and that no state of it stops a run."""

from __future__ import annotations

import os
import shutil
import stat
import subprocess
import sys
import time
from pathlib import Path

import numba
import pytest

from cli_runs import TINY, environment
from strandcli import __version__, runtime
from strandcli.draw.zbuffer.kernels import raster
from strandcli.errors import UsageError

PACKAGE = Path(runtime.__file__).parent
RUN = """
import sys
from strand_kit import frames_of, scene_of
from strandcli import runtime
scene = scene_of('''
emitter: {strands: 9, particles: 3}
rules: [gravity, elasticity]
''')
lines = []
warnings = []
frames = frames_of(scene, 1, 3, draw=False, notify=lines.append, warn=warnings.append)
print(frames[1].positions.tobytes().hex())
print(len([line for line in lines if line.startswith("compiling ")]))
print(runtime.cache_folder())
print([line for line in lines if "cannot be loaded" in line][:1])
print(warnings)
"""


def run(cache: Path) -> list[str]:
    """What a small simulation in a process of its own prints: positions, kernels compiled, cache folder, complaint and
    warnings."""
    env = {**os.environ, "STRANDCLI_CACHE_DIR": str(cache), "PYTHONPATH": str(Path(__file__).parents[1])}
    done = subprocess.run([sys.executable, "-c", RUN], capture_output=True, text=True, env=env)
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    return done.stdout.split("\n")


@pytest.fixture(scope="module")
def warm(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, list[str]]:
    """A cache that holds the kernels of the small simulation, and what the first run said."""
    cache = tmp_path_factory.mktemp("cache")
    return cache, run(cache)


def test_kernels_are_compiled_once_and_then_loaded(warm: tuple[Path, list[str]]) -> None:
    cache, (positions, compiled, folder, complaint, warnings, _) = warm
    assert warnings == "[]"
    assert complaint == "[]"
    assert int(compiled) > 0
    assert Path(folder) == cache / f"{__version__}-{runtime.source_hash()}"
    assert stat.S_IMODE(Path(folder).stat().st_mode) == 0o700
    assert list(Path(folder).rglob("*.nbi"))
    again = run(cache)
    assert again[0] == positions
    assert again[1] == "0"


@pytest.mark.parametrize("pattern", ["*.nbi", "*.nbc"])
def test_truncated_cache_files_are_compiled_anew(warm: tuple[Path, list[str]], pattern: str) -> None:
    cache, (positions, *_) = warm
    damaged = list(cache.rglob(pattern))
    assert damaged
    for path in damaged:
        data = path.read_bytes()
        path.write_bytes(data[: len(data) // 2])
    again = run(cache)
    assert again[0] == positions
    assert int(again[1]) > 0
    assert "cached kernels cannot be loaded" in again[3]
    assert run(cache)[1] == "0"  # and what was damaged is whole again


def test_a_folder_that_cannot_be_written_stops_nothing(warm: tuple[Path, list[str]], tmp_path: Path) -> None:
    """Here because a file stands in its place; the kernels then live in a temporary folder as long as the process."""
    (tmp_path / "file").write_text("not a folder", encoding="utf-8")
    positions, compiled, folder, _, warnings, _ = run(tmp_path / "file" / "cache")
    assert positions == warm[1][0]
    assert int(compiled) > 0
    assert tmp_path not in Path(folder).parents
    assert not Path(folder).exists()
    assert f"{tmp_path / 'file' / 'cache'}" in warnings
    assert "every run will compile anew; point STRANDCLI_CACHE_DIR at" in warnings
    assert (tmp_path / "file").read_text(encoding="utf-8") == "not a folder"


def test_the_folders_name_follows_every_kernel_source(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Numba does not see that a function in another file has changed, so any edit has to give another folder."""
    copy = tmp_path / "strandcli"
    shutil.copytree(PACKAGE, copy, ignore=shutil.ignore_patterns("__pycache__"))
    monkeypatch.setattr(runtime, "__file__", str(copy / "runtime.py"))
    known = {runtime.source_hash()}
    assert known == {runtime.source_hash()}
    for name in (
        "draw/kernels/raster.py",
        "draw/kernels/approximations.py",
        "simulate/kernels/measure.py",
        "simulate/rules/wind.py",
        "simulate/rules/collision_segments.py",
        "simd/lanes.py",
        "constants.py",
        "jit.py",
    ):
        with open(copy / name, "a", encoding="utf-8") as source:
            source.write("\n# one more line\n")
        assert runtime.source_hash() not in known, name
        known.add(runtime.source_hash())
    (copy / "draw" / "kernels" / "film.py").rename(copy / "draw" / "kernels" / "cinema.py")
    assert runtime.source_hash() not in known
    now = runtime.source_hash()
    (copy / "pipeline.py").write_text("# no kernel\n", encoding="utf-8")
    assert runtime.source_hash() == now


def test_every_file_with_kernels_counts_for_the_folders_name() -> None:
    """Whatever is compiled lies where `source_hash` looks."""
    for path in PACKAGE.rglob("*.py"):
        text = path.read_text(encoding="utf-8")
        if path.name != "jit.py" and ("@parallel\n" in text or "@function\n" in text):
            inside = path.relative_to(PACKAGE).as_posix()
            assert "/kernels/" in inside or inside == "simulate/compose.py", inside


def test_only_old_kernels_of_ours_are_removed(tmp_path: Path) -> None:
    names = {
        "0.0.9-0123456789ab": True,
        "0.1.0-aaaaaaaaaaaa": False,  # in use
        "0.0.9-ffffffffffff": False,  # young
        "photographs": False,
        "0.0.9": False,
        "1.2.3-not-a-hash": False,
    }
    for name in names:
        (tmp_path / name).mkdir()
        (tmp_path / name / "data").write_text("kept", encoding="utf-8")
        if not name.endswith("ffff"):
            os.utime(tmp_path / name, (time.time() - 86_400 * 30,) * 2)
    (tmp_path / "0.0.8-0123456789ab").write_text("a file", encoding="utf-8")
    runtime._forget_old(tmp_path, keep=tmp_path / "0.1.0-aaaaaaaaaaaa")
    for name, gone in names.items():
        assert (tmp_path / name).exists() != gone, name
    assert (tmp_path / "0.0.8-0123456789ab").exists()


def test_the_machine_is_described() -> None:
    runtime.start(1)
    machine = runtime.machine()
    assert set(machine) == {
        "cpu", "cores", "threads", "threading_layer", "python", "numba", "llvm", "llvmlite"
    }  # fmt: skip
    assert machine["threads"] == 1
    assert machine["numba"] == numba.__version__
    assert machine["cpu"]
    runtime.start()
    assert runtime.machine()["threads"] == numba.config.NUMBA_NUM_THREADS
    with pytest.raises(UsageError):
        runtime.start(numba.config.NUMBA_NUM_THREADS + 1)


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        *(("NUMBA_NUM_THREADS", value, "must be a whole number from 1 to 4096")
          for value in ("0", "-1", "abc", "", "1.5", "4097", "100000")),
        ("NUMBA_DISABLE_JIT", "1", "unset it"),
    ],
)  # fmt: skip
def test_settings_of_numba_with_which_nothing_works_are_refused_in_one_line(
    tmp_path: Path, name: str, value: str, words: str
) -> None:
    (tmp_path / "one.yaml").write_text(TINY, encoding="utf-8")
    command = [sys.executable, "-m", "strandcli", "render", "one.yaml", "-f", "1", "-o", "a"]
    done = subprocess.run(
        command, cwd=tmp_path, env={**environment(), name: value}, capture_output=True, text=True, timeout=120
    )
    assert done.returncode == 2, done.stderr
    assert done.stdout == ""
    assert len(done.stderr.splitlines()) == 1, done.stderr
    assert done.stderr.startswith(f"strandcli: error: {name}")
    assert words in done.stderr


def test_kernels_are_compiled_without_shortcuts_in_arithmetic() -> None:
    """Fast maths would let pictures depend on the machine and on the number of threads."""
    for kernel in (raster.line, raster.visible):
        options = kernel.targetoptions
        assert not options.get("fastmath", False)
        assert options["error_model"] == "numpy"
        assert options["nogil"]
    assert raster.visible.targetoptions["parallel"]
