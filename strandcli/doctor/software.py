"""Versions, Numba's settings and threading layers, optional packages and programs."""

from __future__ import annotations

import importlib.util
import os
import platform
import re
import shutil
import sys
from collections.abc import Iterator
from importlib import metadata
from pathlib import Path

from .. import __version__
from ..common.counted import counted
from ..common.extras import install
from ..compiling.folder import ENTRY, MOST_BYTES, cache
from ..compiling.runtime import require_addresses
from ..compiling.stores import Pack, writers
from ..errors import RefusedError
from ..output.files import megabytes
from . import BROKEN, NOTE, OK, Finding

LEAST = {"numba": (0, 61), "numpy": (1, 26), "pillow": (10, 3), "click": (8, 1), "pyyaml": (6, 0)}
"""Versions that pyproject.toml asks for."""
LEAST_PYTHON = (3, 11)
EXTRAS = {"OpenEXR": ("--exr", "exr"), "distributed": ("--dask", "dask"), "pxr": ("files of USD", "usd")}
"""Modules of extras: what they are for and the extra."""


def versions() -> Iterator[Finding]:
    """Python and the packages that strandcli cannot do without."""
    here = ".".join(map(str, sys.version_info[:3]))
    told = [f"strandcli {__version__}", f"Python {here}"]
    old = [f"Python {here}"] if sys.version_info[:2] < LEAST_PYTHON else []
    lost = []
    for name, least in LEAST.items():
        try:
            version = metadata.version(name)
        except metadata.PackageNotFoundError:
            lost.append(name)
            continue
        told.append(f"{name} {version}")
        if numbers(version) < least:
            old.append(f"{name} {version}")
    text = f"{', '.join(told)}; {platform.system()} {platform.machine()}"
    if lost or old:
        wrong = "; ".join(
            ([f"too old: {', '.join(old)}"] if old else []) + ([f"missing: {', '.join(lost)}"] if lost else [])
        )
        yield Finding(
            "versions", BROKEN, f"{text}; {wrong}", "pip install --upgrade strandcli, with Python 3.11 or newer"
        )
    else:
        yield Finding("versions", OK, text)


def numbers(version: str) -> tuple[int, ...]:
    """The first two numbers of a version."""
    return tuple(int(one) for one in re.findall(r"[0-9]+", version)[:2])


def numba_settings() -> Iterator[Finding]:
    """Numba, its compiler, and variables that change what it does."""
    try:
        require_addresses()
    except RefusedError as error:
        yield Finding("numba", BROKEN, str(error), "ulimit -v unlimited")
        return
    try:
        import llvmlite.binding as llvm
        import numba
    except Exception as error:  # what a broken installation raises may be anything
        yield Finding("numba", BROKEN, f"cannot be imported: {error}", "pip install --force-reinstall numba llvmlite")
        return
    text = f"LLVM {'.'.join(map(str, llvm.llvm_version_info))}, llvmlite {metadata.version('llvmlite')}"
    if numba.config.DISABLE_JIT:  # type: ignore[attr-defined]
        yield Finding("numba", BROKEN, f"{text}; NUMBA_DISABLE_JIT is set", "unset NUMBA_DISABLE_JIT")
        return
    mine = sorted(name for name in os.environ if name.startswith("NUMBA_") and name != "NUMBA_NUM_THREADS")
    if mine:
        yield Finding("numba", NOTE, f"{text}; set: {', '.join(mine)}", "unset them unless you mean them")
    else:
        yield Finding("numba", OK, text)


def threading_layers() -> Iterator[Finding]:
    """OpenMP or TBB, by which several frames are drawn at once; Numba's own layer lets one thread in."""
    found = []
    for module, name in (("tbbpool", "TBB"), ("omppool", "OpenMP"), ("workqueue", "Numba's own")):
        try:
            importlib.import_module(f"numba.np.ufunc.{module}")
        except Exception:  # the library behind it is missing
            continue
        found.append(name)
    text = f"threading layers: {', '.join(found) or 'none'}"
    if not found:
        yield Finding("threading", BROKEN, text, "pip install --force-reinstall numba")
    elif found == ["Numba's own"]:
        install = "apt-get install libgomp1" if sys.platform.startswith("linux") else "pip install tbb"
        yield Finding("threading", NOTE, f"{text}: frames are drawn one by one", f"{install}: several at once")
    else:
        yield Finding("threading", OK, text)


