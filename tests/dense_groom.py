"""Time and memory of a picture, and of all labels, of 100,000 strands of 256 points: ``python tests/dense_groom.py``.

Strands are made up: locks and waves on a head, smooth as those of reconstructions, or with ``--jagged`` a step aside
at every point, .16 pixels on average at 512x512. Each command runs twice, the second time with all kernels compiled,
and that counts. Processor seconds say more than seconds on a machine that is busy otherwise. Options:

    --strands N, --points N, --size WxH, --jagged
    --keep FILE.data    the groom is written there, and kept
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

AT_ONCE = 4096
"""Strands that are made at once."""
WAVES = (3, 7, 13)
"""Bends that each strand has of its own."""


def strands(count: int, points: int, jagged: bool, rng: np.random.Generator) -> NDArray[np.float64]:
    """(count, points, 3) metres: strands that hang from a head, in locks."""
    root = rng.normal(size=(count, 3))
    root /= np.linalg.norm(root, axis=1)[:, None]
    root[:, 1] = np.abs(root[:, 1]) * 1.25 - 0.25
    root /= np.linalg.norm(root, axis=1)[:, None]
    out = root * np.array([1, 0.2, 1])
    out /= np.linalg.norm(out, axis=1)[:, None]
    t = np.linspace(0, 1, points)[None, :, None]
    length = rng.uniform(0.2, 0.3, (count, 1, 1))
    away = 0.22 * out[:, None] * (1 - np.exp(-5 * t))
    way = 0.1 * root[:, None] + length * (away + np.array([0, 0.1, 0]) * t - np.array([0, 1.0, 0]) * t**1.7)
    lock = np.floor(np.arctan2(root[:, 2], root[:, 0]) * 12)[:, None, None]
    turn = 22 * t + lock * 2.4 + rng.normal(0, 0.4, (count, 1, 1))
    way += 0.008 * t * np.concatenate([np.sin(turn), 0 * turn, np.cos(turn)], 2)
    if jagged:
        return np.asarray(way + 0.0024 * np.cumsum(rng.normal(size=way.shape), 1) / np.sqrt(points))
    for waves in WAVES:
        bend = np.sin(2 * waves * t + rng.uniform(0, 2 * np.pi, (count, 1, 3)))
        way += 0.004 / waves * t * rng.normal(size=(count, 1, 3)) * bend
    return np.asarray(way)


def make(path: Path, count: int, points: int, jagged: bool) -> None:
    """Write a groom as .data."""
    rng = np.random.default_rng(1)
    row = np.dtype([("count", "<i4"), ("points", "<f4", (points, 3))])
    with path.open("wb") as file:
        np.array([count], "<i4").tofile(file)
        for begin in range(0, count, AT_ONCE):
            rows = np.empty(min(AT_ONCE, count - begin), row)
            rows["count"], rows["points"] = points, strands(len(rows), points, jagged, rng)
            rows.tofile(file)


def run(*words: str) -> str:
    """Run a command, and say what it took."""
    begin = time.perf_counter()
    with subprocess.Popen([sys.executable, "-m", "strandcli", *words], stdout=subprocess.DEVNULL) as process:
        _, status, used = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        sys.exit(f"strandcli {' '.join(words)} ended with exit code {process.returncode}")
    seconds = time.perf_counter() - begin
    return (
        f"{seconds:6.1f} s, {used.ru_utime + used.ru_stime:6.1f} s of processors, {used.ru_maxrss * 1024 / 1e9:.2f} GB"
    )


def main() -> None:
    """Make a groom, draw it, and label it."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--strands", type=int, default=100_000)
    parser.add_argument("--points", type=int, default=256)
    parser.add_argument("--size", default="512x512")
    parser.add_argument("--jagged", action="store_true")
    parser.add_argument("--keep", type=Path)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        path = given.keep or Path(folder, "dense.data")
        make(path, given.strands, given.points, given.jagged)
        picture = ["render", str(path), "--size", given.size, "-o", f"{folder}/picture", "--overwrite", "-q"]
        run(*picture)
        print("picture", run(*picture), flush=True)
        report = json.loads(Path(folder, "picture", "report.json").read_text())
        (frame,) = report["frames"]
        print("  ", ", ".join(f"{stage} {took:.2f} s" for stage, took in frame["seconds"].items() if took))
        counts = frame["counts"]
        off = frame["error"]["curve_px_max"] or 0.0
        print(f"   {counts['segments']:,} of {given.strands * (given.points - 1):,} segments, within {off:.2g} px;",
              f"{counts['fragments']:,} fragments", flush=True)  # fmt: skip
        labels = ["dataset", str(path), "--layout", "hairstep", "--views", "1", "--size", given.size, "-q"]
        for name in ("first", "labels"):
            words = run(*labels, "-o", f"{folder}/{name}")
        print("labels ", words)


if __name__ == "__main__":
    main()
