"""Directions in the picture against small steps along strands, projected."""

from __future__ import annotations

import numpy as np
import pytest

from strandcli.cameras.pinhole import Pinhole
from strandcli.dataset.labels import directions


@pytest.mark.parametrize("perspective", [True, False])
def test_directions_are_those_of_steps_along_the_strand(perspective: bool) -> None:
    rng = np.random.default_rng(3)
    axes = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    rotation = axes * np.sign(np.linalg.det(axes))
    view = Pinhole("a", 64, 48, 30.0, (20.0, 30.0), rotation, rng.normal(size=3), perspective)
    rows, columns = rng.integers(0, 48, 300), rng.integers(0, 64, 300)
    tangents = rng.normal(size=(300, 3))
    tangents /= np.linalg.norm(tangents, axis=1)[:, None]
    flat = (np.stack([columns, rows], 1) + 0.5 - view.centre) / view.focal
    here = np.column_stack([2 * flat if perspective else flat, np.full(300, 2.0)]) @ rotation + view.eye
    assert np.abs(view.project(here) - np.stack([columns, rows], 1) - 0.5).max() < 1e-9
    step = view.project(here + 1e-6 * tangents) - view.project(here - 1e-6 * tangents)
    step /= np.linalg.norm(step, axis=1)[:, None]
    found = directions(tangents.astype(np.float32), rows, columns, view)
    assert np.median(np.abs(found - step).max(1)) < 1e-5
    assert np.abs(found - step).max() < 1e-2  # where strands are seen all but end on
    end_on = directions(rotation[2:].astype(np.float32), np.array([29]), np.array([19]), view)
    assert np.isfinite(end_on).all()
