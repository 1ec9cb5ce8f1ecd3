"""Loops over batches and strands give what is found one by one, to the bit: patches, shadows of planes, marks."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numba import njit

from strandcli.constants import W
from strandcli.draw.common.kernels import batch, surface_batch
from strandcli.draw.lighting.kernels import marked_vertices
from strandcli.draw.lighting.kernels import mottle as mottle_kernel
from strandcli.draw.shadows.kernels import hard_shadows as shadows_kernel
from strandcli.draw.solids.kernels import coat, rays
from strandcli.scene.model import Emitter, PlaneSolid, SphereSolid
from strandcli.solids import pack_all

of_batch, past_solids, of_strand, visible = (
    mottle_kernel.mottle, shadows_kernel.hard_shadows, marked_vertices.find_marked, rays.visibility
)  # fmt: skip


@njit
def mottle(work, n, strength, grain):  # type: ignore[no-untyped-def]
    """Only compiled functions can call it, as those below."""
    of_batch(work, n, strength, grain)


@njit
def hard_shadows(work, n, solids, skin):  # type: ignore[no-untyped-def]
    past_solids(work, n, solids, skin)


@njit
def find_marked(marks, begin, end, marked):  # type: ignore[no-untyped-def]
    return of_strand(marks, begin, end, marked)


@njit
def visibility(solids, point, way, reach, skin):  # type: ignore[no-untyped-def]
    return visible(solids, point[0], point[1], point[2], way[0], way[1], way[2], reach, skin)


@pytest.mark.parametrize("pixel", [0.0, 0.01, 0.3, 0.9, 3.0])
def test_patches_of_a_batch_are_those_of_its_points(pixel: float) -> None:
    """Octaves that no point shows are left out, and no others."""
    rng = np.random.default_rng(1)
    work = rng.normal(0.0, 9.0, (surface_batch.ROWS, W)).astype(np.float32)
    across = work[surface_batch.ACROSS // W] = (pixel * rng.uniform(0.75, 1.0, W)).astype(np.float32)
    x, y, z = (work[row // W].copy() for row in (batch.X, batch.Y, batch.Z))
    work[surface_batch.UNDER // W] = 1
    strength, grain, n = np.float32(0.5), np.float32(1.0), 100
    mottle(work.reshape(-1), n, strength, grain)
    tones = [coat.patches(*at, grain, wide) for *at, wide in zip(x, y, z, across, strict=True)]
    expected = np.float32(1.0) + strength * np.array(tones, np.float32)
    np.testing.assert_array_equal(work[surface_batch.UNDER // W, :n], expected[:n])
    assert (work[surface_batch.UNDER // W, n:] == 1).all()
    assert pixel > 0.5 or np.ptp(expected) > 0.1


def test_a_batch_is_in_the_shadow_of_planes_where_its_points_are() -> None:
    rng = np.random.default_rng(2)
    tilted = PlaneSolid(name="b", position=(0.3, 0.2, 0.0), rotation=(20.0, 0.0, 120.0))
    solids = pack_all([SphereSolid(name="a", radius=0.5), PlaneSolid(name="c"), tilted], Emitter(), 0.0)
    work = rng.normal(0.0, 1.0, (batch.ROWS, W)).astype(np.float32)
    ways = rng.normal(0.0, 1.0, (3, W))
    work[batch.LX // W : batch.LX // W + 3] = ways / np.linalg.norm(ways, axis=0)
    work[batch.REACH // W] = np.where(np.arange(W) % 2, 1.0, 1e30)
    work[batch.ARRIVES // W] = 1
    points, to = (work[row // W : row // W + 3].T.copy() for row in (batch.X, batch.LX))
    skin = np.float32(0.01)
    hard_shadows(work.reshape(-1), np.int64(W), solids, skin)
    reach = work[batch.REACH // W]
    expected = [visibility(solids, *one, skin) for one in zip(points, to, reach, strict=True)]
    np.testing.assert_array_equal(work[batch.ARRIVES // W], np.array(expected, np.float32))
    assert 10 < sum(expected) < W - 10


@settings(deadline=None)
@given(st.lists(st.integers(0, 2), min_size=1, max_size=40), st.data())
def test_marked_vertices_of_a_strand_come_in_their_order(marks: list[int], data: st.DataObject) -> None:
    begin = data.draw(st.integers(0, len(marks) - 1))
    found = np.full(len(marks), -1)
    n = find_marked(np.array(marks, np.uint8), np.uint64(begin), np.uint64(len(marks)), found)
    assert list(found[:n]) == [v for v in range(begin, len(marks)) if marks[v]]
