"""Read damaged files of all that strandcli reads: ``python tests/fuzz.py [COUNT [FORMAT …]]``, and a slice of it in the
tests.

A file is mutated in a few bytes, words or blocks, cut off, or lengthened, and read. It must be read or refused in one
line (`StrandError`), within seconds and within three times its size and 100 MB: more ends in MemoryError here, and that
is a fault too. Presets and files of earlier runs go through the command line where that reads them: exit codes 0, 2 and
4, within a second of processor time. No file is written outside the folder of the run and nothing is unpickled
(`fuzz_guard`). What is found is printed with the number that makes it again.
"""

from __future__ import annotations

import contextlib
import ctypes
import json
import resource
import signal
import subprocess
import sys
import tempfile
import time
import warnings
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from types import FrameType

import numpy as np

from exchange_kit import moments
from fuzz_changes import checksums_right, mutated, mutated_header
from fuzz_guard import guarded
from fuzz_presets import remember_shipped
from fuzz_seeds import CAMERA, COLMAP, MESH, seeds
from fuzz_written import KINDS
from strandcli.cameras.read import views_of
from strandcli.compiling.folder import cache
from strandcli.errors import StrandError
from strandcli.exchange.facts import facts
from strandcli.exchange.files import ReadOptions, read
from strandcli.meshes.facts import facts as facts_of_mesh
from strandcli.meshes.read import read_mesh

MEMORY = Path("/dev/shm")
"""Where files are written fastest."""
LONGEST, PATIENCE = 10, 300
"""Seconds of a processor, and of a clock, for a hundred files."""
MOST = 100_000_000
"""Bytes beyond three times the file."""


class TooLongError(Exception):
    """Reading took more than `LONGEST` or `PATIENCE`."""


def _stop(number: int, frame: FrameType | None) -> None:
    raise TooLongError


def attempt(content: bytes, suffix: str, folder: Path) -> str:
    """What becomes of a file: "read", "refused", or what is wrong."""
    path = folder / (suffix.removeprefix(CAMERA) if suffix.startswith(CAMERA) else f"a{suffix}")
    if suffix not in KINDS:
        path.write_bytes(content)
    warnings.simplefilter("error")
    try:
        if suffix in KINDS:
            return KINDS[suffix].attempt(content, folder)
        if suffix.startswith(CAMERA):
            return attempt_cameras(path)
        if suffix.startswith(MESH):
            return attempt_mesh(path)
        strands = read(path, ReadOptions(lenient=len(content) % 2 == 0))
        if len(content) % 5 == 0:
            json.dumps(facts(strands), allow_nan=False)
        sound = strands.first[0] == 0 and strands.first[-1] == strands.points.shape[0]
        if not sound or (strands.counts() < 2).any():
            return "strands that are none"
        if any(one.points.shape != strands.points.shape for one in moments(path, ReadOptions(lenient=True))):
            return "moments of other strands"
        return "read"
    except StrandError as error:
        text = str(error)
        return "refused" if text.isprintable() and len(text) < 600 else f"a message as this: {text!r:.80}"
    except Exception as error:
        return f"{type(error).__name__}: {error}"


def attempt_mesh(path: Path) -> str:
    """The same of a mesh; raises what reading raises."""
    mesh = read_mesh(path)
    json.dumps(facts_of_mesh(mesh), allow_nan=False)
    numbers = (mesh.vertices, mesh.normals, mesh.uv, mesh.corner_normals, mesh.colours, *mesh.attributes.values())
    if not all(np.isfinite(one).all() for one in numbers if one is not None):
        return "numbers that are not finite"
    sound = mesh.triangles.min() >= 0 and mesh.triangles.max() < mesh.vertices.shape[0]
    return "read" if sound and (mesh.areas() > 0).all() else "triangles that are none"