def bytecode() -> Iterator[Finding]:
    """Whether Python keeps its modules compiled; if not, each run compiles them again, which takes longer than a small
    picture."""
    spec = importlib.util.find_spec("numba")
    if spec is None or spec.origin is None:  # told by another check
        return
    kept = importlib.util.cache_from_source(spec.origin)
    if os.path.exists(kept):
        yield Finding("bytecode", OK, f"kept in {os.path.dirname(kept)}")
    elif sys.dont_write_bytecode:
        yield Finding(
            "bytecode", NOTE, "Python is set not to write any: each run starts a second later",
            "unset PYTHONDONTWRITEBYTECODE, or once, as in an image: python -m compileall -q "
            f"{os.path.dirname(os.path.dirname(spec.origin))}",
        )  # fmt: skip
    else:
        yield Finding("bytecode", OK, "none yet; Python writes it where it may")


def optional() -> Iterator[Finding]:
    """Extras, and ffmpeg, which none of the usual work needs."""
    there, ways = [], []
    for module, (use, extra) in EXTRAS.items():
        if importlib.util.find_spec(module) is not None:
            there.append(module)
        else:
            ways.append(f"for {use}: {install(extra)}")
    if shutil.which("ffmpeg"):
        there.append("ffmpeg")
    elif importlib.util.find_spec("imageio_ffmpeg") is not None:
        there.append("imageio-ffmpeg")
    else:
        ways.append(f"for --animate mp4: ffmpeg, or {install('video')}")
    yield Finding("extras", OK, ", ".join(there) or "none installed", "; ".join(ways))


def presets() -> Iterator[Finding]:
    """The presets that come with strandcli."""
    from ..scene.library import folder, list_presets

    found = list_presets()
    if found:
        yield Finding("presets", OK, f"{len(found)} in {folder()}")
    else:
        yield Finding("presets", BROKEN, f"{folder()}: holds none", "pip install --force-reinstall strandcli")


FIRST_BYTES = b"strandcli kernel "
"""Of every kernel's file."""
LEAST_BYTES = 1000
"""The smallest kernel has some ten thousand; a file cut short by a full disk or a crash has fewer."""


def kept() -> Iterator[Finding]:
    """Whether kernels are kept for the next run, in a folder of this user's alone, how many there are, and which
    folders and packs are read beside it."""
    for words in cache.refused:
        yield Finding("cache", NOTE, words)
    if cache.keeps_nothing:
        yield Finding("cache", NOTE, cache.keeps_nothing)
    elif cache.trouble is None:
        yield _folder(cache.path)
    for store in cache.read_only:
        if isinstance(store, Pack):
            size = store.path.stat().st_size
            yield Finding("cache", OK, f"{store.path}: pack of {counted(len(store), 'kernel')}, {megabytes(size)}")
        else:
            yield _folder(store.path, writable=False)


def _folder(folder: Path, writable: bool = True) -> Finding:
    """What a folder has."""
    entries = [one for one in folder.iterdir() if ENTRY.fullmatch(one.name)]
    size = sum(one.lstat().st_size for one in entries)
    text = f"{folder}: {counted(len(entries), 'kernel or module', 'kernels and modules')}, {megabytes(size)}"
    broken = [one for one in entries if damaged(one, folder.stat())]
    if broken:
        some = f"{len(broken)} not used, such as {broken[0].name}: damaged, or writable for others"
        advice = "nothing: they are compiled anew when they are needed"
        if not writable:
            advice = "have who may write there remove them and run 'strandcli warmup PRESET'"
        return Finding("cache", NOTE, f"{text}; {some}", advice)
    if not writable:
        text += "; they are read, and cannot be written"
        advice = "nothing where all is there that is drawn; else have who may write there run 'strandcli warmup PRESET'"
        return Finding("cache", NOTE, text, advice)
    if size > MOST_BYTES:
        return Finding("cache", NOTE, text, "nothing: what was not used for longest is removed once a day")
    return Finding("cache", OK, text + ("" if entries else "; the first run compiles, about a minute"))


def damaged(entry: Path, folder: os.stat_result) -> bool:
    """Whether an entry is not used, for it clearly is none, or others than who owns its folder may change it; a run
    looks closer, at a hash of its content."""
    try:
        if writers(entry.lstat(), folder.st_uid):
            return True
        if entry.suffix != ".kernel":
            return False
        if not entry.is_file() or entry.stat().st_size < LEAST_BYTES:
            return True
        with entry.open("rb") as file:
            return file.read(len(FIRST_BYTES)) != FIRST_BYTES
    except OSError:
        return True
