"""Read damaged files of strands and of meshes: ``python tests/fuzz.py [COUNT [FORMAT]]``, and a slice of it in the
tests.

A file is mutated in a few bytes, words or blocks, cut off, or lengthened, and read. It must be read or refused in one
line (`StrandError`), within seconds and within three times its size and 100 MB: more ends in MemoryError here, and that
is a fault too. What is found is printed with the number that makes it again.
"""

from __future__ import annotations

import base64
import importlib.util
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
from collections.abc import Callable, Iterator
from copy import deepcopy
from dataclasses import replace
from pathlib import Path
from types import FrameType
from typing import Any

import numpy as np

import abc_kit
import exchange_kit as kit
import mesh_kit
import usd_kit
from strandcli.errors import StrandError
from strandcli.exchange.facts import facts
from strandcli.exchange.files import ReadOptions, format_of, read
from strandcli.meshes.read import read_mesh

MEMORY = Path("/dev/shm")
"""Where files are written fastest."""
LONGEST = 10
"""Seconds for one file."""
MOST = 100_000_000
"""Bytes beyond three times the file."""
MESH = "mesh"
"""What formats of meshes begin with: they are the ends of names, as those of strands."""
WORDS = (0, 1, 2, 0x7F, 0x80, 0xFF, 0xFFFF, 0x10000, 2**31 - 1, 2**31, 2**32 - 1, 0x7FC00000, 0x7F800000)


def grooms() -> Iterator[list[kit.Strand]]:
    """Small ones: equal strands, others, of one point, none."""
    generator = np.random.default_rng(5)
    yield list(generator.normal(size=(6, 5, 3)).astype(np.float32))
    yield [generator.normal(size=(count, 3)).astype(np.float32) for count in (3, 1, 9, 2, 30)]
    yield []


def npz(packed: bool, **arrays: object) -> bytes:
    file = io.BytesIO()
    (np.savez_compressed if packed else np.savez)(file, **arrays)
    return file.getvalue()


def seeds() -> dict[str, list[bytes]]:
    """Whole files of each format."""
    even, uneven, none = grooms()
    colours = np.ones((30, 3), "<f4").tobytes()
    positions = np.stack(even)
    usd = {}
    if importlib.util.find_spec("pxr"):
        texts = [usd_kit.text(even), usd_kit.text(uneven[2:], basis="bspline", wrap="pinned"), usd_kit.moving(even)]
        usd[".usd"] = [*(usd_kit.binary(one) for one in texts), *(one.encode() for one in texts)]
    return {
        **usd,
        ".hair": [kit.hair(even), kit.hair(uneven), kit.hair(none), kit.hair(even, more=colours, flags=16)],
        ".data": [kit.data(even), kit.data(uneven), kit.data(none)],
        ".bin": [kit.data(even, 4), kit.data(uneven, 4)],
        ".tfx": [kit.tfx3(even), kit.tfx4(even), kit.tfx4(even, uv=False)],
        ".ply": [
            *(kit.ply(groom, order, told=told) for groom in (even, uneven) for order in ("<", ">", "")
              for told in ("strand", "edge")),
            kit.ply(even, kind="double"), kit.ply(even, "", told="nothing"), kit.ply(even, told="nothing"),
        ],
        ".npz": [
            npz(False, positions=positions), npz(True, positions=positions.astype(np.float16)),
            npz(False, positions=np.asfortranarray(positions), root_uv=np.ones((6, 2))),
            npz(True, points=kit.of(uneven).points, first=kit.of(uneven).first, words=np.array(["a"])),
        ],
        ".abc": [abc_kit.rich(even), abc_kit.archive(uneven), abc_kit.rich(uneven), abc_kit.FROM_BLENDER.read_bytes()],
        **mesh_seeds(),
    }  # fmt: skip


def mesh_seeds() -> dict[str, list[bytes]]:
    """Whole files of each format of meshes, small ones."""
    box = mesh_kit.mesh("box")
    count = box.vertices.shape[0]
    seamed = replace(box, uv=np.random.default_rng(1).random((12, 3, 2)).round(2).astype(np.float32))
    faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6], [0, 6, 2], [1, 3, 7, 5]]
    more = {"density": np.ones(count, np.float32), **dict.fromkeys(("red", "green", "blue"), np.zeros(count, np.uint8))}
    tree, buffer = mesh_kit.gltf_tree(box, COLOR_0=np.ones((count, 3), "<f4"), TEXCOORD_0=np.ones((count, 2), "<f4"))
    inner = {**tree, "buffers": [{"uri": "data:;base64," + base64.b64encode(buffer).decode()}]}
    back = b"v 0 0 0\nv 1 0 0 1 0 0\nvn 0 0 1\nv 0 1 0\no a\nusemtl b\ns 1\nf -3//1 -2//1 -1//1\nv 1 1 0\nf 2 3 4 1\n"
    return {
        f"{MESH}.obj": [mesh_kit.obj(box), mesh_kit.obj(seamed), back],
        f"{MESH}.ply": [
            *(mesh_kit.ply(box, order, shape, more) for order in ("<", ">", "") for shape in (None, faces)),
            mesh_kit.ply(box),
        ],
        f"{MESH}.stl": [mesh_kit.stl(box), mesh_kit.stl(box, text=True)],
        f"{MESH}.glb": [mesh_kit.glb(tree, buffer), mesh_kit.glb(*mesh_kit.gltf_tree(box))],
        f"{MESH}.gltf": [json.dumps(inner).encode(), json.dumps(inner, indent=1).encode()],
    }


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
    """A glTF file in whose header up to three values are others."""
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
    path = folder / f"a{suffix}"
    path.write_bytes(content)
    try:
        if suffix.startswith(MESH):
            return attempt_mesh(path)
        warnings.simplefilter("error")
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
    numbers = (mesh.vertices, mesh.normals, mesh.uv, mesh.corner_normals, mesh.colours, *mesh.attributes.values())
    if not all(np.isfinite(one).all() for one in numbers if one is not None):
        return "numbers that are not finite"
    sound = mesh.triangles.min() >= 0 and mesh.triangles.max() < mesh.vertices.shape[0]
    return "read" if sound and (mesh.areas() > 0).all() else "triangles that are none"


def fuzz(suffix: str, numbers: range, tell: Callable[[str], None]) -> Counter[str]:
    """Read damaged files of a format; number i is the same in each run."""
    files = seeds()[suffix]
    found: Counter[str] = Counter()
    with tempfile.TemporaryDirectory(dir=MEMORY if MEMORY.is_dir() else None) as folder:
        for number in numbers:
            generator = np.random.default_rng(number)
            content = mutated(files[number % len(files)], generator)
            if "gl" in suffix and number % 4:
                content = mutated_header(files[number % len(files)], generator)
            if suffix == ".npz" and number % 3:
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
