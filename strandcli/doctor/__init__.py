"""What `strandcli doctor` looks at: versions, Numba and its threads, processor, memory, disk, kernel cache, presets,
and what is optional. `examine` tells all of it, and draws a picture that is known."""

from __future__ import annotations

import importlib.util
import os
import platform
import re
import shutil
import sys
import tempfile
from collections.abc import Iterator
from importlib import metadata
from pathlib import Path
from typing import NamedTuple

from .. import __version__
from ..common import limits
from ..common.counted import counted
from ..common.extras import install
from ..compiling.folder import ENTRY, MOST_BYTES, cache
from ..compiling.runtime import checked_threads, cpu_name, require_addresses
from ..compiling.stores import Pack, writers
from ..errors import RefusedError, UsageError
from ..output.files import megabytes

OK, NOTE, BROKEN = "ok", "note", "broken"
"""All is well; worth knowing; strandcli does not work, or not rightly, until it is mended."""
LEAST = {"numba": (0, 61), "numpy": (1, 26), "pillow": (10, 3), "click": (8, 1), "pyyaml": (6, 0)}
"""Versions that pyproject.toml asks for."""
LEAST_PYTHON = (3, 11)
EXTRAS = {"OpenEXR": ("--exr", "exr"), "distributed": ("--dask", "dask"), "pxr": ("files of USD", "usd")}
"""Modules of extras: what they are for and the extra."""
WIDE = ("avx512f", "avx2", "avx", "sse4.2", "sve", "neon")
"""Vector instructions, widest first."""
LEAST_MEMORY, LEAST_DISK = 1_000_000_000, 500_000_000
"""Bytes: a frame of a shipped preset takes 600 MB of memory and less."""
FIRST_BYTES = b"strandcli kernel "
"""Of every kernel's file."""
LEAST_BYTES = 1000
"""The smallest kernel has some ten thousand; a file cut short by a full disk or a crash has fewer."""


class Finding(NamedTuple):
    """What was looked at, how it is, in words, and what to do ("" where there is nothing)."""

    check: str
    state: str
    text: str
    advice: str = ""


def judged(check: str, text: str, *cases: tuple[bool, str, str]) -> Finding:
    """The finding by the first case that holds, each a condition, a state and an advice; `OK` where none does."""
    return next((Finding(check, state, text, advice) for holds, state, advice in cases if holds),
                Finding(check, OK, text))  # fmt: skip


def versions() -> Iterator[Finding]:
    """Python and the packages that strandcli cannot do without."""
    found = {"Python": (".".join(map(str, sys.version_info[:3])), LEAST_PYTHON)}
    lost = []
    for name, least in LEAST.items():
        try:
            found[name] = metadata.version(name), least
        except metadata.PackageNotFoundError:
            lost.append(name)
    old = [f"{name} {version}" for name, (version, least) in found.items() if numbers(version) < least]
    known = ", ".join(f"{name} {version}" for name, (version, _) in found.items())
    text = f"strandcli {__version__}, {known}; {platform.system()} {platform.machine()}"
    for words, names in (("too old", old), ("missing", lost)):
        text += f"; {words}: {', '.join(names)}" if names else ""
    yield judged("versions", text, (bool(lost or old), BROKEN,
                                    "pip install --upgrade strandcli, with Python 3.11 or newer"))  # fmt: skip


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
    text += f"; set: {', '.join(mine)}" if mine else ""
    yield judged("numba", text, (bool(mine), NOTE, "unset them unless you mean them"))


def threading_layers() -> Iterator[Finding]:
    """OpenMP or TBB, by which several frames are drawn at once; Numba's own layer lets one thread in."""
    found = []
    for module, name in (("tbbpool", "TBB"), ("omppool", "OpenMP"), ("workqueue", "Numba's own")):
        try:
            importlib.import_module(f"numba.np.ufunc.{module}")
        except Exception:  # the library behind it is missing
            continue
        found.append(name)
    alone = found == ["Numba's own"]
    text = f"threading layers: {', '.join(found) or 'none'}" + (": frames are drawn one by one" if alone else "")
    better = "apt-get install libgomp1" if sys.platform.startswith("linux") else "pip install tbb"
    yield judged("threading", text, (not found, BROKEN, "pip install --force-reinstall numba"),
                 (alone, NOTE, f"{better}: several at once"))  # fmt: skip


def processor() -> Iterator[Finding]:
    """The processor and the vector instructions that LLVM uses of it."""
    try:
        import llvmlite.binding as llvm
    except Exception:  # reported by another check
        return
    features = llvm.get_host_cpu_features()
    known = [name for name in WIDE if features.get(name)] + (["fma"] if features.get("fma") else [])
    text = f"{cpu_name()}, {llvm.get_host_cpu_name()}: {', '.join(known) or 'no vector instructions'}"
    slow = platform.machine() in ("x86_64", "AMD64") and not features.get("avx2")
    yield judged("processor", text, (slow, NOTE, "without AVX2 kernels run at half the speed; the pictures are good"))


