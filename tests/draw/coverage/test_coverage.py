"""Coverage and sorted strands against points, closed forms, a pixel-by-pixel twin, and by their properties."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from reference.bands import covered
from strandcli.draw.common.scratch import Scratch
from strandcli.draw.coverage.coverage import Coverage
from strandcli.draw.geometry.curves import Polylines
from strandcli.draw.solids.edges import Edges

WIDTHS = [0.003, 0.2, 0.69, 0.71, 4.0]


def hiding(hides: np.ndarray) -> Edges:
    """Solids that have no edges and hide what is behind depth numbers (height * width,)."""
    none = np.zeros(0, np.float32)
    pairs = np.zeros((0, 4), np.int64)
    return Edges(hides, pairs[:, 0], none, none, none.reshape(0, 3), pairs.astype(np.uint64), none, pairs)


def drawn(
    strands: list[np.ndarray],
    widths: list[np.ndarray] | None,
    size: tuple[int, int],
    *,
    colours: np.ndarray | None = None,
    behind: float = 0.0,
    opacity: float = 1.0,
    hides: np.ndarray | None = None,
    workers: int = 1,
    room: int = 400_000,
) -> np.ndarray:
    """(height, width, 3) of polylines, each (vertices, 3) of x, y and depth number; by default white ones on black."""
    first = np.cumsum([0, *map(len, strands)])
    screen = np.ascontiguousarray(np.concatenate(strands), np.float32).reshape(-1, 3)
    wide = None if widths is None else np.concatenate(widths).astype(np.float32)
    vertex = np.ones((len(screen), 3), np.float32) if colours is None else colours.astype(np.float32)
    image = np.full((size[1], size[0], 3), behind, np.float32)
    coverage = Coverage(size, opacity, room)
    edges = None if hides is None else hiding(hides)
    for layer in coverage.layers(Polylines(first, screen), screen, wide, edges, workers, Scratch()):
        layer.blend(vertex, image)
    return image


def white(
    strands: list[np.ndarray], widths: list[np.ndarray] | None, size: tuple[int, int], **options: Any
) -> np.ndarray:
    """The opacity of every pixel, as float64."""
    return drawn(strands, widths, size, **options)[..., 0].astype(np.float64)


def bent(rng: np.random.Generator, size: float, pieces: int, turn: float) -> np.ndarray:
    """A polyline in the middle of a picture whose direction turns a little at each joint."""
    angle = rng.uniform(0, 2 * np.pi) + np.cumsum(rng.normal(0, turn, pieces))
    steps = rng.uniform(0.3, 1, (pieces, 1)) * np.stack([np.cos(angle), np.sin(angle)], 1)
    walk = np.concatenate([[[0, 0]], steps.cumsum(0)])
    walk *= size / 2 / max(np.ptp(walk, 0).max(), 1e-9)
    return np.column_stack([walk - walk.mean(0) + size / 2 + rng.uniform(-0.5, 0.5, 2), np.full(len(walk), 0.5)])


@pytest.mark.parametrize("wide", WIDTHS)
def test_the_area_of_a_strand_is_its_length_times_its_width(wide: float) -> None:
    """Within 3 % each, from 0.003 to 4 pixels; with no bias above 0.5 % over many."""
    rng = np.random.default_rng(1)
    ratios = []
    for _ in range(60):
        line = bent(rng, 64, int(rng.integers(1, 30)), 0.1)
        widths = wide * rng.uniform(0.5, 1, len(line))
        length = np.linalg.norm(np.diff(line[:, :2], axis=0), axis=1)
        area = (length * (widths[1:] + widths[:-1]) / 2).sum()
        ratios.append(white([line], [widths], (64, 64)).sum() / area)
    assert np.abs(np.array(ratios) - 1).max() < 0.03
    assert abs(np.mean(ratios) - 1) < 0.005


@pytest.mark.parametrize("wide", [0.2, 0.8, 4.0])
def test_pixels_are_covered_as_points_say(wide: float) -> None:
    rng = np.random.default_rng(2)
    for _ in range(12):
        line = bent(rng, 24, int(rng.integers(1, 7)), 0.2)
        widths = wide * rng.uniform(0.6, 1, len(line))
        points = covered(line[:, :2], widths, 24, 24, 24)
        got = white([line], [widths], (24, 24))
        assert got.sum() == pytest.approx(points.sum(), rel=0.03)
        # short strands, so that ends weigh: a thin one is cut along an axis there, a wide one by the pixels' middles
        assert np.sqrt(np.mean((got - points)[points > 0] ** 2)) < 0.07
        assert np.abs(got - points).max() < 0.2


@pytest.mark.parametrize("slope", [0.0, 0.3, 1.0, -0.5])
@pytest.mark.parametrize("wide", [0.01, 0.65, 3.3])
def test_a_straight_band_is_exact_in_every_pixel(slope: float, wide: float) -> None:
    """Away from its ends: the integral of how much of the pixel's column the band covers, by ten thousand columns."""
    line = np.array([[-20.0, 10.3 - 30 * slope, 0.5], [40.0, 10.3 + 30 * slope, 0.5]])
    got = white([line], [np.full(2, wide)], (20, 20))
    x = (np.arange(20 * 10_000) + 0.5) / 10_000
    middle = 10.3 + slope * (x - 10)
    half = wide / 2 * np.hypot(1, slope)
    rows = np.arange(20)[:, None]
    columns = np.clip(middle + half - rows, 0, 1) - np.clip(middle - half - rows, 0, 1)
    exact = columns.reshape(20, 20, -1).mean(2)
    blur = 0.07 if wide < 0.125 or abs(slope) < 1 / 16 else 3e-4  # what is widened for single precision's sake
    assert np.abs(got - exact).max() < blur * min(1, 8 * wide)
    turned = white([line[:, [1, 0, 2]]], [np.full(2, wide)], (20, 20))
    np.testing.assert_allclose(turned.T, got, atol=2e-6)


