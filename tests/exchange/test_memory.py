"""Memory that reading strands and telling what is in a file takes: three times the file, and what is made at once."""

from __future__ import annotations

import re
import tracemalloc
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from strandcli.exchange.facts import facts_of_file
from strandcli.exchange.files import ReadOptions, read, write
from strandcli.exchange.strands import Strands, even_offsets
from strandcli.exchange.usd import process
from strandcli.groom_file import rows
from strandcli.groom_file.read import from_file
from strandcli.scene.model.emitter import GroomFile

STRANDS, POINTS = 600_000, 2
TIMES = 3
AT_ONCE = {read: 2e6, facts_of_file: 22e6}
"""Bytes beyond that: of arrays of some points at once."""


def strands(count: int) -> Strands:
    points = np.random.default_rng(0).random((POINTS * count, 3), np.float32)
    return Strands(even_offsets(count, POINTS), points)


def put(path: Path, count: int, kind: str) -> Path:
    """A file of so many strands; ``kind``: its suffix, or the type of the numbers of a `.npy`."""
    if kind.startswith("."):
        write(path.with_suffix(kind), strands(count))
        return path.with_suffix(kind)
    np.save(path.with_suffix(".npy"), strands(count).points.reshape(count, POINTS, 3).astype(kind))
    return path.with_suffix(".npy")


@pytest.mark.parametrize(
    ("kind", "what"),
    [(".data", read), (".abc", read), (".ply", read), ("f8", read), ("f2", facts_of_file)],
)  # fmt: skip
def test_strands_take_three_times_their_file(
    kind: str, what: Callable[[Path, ReadOptions], object], tmp_path: Path
) -> None:
    what(put(tmp_path / "small", 4, kind), ReadOptions())  # what is compiled and imported is no memory of a file
    path = put(tmp_path / "large", STRANDS, kind)
    assert peak(lambda: what(path, ReadOptions())) < TIMES * path.stat().st_size + AT_ONCE[what]


def peak(does: Callable[[], object]) -> int:
    """Bytes that a function takes at most."""
    tracemalloc.start()
    try:
        does()
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


@pytest.mark.parametrize(("count", "points", "size"), [(1_200_000, 2, 0.5), (10, 240_000, None)])
def test_strands_to_draw_take_three_times_their_file(
    count: int, points: int, size: float | None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Few long ones too, which would fill a block for many."""
    monkeypatch.setattr(rows, "ENOUGH", 0)
    for name, shape in (("small", (4, 20, 3)), ("large", (count, points, 3))):
        np.save(tmp_path / f"{name}.npy", np.random.default_rng(0).random(shape, np.float32))
    from_file(GroomFile(str(tmp_path / "small.npy"), up="y", root="first"), 0)
    given = GroomFile(str(tmp_path / "large.npy"), up="y", root="first", size=size)
    assert peak(lambda: from_file(given, 0)) < TIMES * Path(given.file).stat().st_size + 20e6
    assert from_file(given, 0).strands == count


def peak_of_worker() -> int:
    status = Path(f"/proc/{process._idle[0].process.pid}/status")
    if not status.exists():
        pytest.skip("asks the system as Linux does")
    return 1024 * int(re.findall(r"VmHWM:\s*(\d+) kB", status.read_text())[0])


LINES = """#usda 1.0
def BasisCurves "a" {{
    uniform token type = "linear"
    int[] curveVertexCounts = [{counts}]
    point3f[] points.timeSamples = {{ 0: [{points}], }}
}}
"""


def test_texts_of_usd_take_three_times_their_file(tmp_path: Path) -> None:
    small, large = tmp_path / "small.usda", tmp_path / "large.usda"
    point = "(0.25, 1, 2.5), (0, -1, 3.5)"
    small.write_text(LINES.format(counts="2", points=point))
    large.write_text(LINES.format(counts=", ".join(["2"] * 200_000), points=", ".join([point] * 200_000)))
    assert read(small).count == 1
    before = peak_of_worker()
    found = read(large)
    assert found.count == 200_000
    assert (found.points.reshape(-1, 2, 3) == read(small).points).all()
    assert peak_of_worker() - before < TIMES * large.stat().st_size + 20e6