def threads() -> Iterator[Finding]:
    """Cores that there are, that this process may use, and the threads that it takes by default."""
    usable, quota = limits.cores(), limits.quota()
    try:
        count = checked_threads(None)
    except UsageError as error:
        yield Finding("threads", BROKEN, str(error), "unset the variable")
        return
    except ImportError:  # reported by another check
        return
    text = f"{count} by default; {counted(os.cpu_count() or 1, 'core')}, of which this process may use {usable}"
    if quota is not None:
        text += f", and {quota:g} cores' time by its control group"
    fewer = max(1, round(quota or 1))
    waiting = quota is not None and count > max(1.0, quota) + 0.5
    yield judged(
        "threads", text,
        (waiting, NOTE, f"threads wait for each other: take --threads {fewer} or NUMBA_NUM_THREADS={fewer}"),
        (count < usable and "NUMBA_NUM_THREADS" in os.environ, NOTE, "unset NUMBA_NUM_THREADS to use all cores"),
    )  # fmt: skip


def memory() -> Iterator[Finding]:
    """Memory that is free, for the system and for this process's control group."""
    free, most = limits.available_memory(), limits.memory()
    if free is None:
        yield Finding("memory", NOTE, "not known on this system", "'strandcli plan PRESET' reports what a run takes")
        return
    text = f"{megabytes(free)} free" + ("" if most is None else f", limit of its control group {megabytes(most)}")
    yield judged("memory", text, (free < LEAST_MEMORY, NOTE,
                                  "end other programs, or draw with smaller --size and fewer --strands"))  # fmt: skip


def disk() -> Iterator[Finding]:
    """Room and permission where frames go by default, and for temporary files."""
    for what, place in (("disk", Path.cwd()), ("temporary", Path(tempfile.gettempdir()))):
        free, locked = shutil.disk_usage(place).free, not os.access(place, os.W_OK)
        text = f"{place}: {megabytes(free)} free" + (", and no permission to write" if locked else "")
        yield judged(what, text, (locked, NOTE, "choose a folder for frames with -o"),
                     (free < LEAST_DISK, NOTE, "free some space, or choose another folder with -o"))  # fmt: skip


def bytecode() -> Iterator[Finding]:
    """Whether Python keeps its modules compiled; if not, each run compiles them again, which takes longer than a small
    picture."""
    spec = importlib.util.find_spec("numba")
    if spec is None or spec.origin is None:  # reported by another check
        return
    cached = importlib.util.cache_from_source(spec.origin)
    if os.path.exists(cached):
        yield Finding("bytecode", OK, f"kept in {os.path.dirname(cached)}")
        return
    never = sys.dont_write_bytecode
    text = "Python is set not to write any: each run starts a second later" if never else "none yet; Python writes it"
    once = f"python -m compileall -q {os.path.dirname(os.path.dirname(spec.origin))}"
    yield judged("bytecode", text, (never, NOTE, f"unset PYTHONDONTWRITEBYTECODE, or once, as in an image: {once}"))


def optional() -> Iterator[Finding]:
    """Extras, and ffmpeg, which none of the usual work needs."""
    there = [module for module in EXTRAS if importlib.util.find_spec(module) is not None]
    advice = [f"for {use}: {install(extra)}" for module, (use, extra) in EXTRAS.items() if module not in there]
    if shutil.which("ffmpeg"):
        there.append("ffmpeg")
    elif importlib.util.find_spec("imageio_ffmpeg") is not None:
        there.append("imageio-ffmpeg")
    else:
        advice.append(f"for --animate mp4: ffmpeg, or {install('video')}")
    yield Finding("extras", OK, ", ".join(there) or "none installed", "; ".join(advice))


def presets() -> Iterator[Finding]:
    """The presets that come with strandcli."""
    from ..scene.library import folder, list_presets

    count = len(list_presets())
    text = f"{count or 'none'} in {folder()}"
    yield judged("presets", text, (not count, BROKEN, "pip install --force-reinstall strandcli"))


def kernels() -> Iterator[Finding]:
    """Whether kernels are cached for the next run, in a folder of this user's alone, how many there are, and which
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
        text += f"; {len(broken)} not used, such as {broken[0].name}: damaged, or writable by other users"
        remedy = "have who may write there remove them and run 'strandcli warmup PRESET'"
        return Finding("cache", NOTE, text, "nothing: they are compiled anew when needed" if writable else remedy)
    if not writable:
        text += "; they are read, and cannot be written"
        advice = "nothing where all is there that is drawn; else have who may write there run 'strandcli warmup PRESET'"
        return Finding("cache", NOTE, text, advice)
    text += "" if entries else "; the first run compiles, about a minute"
    full = "nothing: what was not used for longest is removed once a day"
    return judged("cache", text, (size > MOST_BYTES, NOTE, full))


def damaged(entry: Path, folder: os.stat_result) -> bool:
    """Whether an entry is not used, for it clearly is none, or more than the owner of its folder may change it; a run
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