@pytest.mark.parametrize("slope", [0.1, 0.4, 0.8])
def test_a_blade_narrows_from_ribbon_to_point_as_points_say(slope: float) -> None:
    """In one piece, a ribbon, and in seven, of which the last are thin; where these begin, pixels are less exact."""
    for pieces in (1, 7):
        along = np.linspace(0, 1, pieces + 1)[:, None]
        line = np.array([-4.0, 8.3, 0.5]) + along * np.array([60, 60 * slope, 0])
        widths = 3.6 * (1 - along[:, 0])
        points = covered(line[:, :2], widths, 64, 64, 24)
        columns = np.abs(white([line], [widths], (64, 64)) - points)[:, 2:50].max(0)
        assert columns.max() < 0.15
        assert np.sort(columns)[-4] < 0.04


def test_joints_of_a_straight_strand_leave_no_trace() -> None:
    rng = np.random.default_rng(3)
    for wide in (0.02, 0.6, 2.5):
        for slope in (0.2, -0.9, 1.7, 30.0):
            share = np.sort(np.concatenate([[0, 1], rng.uniform(0, 1, 40)]))[:, None]
            line = np.array([10.0, 10, 0.5]) + share * np.array([40, 40 * slope, 0]) / np.hypot(1, slope)
            cut = white([line], [np.full(42, wide)], (60, 60))
            whole = white([line[[0, -1]]], [np.full(2, wide)], (60, 60))
            np.testing.assert_allclose(cut, whole, atol=6e-3 * min(wide, 1))


def crowd(seed: int, count: int = 120) -> tuple[list[np.ndarray], list[np.ndarray], np.ndarray]:
    rng = np.random.default_rng(seed)
    ends = rng.uniform([-10, -10, 0.1], [50, 40, 1], (count, 2, 3))
    widths = [np.full(2, wide) for wide in 10 ** rng.uniform(-2, 0.5, count)]
    return list(ends), widths, np.repeat(rng.uniform(0, 1, (count, 3)), 2, axis=0)


def test_layers_are_laid_over_each_other_by_depth() -> None:
    """Against one strand drawn after the other, far to near, over the picture so far."""
    strands, widths, colours = crowd(4)
    depth = np.random.default_rng(5).permutation(len(strands)) / 200 + 0.2
    strands = [np.column_stack([line[:, :2], np.full(2, d)]) for line, d in zip(strands, depth, strict=True)]
    image = np.full((30, 40, 3), 0.3)
    for i in np.argsort(depth):
        alpha = white([strands[i]], [widths[i]], (40, 30))[..., None]
        image += alpha * (colours[2 * i] - image)
    got = drawn(strands, widths, (40, 30), colours=colours, behind=0.3)
    assert np.abs(got - image).max() < 1 / 512
    faint = drawn(strands, widths, (40, 30), colours=colours, behind=0.3, opacity=0.01)
    assert np.abs(faint - 0.3).max() < 0.2 * np.abs(got - 0.3).max()


