"""Time and memory of reading 50,000 strands, 3.4 million points, in each format: ``python tests/reading.py``.

Each file is read five times in a process of its own; the least time counts, and the memory beyond what the process had
before. Exit code 1 where a figure that is asked for is missed.
"""

from __future__ import annotations

import importlib.util
import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

import exchange_kit as kit
from strandcli.exchange.files import ReadOptions, read, write

STRANDS, POINTS = 50_000, 68
SECONDS = {"a.hair": 0.5, "uneven.hair": 0.5}
"""At most; of other files 1 s."""
MEMORY = 3.0
"""Times the file, at most."""
USD = (".usd",) if importlib.util.find_spec("pxr") else ()
"""The library that reads it may be missing."""
TEXT = "text.ply"
"""No time is asked for text."""


def make(folder: Path) -> list[Path]:
    """Files of equal and of other strands in all formats."""
    generator = np.random.default_rng(1)
    steps = generator.normal(size=(STRANDS, POINTS, 3)).astype(np.float32)
    points = np.cumsum(0.01 * steps, axis=1, dtype=np.float32)
    even = kit.of(list(points))
    counts = np.bincount(generator.integers(STRANDS, size=STRANDS * (POINTS - 2)), minlength=STRANDS) + 2
    uneven = kit.of(np.split(points.reshape(-1, 3), np.cumsum(counts)[:-1]))
    paths = []
    for name, strands in (("a", even), ("uneven", uneven)):
        for suffix in (".hair", ".data", ".bin", ".ply", ".npz", ".abc", *USD):
            paths.append(folder / f"{name}{suffix}")
            write(paths[-1], strands)
    paths.append(folder / "packed.npz")
    np.savez_compressed(paths[-1], positions=points)
    paths.append(folder / "half.npz")
    np.savez(paths[-1], positions=points.astype(np.float16))
    paths.append(folder / "a.tfx")
    header = np.array([STRANDS, POINTS, 160, 0, 0, 0, 0, *[0] * 32], "<u4").tobytes()
    paths[-1].write_bytes(np.float32(4).tobytes() + header + np.pad(points.reshape(-1, 3), ((0, 0), (0, 1))).tobytes())
    paths.append(folder / "double.ply")
    paths[-1].write_bytes(
        f"ply\nformat binary_big_endian 1.0\nelement vertex {STRANDS * POINTS}\nproperty double x\nproperty double y\n"
        "property double z\nend_header\n".encode()
        + points.astype(">f8").tobytes()
    )
    paths.append(folder / TEXT)
    lines = "\n".join(f"{x:.9g} {y:.9g} {z:.9g}" for x, y, z in points.reshape(-1, 3).tolist())
    paths[-1].write_text(
        f"ply\nformat ascii 1.0\nelement vertex {STRANDS * POINTS}\nproperty float x\nproperty float y\n"
        f"property float z\nend_header\n{lines}\n"
    )
    return paths


def resident(name: str) -> int:
    """Bytes of memory of this process, now or at the most."""
    line = next(line for line in Path("/proc/self/status").read_text().splitlines() if line.startswith(name))
    return 1024 * int(line.split()[1])


def measure(path: Path) -> None:
    """Print the seconds that reading a file takes, and the bytes of memory."""
    with tempfile.TemporaryDirectory() as folder:  # what is imported for the first file does not count
        small = Path(folder, f"a{path.suffix}")
        strands = list(np.zeros((2, POINTS, 3), np.float32))
        if path.suffix == ".tfx":
            small.write_bytes(kit.tfx4(strands))
        else:
            write(small, kit.of(strands))
        read(small)
    before = resident("VmRSS")
    Path("/proc/self/clear_refs").write_text("5")  # the peak begins anew
    times, memory = [], 0
    for _ in range(5):
        begin = time.perf_counter()
        strands_read = read(path, ReadOptions(stride=POINTS))
        times.append(time.perf_counter() - begin)
        memory = memory or resident("VmHWM") - before
        assert strands_read.count == STRANDS
        del strands_read
    print(json.dumps({"seconds": min(times), "bytes": memory}))


def main() -> int:
    """Measure all files."""
    if len(sys.argv) > 1:
        measure(Path(sys.argv[1]))
        return 0
    missed = 0
    with tempfile.TemporaryDirectory() as folder:
        for path in make(Path(folder)):
            run = subprocess.run([sys.executable, __file__, str(path)], capture_output=True, text=True, check=True)
            found = json.loads(run.stdout)
            times, size = found["bytes"] / path.stat().st_size, path.stat().st_size / 1e6
            limit = float("inf") if path.name == TEXT else SECONDS.get(path.name, 1.0)
            ok = found["seconds"] <= limit and times <= MEMORY
            missed += not ok
            print(f"{path.name:<12} {size:6.1f} MB  {found['seconds']:6.3f} s  {times:4.2f} times the file"
                  + ("" if ok else "  MISSED"), flush=True)  # fmt: skip
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
