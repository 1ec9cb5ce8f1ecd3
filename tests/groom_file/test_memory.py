"""Memory that reading a file of strands to draw them takes: three times the file, and what is made at once."""

from __future__ import annotations

import tracemalloc
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from strandcli.exchange.files import read, write
from strandcli.exchange.strands import Strands, TimeSample, even_offsets
from strandcli.exchange.usd import process
from strandcli.groom_file import rows
from strandcli.groom_file.read import from_file
from strandcli.scene.model.emitter import GroomFile

TIMES = 3
AT_ONCE = 20e6
"""Bytes beyond that: of points that are looked at at once, and a sixth of these files."""


def made(path: Path, strands: int, points: int) -> GroomFile:
    shape = (strands, points, 3)
    np.save(path, np.random.default_rng(0).random(shape, np.float32))
    return GroomFile(str(path), up="y", root="first")


@pytest.mark.parametrize(("strands", "points", "size"), [(1_200_000, 2, 0.5), (10, 240_000, None)])
def test_strands_to_draw_take_three_times_their_file(
    strands: int, points: int, size: float | None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Few long ones too, which would fill a block for many."""
    monkeypatch.setattr(rows, "ENOUGH", 0)
    from_file(made(tmp_path / "small.npy", 4, 20), 0)  # what is compiled and imported is no memory of a file
    given = replace(made(tmp_path / "large.npy", strands, points), size=size)
    tracemalloc.start()
    try:
        found = from_file(given, 0)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert found.strands == strands
    assert peak < TIMES * Path(given.file).stat().st_size + AT_ONCE


def test_no_worker_waits_beside_many_strands(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Its memory would be missed there; but each moment of a file that moves would wait for the next one to begin."""
    pytest.importorskip("pxr", reason="Pixar's library is not installed: pip install usd-core")
    path, points = tmp_path / "a.usdc", np.zeros((8, 3), np.float32)
    strands = Strands(even_offsets(4, 2), points)
    moments = [TimeSample(time, points + np.float32(time)) for time in (0.0, 1.0)]
    for bytes_kept, samples, waiting in (
        (points.nbytes // 2, None, 0), (points.nbytes // 2, moments, 1), (1 << 20, None, 1),
    ):  # fmt: skip
        monkeypatch.setattr(process, "KEPT", bytes_kept)
        write(path, strands, samples)
        assert read(path).count == 4
        assert len(process._kept) == waiting