def attempt_cameras(path: Path) -> str:
    """The same of views."""
    for name in COLMAP if path.name in COLMAP else ():
        if name != path.name:
            (path.parent / name).write_bytes(seeds()[f"{CAMERA}{name}"][0])
    for view in views_of(path, assumed=(64, 48)).views:
        numbers = (view.rotation, view.eye, view.centre, view.focal, 0 if view.near is None else view.near)
        if not all(np.isfinite(one).all() for one in numbers):
            return "numbers that are not finite"
        if min(view.width, view.height) < 1 or view.focal <= 0 or (view.near is not None and view.near <= 0):
            return "views that are none"
    return "read"


def damaged(suffix: str, content: bytes, number: int, generator: np.random.Generator) -> bytes:
    """A file of a format, damaged in the way that finds most."""
    if suffix in KINDS:
        return KINDS[suffix].mutated(content, generator)
    if ("gl" in suffix or suffix.endswith(".json")) and number % 4:
        return mutated_header(content, generator)
    found = mutated(content, generator)
    return checksums_right(found) if suffix.endswith(".npz") and number % 3 else found


def files_of(suffix: str) -> list[bytes]:
    """Whole files of a format or a kind."""
    return KINDS[suffix].files() if suffix in KINDS else seeds()[suffix]


def fuzz(suffix: str, numbers: range, tell: Callable[[str], None]) -> Counter[str]:
    """Read damaged files of a format; number i is the same in each run."""
    files = files_of(suffix)
    found: Counter[str] = Counter()
    with tempfile.TemporaryDirectory(dir=MEMORY if MEMORY.is_dir() else None) as folder:
        for number in numbers:
            generator = np.random.default_rng(number)
            content = damaged(suffix, files[number % len(files)], number, generator)
            with guarded(Path(folder), cache.path) as done:
                outcome = attempt(content, suffix, Path(folder))
            outcome = done[0] if done else outcome
            found[outcome if outcome in ("read", "refused") else "wrong"] += 1
            if outcome not in ("read", "refused"):
                tell(f"{suffix} {number}: {outcome}")
    return found


def main() -> int:
    """Fuzz all formats, or some. Exit code 1 where something is wrong. Each format has a process of its own: libraries
    that others need are no memory of it."""
    count, suffixes = int(sys.argv[1]) if len(sys.argv) > 1 else 1000, sys.argv[2:] or [*seeds(), *KINDS]
    if len(suffixes) == 1:
        return fuzz_one(suffixes[0], count)
    codes = [subprocess.call([sys.executable, __file__, str(count), one]) for one in suffixes]
    return int(any(codes))


def fuzz_one(suffix: str, count: int) -> int:
    """Fuzz a format by the first so many changes. Exit code as `main`."""
    sys.dont_write_bytecode = True  # of modules that a damaged file is the first to need
    remember_shipped()
    with tempfile.TemporaryDirectory() as folder:  # whatever is imported by the first file does not count
        for whole in files_of(suffix):
            attempt(whole, suffix, Path(folder))
    used = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (used + MOST, resource.getrlimit(resource.RLIMIT_AS)[1]))
    signal.signal(signal.SIGALRM, _stop)
    signal.signal(signal.SIGPROF, _stop)
    begin, total = time.monotonic(), Counter[str]()
    for first in range(0, count, 100):
        signal.alarm(PATIENCE)
        signal.setitimer(signal.ITIMER_PROF, LONGEST)
        total += fuzz(suffix, range(first, min(first + 100, count)), print)
        with contextlib.suppress(OSError, AttributeError):  # the limit is that of a file, not of what lies free between
            ctypes.CDLL(None).malloc_trim(0)
    signal.alarm(0)
    signal.setitimer(signal.ITIMER_PROF, 0)
    print(f"{suffix}: {dict(total)} in {time.monotonic() - begin:.0f} s", flush=True)
    return 1 if total["wrong"] else 0


if __name__ == "__main__":
    sys.exit(main())
