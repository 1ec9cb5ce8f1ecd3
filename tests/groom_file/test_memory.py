"""Memory that reading a file of strands to draw them takes: three times the file, and what is made at once."""

from __future__ import annotations

import tracemalloc
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

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
