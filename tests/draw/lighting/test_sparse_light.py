"""Light on solids at every second pixel of every second row: which pixels take it from there, and what that changes."""

from __future__ import annotations

import numpy as np
import pytest

from strandcli import load
from strandcli.draw import transmittance
from strandcli.run.frame import FrameRenderer
from strandcli.run.stages import RunOptions, SimulationStage


@pytest.fixture(scope="module")
def draw():
    """Draws the first frame of `fur`, few strands, linear."""
    settings = {"image.size": [160, 120], "time.preroll": 0, "children.count": 4}

    def drawn(**more):
        scene = load("fur", settings=settings | more)
        moved = SimulationStage(scene, range(1, 2), None, RunOptions())
        return FrameRenderer(moved)(moved.begin(1)).image.astype(float)

    return drawn


def test_picture_is_nearly_that_with_light_at_every_pixel(draw, monkeypatch):
    sparse = draw()
    monkeypatch.setattr(transmittance, "is_costly", lambda lighting: False)
    exact = draw()
    error = np.sqrt(np.mean((sparse - exact) ** 2)) / exact.mean()
    assert 0 < error < 0.003


def test_lattice_is_where_it_is_in_the_whole_picture(draw):
    """A crop window at an odd place has the pixels of the whole picture, but where rounding tells, and nearly so at its
    border, where pixels of the lattice are missing."""
    x, y, width, height = 61, 43, 50, 41
    part, whole = draw(**{"image.crop": [x, y, width, height]}), draw()[y : y + height, x : x + width]
    different = np.abs(part - whole).max(-1)
    assert different.max() <= 2
    assert different[3:-3, 3:-3].max() <= 1
    assert np.count_nonzero(different[3:-3, 3:-3]) <= 3
