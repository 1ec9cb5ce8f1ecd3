"""The solid that is nearest to a segment (`contact.kernels.search`), against NumPy."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from reference.rules import depth
from scratch_kit import LANES, Rows, scratch
from strand_kit import scene_of
from strandcli.constants import W
from strandcli.jit import function
from strandcli.scene.model import Emitter
from strandcli.simd import fused_pointer, fused_vector_pointer, load3
from strandcli.simulate.contact.kernels import search
from strandcli.simulate.rod.kernels.arrays import MOTION
from strandcli.simulate.rod.kernels.parts import with_shift
from strandcli.simulate.rod.kernels.step import contact_of
from strandcli.solids import COLUMNS, pack

Floats = NDArray[np.float64]
SOLIDS = {
    "sphere": "{kind: sphere, radius: 0.5, position: [0.1, 0.2, -0.1]}",
    "capsule": "{kind: capsule, radius: 0.3, length: 0.8, position: [0, 0.1, 0.2], rotation: [40, 30, 20]}",
    "plane": "{kind: plane, position: [0.1, 0.2, 0], rotation: [20, 0, 30]}",
    "box": "{kind: box, size: [0.8, 0.6, 0.9], position: [0.1, 0, 0], rotation: [30, 20, 40]}",
}
STILL = Emitter()
LENGTH = 0.3
MOVED = np.array([[0.0, -1.0, 0.0, 0.1], [1.0, 0.0, 0.0, -0.2], [0.0, 0.0, 1.0, 0.3]])
"""A quarter turn and a shift: where a solid's points come from."""


@function
def look(memory, ends, past, solids, whole, reach):
    """`search.nearest` of a segment: ``ends`` (6, LANES) and what they were, ``past`` (2, 3 W)."""
    s, rows = scratch(memory, 1), fused_vector_pointer(ends)
    root = load3(rows, 0, 1)
    none = root[0] * 0.0, root[0] * 0.0, root[0] * 0.0
    contact = with_shift(contact_of(solids), True, none)
    before = search.Past(fused_pointer(past), 3 * W, none)
    return search.nearest(
        s, 0, root, load3(rows, 3, 1), before, contact, (whole, none[0] + reach, none[0] + search.LEAST_SHARE)
    )


def packed(solids: Any) -> tuple[Floats, ...]:
    """Rows of all solids of each kind, with the same motion."""
    motion = np.append(MOVED[:, :3].ravel(), MOVED[:, 3])
    assert motion.size == MOTION
    every = (pack(kind, list(solids), STILL, 0.0, np.float64) for kind in COLUMNS)
    return tuple(np.concatenate([rows, np.tile(motion, (len(rows), 1))], 1) for rows in every)


def gaps(solid: Any, points: Floats) -> Floats:
    return -depth(points, solid, STILL, 0.0)


def normal(solid: Any, points: Floats) -> Floats:
    """(..., 3) the direction in which gaps grow."""
    steps = 1e-6 * np.eye(3)
    found: Floats = np.stack([gaps(solid, points + h) - gaps(solid, points - h) for h in steps], -1)
    return found / np.linalg.norm(found, axis=-1, keepdims=True)


def segments(count: int, seed: int = 5) -> Floats:
    """(count, LANES, 2, 3) about the origin."""
    rng = np.random.default_rng(seed)
    start = rng.normal(scale=0.5, size=(count, LANES, 3))
    direction = rng.normal(size=start.shape)
    return np.stack([start, start + LENGTH * direction / np.linalg.norm(direction, axis=-1, keepdims=True)], 2)


def seen(solids: Any, ends: Floats, past: Floats, whole: bool) -> Rows:
    """The scratch after a search: ``ends`` (LANES, 2, 3), and where they were."""
    before = np.zeros((2, 3, W))
    before[..., :LANES] = past.transpose(1, 2, 0)
    rows = Rows(1)
    rows.active[...] = 1  # what nothing touches needs no slip
    lanes = np.ascontiguousarray(ends.transpose(1, 2, 0).reshape(6, LANES))
    assert look(rows.all, lanes, before.reshape(2, -1), packed(solids), whole, 1e3)
    return rows


def nearest_places(solid: Any, ends: Floats) -> Floats:
    """Where on segments (..., 2, 3) they are deepest."""
    share = np.linspace(0, 1, 2001)
    points = ends[..., None, 0, :] + share[:, None] * (ends[..., None, 1, :] - ends[..., None, 0, :])
    found: Floats = share[gaps(solid, points).argmin(-1)]
    return found


@pytest.mark.parametrize("whole", [False, True], ids=["ends", "segments"])
@pytest.mark.parametrize("kind", SOLIDS)
def test_gap_normal_place_and_slip_are_those_of_numpy(kind: str, whole: bool) -> None:
    """A place by the beginning is left to the segment before; so is that of a plane, where it is no end."""
    (solid,) = scene_of(f"solids: [{SOLIDS[kind]}]").solids
    for ends, past in zip(segments(60), segments(60, 6), strict=True):
        rows = seen([solid], ends, past, whole)
        mine, wanted = rows.place[0, 0], np.ones(LANES)
        own, was = (one[:, 0] + mine[:, None] * (one[:, 1] - one[:, 0]) for one in (ends, past))
        oblique = np.abs(rows.normal[0].T - normal(solid, own)).max(1) > 1e-5
        assert not oblique.any() or (whole and kind == "box")  # across one of its edges
        np.testing.assert_allclose(gaps(solid, own)[~oblique], rows.gap[0, 0][~oblique], atol=1e-9)
        np.testing.assert_allclose(rows.slip[0].T, own - (was @ MOVED[:, :3].T + MOVED[:, 3]), atol=1e-9)
        if whole and kind != "plane":
            wanted = nearest_places(solid, ends)
        expected = gaps(solid, ends[:, 0] + wanted[:, None] * (ends[:, 1] - ends[:, 0]))
        assert mine.min() >= search.LEAST_SHARE
        sure = (wanted > search.LEAST_SHARE + 0.01) & (np.abs(expected) < 0.05 if whole else True) & ~oblique
        np.testing.assert_allclose(rows.gap[0, 0, sure], expected[sure], atol=2e-3 if whole else 1e-9)
