"""Read damaged files of strands, meshes and cameras: ``python tests/fuzz.py [COUNT [FORMAT]]``, and a slice of it in
the tests.

A file is mutated in a few bytes, words or blocks, cut off, or lengthened, and read. It must be read or refused in one
line (`StrandError`), within seconds and within three times its size and 100 MB: more ends in MemoryError here, and that
is a fault too. What is found is printed with the number that makes it again.
"""

from __future__ import annotations

import io
import json
import resource
import signal
import struct
import sys
import tempfile
import time
import warnings
import zipfile
from collections import Counter
from collections.abc import Callable
from copy import deepcopy
from pathlib import Path
from types import FrameType
from typing import Any

import numpy as np

import mesh_kit
from fuzz_seeds import CAMERA, COLMAP, MESH, seeds
from strandcli.cameras.read import views_of
from strandcli.errors import StrandError
from strandcli.exchange.facts import facts
from strandcli.exchange.files import ReadOptions, format_of, read
from strandcli.meshes.facts import facts as facts_of_mesh
from strandcli.meshes.read import read_mesh

MEMORY = Path("/dev/shm")
"""Where files are written fastest."""
LONGEST = 10
"""Seconds for one file."""
MOST = 100_000_000
"""Bytes beyond three times the file."""
WORDS = (0, 1, 2, 0x7F, 0x80, 0xFF, 0xFFFF, 0x10000, 2**31 - 1, 2**31, 2**32 - 1, 0x7FC00000, 0x7F800000)


def mutated(content: bytes, generator: np.random.Generator) -> bytes:
    """A file that is damaged in one to four ways."""
    data = bytearray(content)
    for _ in range(generator.integers(1, 5)):
        size = len(data)
        begin = int(generator.integers(size + 1 if generator.random() < 0.7 else min(size, 200) + 1))
        match int(generator.integers(9)):
            case 0:
                del data[begin:]
            case 1:
                del data[begin : begin + int(generator.integers(1, 30))]
            case 2:
                data[begin:begin] = generator.bytes(int(generator.integers(1, 30)))
            case 3:
                data[begin : begin + 1] = generator.bytes(1)
            case 4:
                if begin < size:
                    data[begin] ^= 1 << int(generator.integers(8))
            case 5 | 6:
                at = begin - begin % 4
                data[at : at + 4] = struct.pack("<I", WORDS[int(generator.integers(len(WORDS)))])
            case 7:  # a number of a text
                digits = [place for place, byte in enumerate(data[:600]) if 48 <= byte <= 57]
                if digits:
                    at = digits[int(generator.integers(len(digits)))]
                    data[at : at + 1] = str(int(10.0 ** generator.uniform(0, 19))).encode()
            case _:
                other = int(generator.integers(size + 1))
                data[begin : begin + 16] = data[other : other + 16]
    return bytes(data)


OTHERS: tuple[object, ...] = (
    *WORDS,
    -1,
    -(10**20),
    10**20,
    10**400,
    float("inf"),
    float("nan"),
    1.5,
    None,
    True,
    "",
    "x",
    [],
    [[]],
    [0],
    {},
    [{}],
    {"a": 0},
)
"""What values of a header become."""


def mutated_header(content: bytes, generator: np.random.Generator) -> bytes:
    """A glTF file, or JSON, in whose header up to three values are others."""
    packed = content[:4] == b"glTF"
    end = 20 + struct.unpack("<I", content[12:16])[0] if packed else len(content)
    tree = json.loads(content[20 if packed else 0 : end])
    for _ in range(generator.integers(1, 4)):
        place: Any = tree
        while True:
            keys = list(place) if isinstance(place, dict) else list(range(len(place)))
            if not keys:
                break
            key = keys[int(generator.integers(len(keys)))]
            if isinstance(place[key], dict | list) and generator.random() < 0.85:
                place = place[key]
                continue
            place[key] = deepcopy(OTHERS[int(generator.integers(len(OTHERS)))])
            break
    return mesh_kit.glb(tree, content[end + 8 :]) if packed else json.dumps(tree).encode()


