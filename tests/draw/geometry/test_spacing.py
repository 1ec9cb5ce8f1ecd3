"""How far strands lie from each other, against grids of known spacing and against all pairs of strands."""

from __future__ import annotations

import math

import numpy as np
import pytest

from strandcli.blocks import pack
from strandcli.draw.geometry.extent import boxes_of
from strandcli.draw.geometry.kernels import spacing as kernel
from strandcli.draw.geometry.spacing import NEIGHBOURS, first_emitted, spacing_at, spacing_of


def upright(side: int, apart: float, rows: int = 6) -> np.ndarray:
    """(side², rows, 3): strands of length 1 on a square grid, in an order that tells nothing, the row before the root
    included."""
    x, z = (axis.ravel() * apart for axis in np.meshgrid(np.arange(side), np.arange(side)))
    out = np.empty((side * side, rows, 3))
    out[:, :, 0], out[:, :, 2] = x[:, None], z[:, None]
    out[:, :, 1] = np.linspace(-1 / (rows - 2), 1, rows)
    return np.random.default_rng(0).permutation(out)


def crooked(strands: int, rows: int = 5) -> np.ndarray:
    return np.cumsum(np.random.default_rng(1).normal(size=(strands, rows, 3)), 1)


def distances(strand: np.ndarray, point: np.ndarray) -> float:
    """Of a point from a strand, from its root on, by ten thousand places along it."""
    t = np.linspace(1, len(strand) - 1, 10_001)
    places = np.stack([np.interp(t, np.arange(len(strand)), axis) for axis in strand.T], 1)
    return float(np.linalg.norm(places - point, axis=1).min())


def test_a_square_grid_has_its_own_spacing() -> None:
    """The eighth neighbour is √2 sides away: √(π / 8) · √2 = .886."""
    strands = upright(40, 0.1)
    assert spacing_of(pack(strands), 1600) == pytest.approx(0.1 * math.sqrt(math.pi / 4), rel=1e-4)


def test_nearest_strands_are_those_of_all_pairs() -> None:
    """Those of blocks beside each other too; −1: a point on none of them."""
    strands = 0.1 * crooked(300)
    strands[:, :, 0] += 0.01 * np.arange(300)[:, None]
    rng = np.random.default_rng(2)
    points = (0.3 * rng.normal(size=(20, 3)) + [1.3, 0, 0]).astype(np.float32)
    own = rng.integers(-1, 300, 20)
    own[:3] = -1, 0, 299
    found = np.empty((20, 5), np.float32)
    kernel.nearest(pack(strands), 300, boxes_of(pack(strands), 300), points, own, found)
    for point, one, mine in zip(points, own, found, strict=True):
        others = sorted(distances(strand, point) for s, strand in enumerate(strands) if s != one)
        np.testing.assert_allclose(mine, others[:5], atol=2e-3)


def test_padding_and_the_strand_itself_do_not_count() -> None:
    packed = pack(crooked(3))
    found = np.empty((1, 4), np.float32)
    point = crooked(3)[:1, 1].astype(np.float32)
    kernel.nearest(packed, 3, boxes_of(packed, 3), point, np.array([0]), found)
    assert np.isfinite(found[0]).tolist() == [True, True, False, False]
    assert found[0, 0] > 0
    assert spacing_of(packed, 1) == 0


def test_parts_that_are_too_far_are_left_out_of_long_strands_alone() -> None:
    """Of strands of several parts, with the same distances as in a single one."""
    strands = crooked(700, 30)
    strands[:, :, 0] += 0.2 * np.arange(700)[:, None]
    packed, own = pack(strands), np.arange(0, 700, 50)
    points = strands[own, 17].astype(np.float32)
    boxes = boxes_of(packed, 700)
    everywhere = np.empty_like(boxes)
    everywhere[..., :3], everywhere[..., 3:] = -1e9, 1e9
    found, expected = np.empty((2, len(own), 5), np.float32)
    kernel.nearest(packed, 700, boxes, points, own, found)
    kernel.nearest(packed, 700, everywhere, points, own, expected)
    np.testing.assert_array_equal(found, expected)


@pytest.mark.parametrize("factor", [0.01, 3.0, 1000.0])
def test_spacing_grows_with_the_groom(factor: float) -> None:
    strands = crooked(300)
    assert spacing_of(pack(factor * strands), 300) == pytest.approx(factor * spacing_of(pack(strands), 300), rel=1e-4)


def test_it_is_taken_where_strands_are_and_not_where_they_grow() -> None:
    """Strands that draw together to a hundredth of the width: at their tips they are so much closer."""
    strands = upright(20, 0.1)
    middle = strands[:, :, [0, 2]].mean((0, 1))
    draw = np.linspace(1.25, 0.01, 6)[:, None]
    strands[:, :, [0, 2]] = middle + (strands[:, :, [0, 2]] - middle) * draw
    own = np.argsort(np.abs(strands[:, 1, [0, 2]] - middle).max(1))[:4]  # in the middle, with neighbours all about
    roots, tips = (
        spacing_at(pack(strands), 400, strands[own, row].astype(np.float32), own.astype(np.int64)) for row in (1, -1)
    )
    assert roots.mean() == pytest.approx(0.1 * draw[1, 0] * math.sqrt(math.pi / 4), rel=0.02)
    assert tips.mean() == pytest.approx(0.001 * math.sqrt(math.pi / 4), rel=0.02)


def test_the_first_strands_speak_for_all_that_follow_them() -> None:
    """Asked for at the same places, it changes by no more than the strands that come."""
    packed = pack(upright(40, 0.1))
    some = [spacing_of(packed, count, first_emitted(count, None)) for count in (1500, 1501, 1502, 1503)]
    assert np.ptp(some) < 0.03 * some[0]
    assert NEIGHBOURS < 256


def test_the_same_strands_are_measured_in_whatever_order_they_are() -> None:
    packed, order = upright(40, 0.1), np.random.default_rng(3).permutation(1600).astype(np.int32)
    found = first_emitted(1600, order)
    np.testing.assert_array_equal(order[found], np.arange(256))
    mixed = spacing_of(pack(packed[order]), 1600, found)
    assert mixed == spacing_of(pack(packed), 1600, first_emitted(1600, None)) > 0