def test_neither_order_nor_threads_nor_memory_change_a_picture() -> None:
    strands, widths, colours = crowd(6)
    look: dict[str, Any] = {"size": (40, 30), "colours": colours, "behind": 0.3}
    one = drawn(strands, widths, **look)
    assert (one != np.float32(0.3)).mean() > 0.5
    for workers in (1, 2, 3, 7):
        for room in (400_000, 3_000):
            again = drawn(strands, widths, **look, workers=workers, room=room)
            np.testing.assert_array_equal(again, one)
    order = np.random.default_rng(7).permutation(len(strands))
    mixed = drawn(
        [strands[i] for i in order], [widths[i] for i in order], (40, 30),
        colours=colours.reshape(-1, 2, 3)[order].reshape(-1, 3), behind=0.3,
    )  # fmt: skip
    np.testing.assert_array_equal(mixed, one)


@pytest.mark.parametrize("opacity", [1.0, 0.3])
def test_white_on_white_is_white(opacity: float) -> None:
    strands, widths, _ = crowd(8, 400)
    image = drawn(strands, widths, (40, 30), behind=1.0, opacity=opacity)
    assert np.abs(image - 1).max() < 1e-5


def test_what_is_left_out_behind_a_whole_tile_is_what_its_pixels_hide() -> None:
    """Where a solid fills a tile, pieces behind all of it are left out as they are; a hole in it has them looked at."""
    strands, widths, colours = crowd(14, 300)
    strands = [np.column_stack([line[:, :2] * 2, line[:, 2]]) for line in strands]
    y, x = np.mgrid[:64, :96]
    hides = (0.35 + 0.3 * x / 96 + 0.1 * y / 64).astype(np.float32)
    holes = hides.copy()
    holes[::32, ::32] = 0
    whole, pierced = (
        drawn(strands, widths, (96, 64), colours=colours, behind=0.3, hides=one.ravel()) for one in (hides, holes)
    )
    kept = holes > 0
    np.testing.assert_array_equal(whole[kept], pierced[kept])
    assert (whole != pierced)[~kept].mean() > 0.3
    assert (whole[..., 0] != np.float32(0.3)).mean() > 0.5


@pytest.mark.parametrize("wide", [0.02, 0.3])
def test_points_on_a_strand_change_nothing(wide: float) -> None:
    """However many, and wherever among the pieces that are looked at together: but that pieces with points in between
    no longer follow each other, and where both are in a pixel cover it independently."""
    rng = np.random.default_rng(15)
    for pieces in (7, 63, 64, 65, 128, 300):
        line = bent(rng, 40, pieces, 0.2).astype(np.float32)
        again = np.where(rng.uniform(size=len(line)) < 0.3, rng.integers(1, 90, len(line)), 1)
        one = white([line], [np.full(len(line), wide)], (40, 40))
        other = white([np.repeat(line, again, 0)], [np.full(again.sum(), wide)], (40, 40))
        np.testing.assert_allclose(one, other, atol=wide**2)
        assert one.max() > 0.3 * min(wide, 1)


@pytest.mark.parametrize("count", [1, 8, 9, 129, 700])
def test_a_pixel_of_any_number_of_fragments_is_in_order(count: int) -> None:
    """Against the same laid one over the other; some as far as others, which go by their index."""
    rng = np.random.default_rng(16)
    depth = np.float32(0.1) + rng.integers(1, 2 * count, count).astype(np.float32) / (2 * count)
    strands = [np.array([[2.0, 1.5, d], [3.0, 1.5, d]]) for d in depth]
    colours = np.repeat(rng.uniform(0, 1, (count, 3)), 2, 0)
    wide = [np.full(2, 0.5)] * count
    opacity = min(4 / count, 1.0)
    image = drawn(strands, wide, (5, 3), colours=colours, opacity=opacity)
    expected = np.zeros(3)
    for i in np.lexsort((-np.arange(count), depth)):
        expected += 0.5 * opacity * (colours[2 * i] - expected)
    through = (1 - 0.5 * opacity) ** count
    np.testing.assert_allclose(image[1, 2], expected, atol=2e-5 if through > 1 / 512 else 1 / 256)