def checksums_right(content: bytes) -> bytes:
    """An archive whose members' checksums were made those of what they hold now, where that can be; so that what is
    damaged inside is read."""
    data = bytearray(content)
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            directory = archive.start_dir
            for info in archive.infolist():
                with archive.open(info) as member:
                    member._expected_crc = None  # type: ignore[attr-defined]
                    crc = zipfile.crc32(member.read(1 << 20))  # type: ignore[attr-defined]
                place = data.index(b"PK\1\2", directory)
                data[place + 16 : place + 20] = struct.pack("<I", crc)
                directory = place + 46
    except Exception:  # whatever a damaged archive raises
        return content
    return bytes(data)


class TooLongError(Exception):
    """Reading a file took more than `LONGEST` seconds."""


def _stop(number: int, frame: FrameType | None) -> None:
    raise TooLongError


def attempt(content: bytes, suffix: str, folder: Path) -> str:
    """What becomes of a file: "read", "refused", or what is wrong."""
    path = folder / (suffix.removeprefix(CAMERA) if suffix.startswith(CAMERA) else f"a{suffix}")
    path.write_bytes(content)
    warnings.simplefilter("error")
    try:
        if suffix.startswith(CAMERA):
            return attempt_cameras(path)
        if suffix.startswith(MESH):
            return attempt_mesh(path)
        strands = read(path, ReadOptions(lenient=len(content) % 2 == 0))
        if len(content) % 5 == 0:
            json.dumps(facts(strands).as_dict(), allow_nan=False)
        sound = strands.first[0] == 0 and strands.first[-1] == strands.points.shape[0]
        if not sound or (strands.counts() < 2).any():
            return "strands that are none"
        driver = format_of(path)
        moments = driver.moments(path, ReadOptions(lenient=True)) if hasattr(driver, "moments") else ()
        if any(one.points.shape != strands.points.shape for one in moments):
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


def fuzz(suffix: str, numbers: range, tell: Callable[[str], None]) -> Counter[str]:
    """Read damaged files of a format; number i is the same in each run."""
    files = seeds()[suffix]
    found: Counter[str] = Counter()
    with tempfile.TemporaryDirectory(dir=MEMORY if MEMORY.is_dir() else None) as folder:
        for number in numbers:
            generator = np.random.default_rng(number)
            content = mutated(files[number % len(files)], generator)
            if ("gl" in suffix or suffix.endswith(".json")) and number % 4:
                content = mutated_header(files[number % len(files)], generator)
            if suffix.endswith(".npz") and number % 3:
                content = checksums_right(content)
            outcome = attempt(content, suffix, Path(folder))
            found[outcome if outcome in ("read", "refused") else "wrong"] += 1
            if outcome not in ("read", "refused"):
                tell(f"{suffix} {number}: {outcome}")
    return found


def main() -> int:
    """Fuzz all formats, or one. Exit code 1 where something is wrong."""
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 1000
    wrong = 0
    for suffix in sys.argv[2:] or seeds():
        with tempfile.TemporaryDirectory() as folder:  # whatever is imported by the first file does not count
            attempt(seeds()[suffix][0], suffix, Path(folder))
        used = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
        before = resource.getrlimit(resource.RLIMIT_AS)
        resource.setrlimit(resource.RLIMIT_AS, (used + MOST, before[1]))
        signal.signal(signal.SIGALRM, _stop)
        begin, total = time.monotonic(), Counter[str]()
        for first in range(0, count, 100):
            signal.alarm(LONGEST)
            total += fuzz(suffix, range(first, min(first + 100, count)), print)
        signal.alarm(0)
        resource.setrlimit(resource.RLIMIT_AS, before)
        wrong += total["wrong"]
        print(f"{suffix}: {dict(total)} in {time.monotonic() - begin:.0f} s", flush=True)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
