"""Strands that move, of which some are drawn with fewer points than they have."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import exchange_kit as kit
import groom_file_kit as groom_kit
from strandcli.constants import W
from strandcli.exchange.files import write
from strandcli.exchange.strands import TimeSample
from strandcli.groom.blocks import unpack
from strandcli.groom_file import rows
from strandcli.run.stages import RunOptions, SimulationStage
from strandcli.scene.model import Scene

COUNTS = (41, 3, 5)
LEFT = 11
"""Points that strands are drawn with."""


def drawn(given: Scene, frame: int) -> list[np.ndarray]:
    stage = SimulationStage(given, [frame], None, RunOptions())
    return list(stage.groom.emitted(unpack(stage.begin(frame).positions, stage.groom.strands)[:, 1:]))


def test_points_that_are_drawn_are_the_same_ones_at_all_moments(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Every fourth of an even strand, though it is uneven a moment later; all of the shorter ones."""
    monkeypatch.setattr(rows, "ENOUGH", LEFT * W)
    monkeypatch.setattr(rows, "PADDED", 0)
    strands = [np.linspace((k, 0, 0), (k, 1, 0), n, dtype=np.float32) for k, n in enumerate(COUNTS)]
    held = kit.of(strands)
    later = held.points * np.float32([1, 2, 1]) ** 2 + np.float32([0, 0, 1]) * held.points[:, 1:2] ** 3
    write(tmp_path / "moving.abc", held, [TimeSample(0.0, held.points), TimeSample(1 / 24, later)])
    given = groom_kit.scene(tmp_path / "moving.abc")
    for number, points in ((1, held.points), (2, later)):
        long, short, middle = drawn(given, number)
        assert long.shape == (LEFT, 3)
        np.testing.assert_allclose(long, points[: COUNTS[0] : 4], atol=1e-6)
        for one, begin, count in ((short, 41, 3), (middle, 44, 5)):
            own = points[begin : begin + count]
            assert np.linalg.norm(one[:, None] - own, axis=2).min(axis=0).max() < 1e-6
