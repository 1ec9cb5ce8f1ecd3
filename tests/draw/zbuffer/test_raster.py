"""The z-buffer of lines against a rasteriser that goes pixel by pixel, and by its properties."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from reference.lines import picture, samples
from strandcli.draw.common.kernels.keys import EMPTY
from strandcli.draw.common.scratch import Scratch
from strandcli.draw.geometry.curves import Polylines
from strandcli.draw.zbuffer import raster

LOW = np.uint64(0xFFFFFFFF)


def drawn(
    strands: list[np.ndarray],
    width: int,
    height: int,
    widths: list[np.ndarray] | None = None,
    workers: int = 2,
    base: int = 0,
) -> np.ndarray:
    """(height, width) keys of polylines, each (vertices, 3) of x, y and inverse depth."""
    first = np.cumsum([0, *map(len, strands)])
    screen = np.concatenate(strands).astype(np.float32).reshape(-1, 3)
    wide = None if widths is None else np.concatenate(widths).astype(np.float32)
    # what is drawn must stay inside: memory around the picture is watched
    memory = np.full(width * height + 2000, EMPTY)
    lines = Polylines(first, screen)
    raster.draw(lines, screen, wide, base, (width, height), workers, Scratch(), memory[1000:-1000])
    assert (memory[:1000] == EMPTY).all()
    assert (memory[-1000:] == EMPTY).all()
    return memory[1000:-1000].reshape(height, width)


def identity(keys: np.ndarray) -> np.ndarray:
    return np.where(keys == EMPTY, -1, (keys & LOW).astype(np.int64))


def depth(keys: np.ndarray) -> np.ndarray:
    return (LOW - (keys >> np.uint64(32))).astype(np.uint32).view(np.float32)


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize(("width", "height"), [(40, 30), (7, 200), (150, 1)])
def test_random_segments_agree_with_the_rule_pixel_by_pixel(seed: int, width: int, height: int) -> None:
    rng = np.random.default_rng(seed)
    count = 60
    a = rng.uniform([-20, -20, 0.1], [width + 20, height + 20, 1], (count, 3))
    b = a + rng.normal(0, [width / 4, height / 4, 0.1], (count, 3))
    b[:, 2] = np.abs(b[:, 2]) + 0.01
    a, b = (x.astype(np.float32).astype(np.float64) for x in (a, b))
    keys = drawn([np.stack(pair) for pair in zip(a, b, strict=True)], width, height)
    seen, best, lead = picture(list(zip(a, b, strict=True)), width, height)
    sure = lead > 1e-4
    assert sure.mean() > 0.6
    assert (seen >= 0).sum() > min(width, height)
    wrong = (identity(keys) // 2 != seen) & (identity(keys) != seen) & sure  # vertex 2 s begins segment s
    assert not wrong.any()
    inside = sure & (seen >= 0)
    np.testing.assert_allclose(depth(keys)[inside], best[inside], rtol=2e-5)


def test_joints_of_a_polyline_are_drawn_once() -> None:
    """Cut anywhere, a straight line covers the same pixels, one in each column, each by one piece."""
    rng = np.random.default_rng(1)
    for _ in range(20):
        cuts = np.sort(rng.uniform(2, 90, 12))
        line = np.stack([cuts, 10 + 0.37 * cuts, np.full(12, 0.5)], 1)
        keys = drawn([line], 100, 60)
        columns = (keys != EMPTY).sum(0)
        whole = samples(line[0], line[-1], 100, 60)
        assert columns.max() == 1
        np.testing.assert_array_equal(np.flatnonzero(columns), whole.x)
        # each column belongs to the piece that holds its centre
        piece = identity(keys).max(0)[whole.x]
        np.testing.assert_array_equal(piece, np.searchsorted(cuts, whole.x + 0.5, side="right") - 1)


def test_the_nearest_wins_in_whatever_order_and_equal_depths_go_to_the_first() -> None:
    near = np.array([[0.0, 5.2, 0.9], [20.0, 5.2, 0.9]])
    far = np.array([[0.0, 5.2, 0.2], [20.0, 5.2, 0.2]])
    for strands, wins in (([near, far], 0), ([far, near], 2), ([near, near], 0), ([far, far, near, near], 4)):
        assert set(identity(drawn(strands, 20, 10))[5]) == {wins}
    # crossing in depth: the front one changes in the middle
    rising = np.array([[0.0, 5.2, 0.2], [20.0, 5.2, 0.8]])
    falling = np.array([[0.0, 5.2, 0.8], [20.0, 5.2, 0.2]])
    row = identity(drawn([rising, falling], 20, 10))[5]
    np.testing.assert_array_equal(row, [2] * 10 + [0] * 10)


def test_vertices_that_are_not_seen_end_a_line() -> None:
    """A depth number of 0 marks what is behind the eye or too far out: pieces at it are left out."""
    line = np.array([[1.0, 5.2, 0.5], [6.0, 5.2, 0.5], [9.0, 5.2, 0.0], [12.0, 5.2, 0.5], [18.0, 5.2, 0.5]])
    row = identity(drawn([line], 20, 10))[5]
    assert [x for x in range(20) if row[x] >= 0] == [1, 2, 3, 4, 5, 12, 13, 14, 15, 16, 17]


@pytest.mark.parametrize("wide", [False, True])
def test_lines_are_clipped_at_every_border(wide: bool) -> None:
    """Far beyond the picture on all sides, still one straight line; `drawn` watches the memory around the picture."""
    for reach in (30.0, 1e4, 1e6, 9e7):
        for angle in np.linspace(0.05, 2 * np.pi, 23):
            way = np.array([np.cos(angle), np.sin(angle)]) * reach
            line = np.array([[*(16 - way), 0.5], [*(12 + way), 0.5]])
            widths = [np.array([3.0, 3.0])] if wide else None
            keys = drawn([line], 28, 24, widths)
            covered = keys != EMPTY
            if reach <= 1e4:
                y, x = np.nonzero(covered)
                normal = np.array([-(line[1, 1] - line[0, 1]), line[1, 0] - line[0, 0]])
                normal /= np.linalg.norm(normal)
                away = np.abs((np.stack([x, y], 1) + 0.5 - line[0, :2]) @ normal)
                assert away.max() < (2.2 if wide else 0.8) + 1e-6 * reach
                assert covered.sum() >= 20


@pytest.mark.parametrize("wide", [1.0, 3.0, 20.0])
@pytest.mark.parametrize("angle", [0.0, 44.0, 46.0, 200.0])
def test_the_area_of_a_ribbon_is_its_width_times_its_length(wide: float, angle: float) -> None:
    way = 90 * np.array([np.cos(np.radians(angle)), np.sin(np.radians(angle))])
    areas = []
    for k in range(16):  # every place within a pixel alike
        shift = np.array([k + 0.5, (5 * k) % 16 + 0.5]) / 16
        start = np.array([128, 128]) + shift
        line = np.array([[*start, 0.5], [*(start + way / 3), 0.5], [*(start + way), 0.5]])
        areas.append((drawn([line], 256, 256, [np.full(3, wide)]) != EMPTY).sum())
    assert np.mean(areas) == pytest.approx(90 * wide, rel=0.02)


@pytest.mark.parametrize("workers", [1, 3])
@pytest.mark.parametrize("wide", [60.0, 1e9])
def test_ribbons_wider_than_the_picture_cover_what_lies_within_half_their_width(wide: float, workers: int) -> None:
    """Of strands in and beside the picture; the nearest is seen, whichever came first."""
    rng = np.random.default_rng(9)
    lines = []
    for _ in range(12):
        begin, way = rng.uniform([-200, -200], [260, 330]), rng.normal(size=2) * 150
        near, far = rng.uniform(0.1, 1, 2)
        lines.append(np.array([[*begin, near], [*(begin + way), far]]))
    keys = drawn(lines, 60, 130, [np.full(2, wide)] * 12, workers)
    best, who, sure = np.zeros((130, 60)), np.full((130, 60), -1), np.ones((130, 60), bool)
    y, x = np.mgrid[:130, :60] + 0.5
    for number, ((x0, y0, q0), (x1, y1, q1)) in enumerate(lines):
        dx, dy = x1 - x0, y1 - y0
        size = np.hypot(dx, dy)
        t = ((x - x0) * dx + (y - y0) * dy) / size**2
        off = np.abs((x - x0) * dy - (y - y0) * dx) / size - wide / 2
        q = np.where((t >= 0) & (t <= 1) & (off < 0), q0 + t * (q1 - q0), 0)
        edge = (np.abs(off) < 1e-3) | (np.abs(t * size) < 1e-3) | (np.abs((t - 1) * size) < 1e-3)
        sure &= ~edge & ((np.abs(q - best) > 1e-3) | (q == 0))
        who, best = np.where(q > best, 2 * number, who), np.maximum(q, best)
    assert sure.mean() > 0.9
    assert 0.3 < (who >= 0).mean() <= 1
    np.testing.assert_array_equal(identity(keys)[sure], who[sure])


@pytest.mark.parametrize("angle", [0.0, 60.0, 215.0])
def test_a_ribbon_narrows_without_steps(angle: float) -> None:
    """From 14 to 2 pixels: each cut across is as wide as the line is there."""
    way = 90 * np.array([np.cos(np.radians(angle)), np.sin(np.radians(angle))])
    start = np.array([128.3, 128.6])
    seen = drawn([np.array([[*start, 0.5], [*(start + way), 0.5]])], 256, 256, [np.array([14.0, 2.0])]) != EMPTY
    assert seen.sum() == pytest.approx(90 * 8, rel=0.03)
    y, x = np.nonzero(seen)
    along = ((np.stack([x, y], 1) + 0.5 - start) @ way) / 90
    for middle in (20, 45, 70):
        here = (along > middle - 5) & (along < middle + 5)
        assert here.sum() / 10 == pytest.approx(14 - 12 * middle / 90, abs=0.9)


@pytest.mark.parametrize("angle", [0.0, 43.0, 47.0, 90.0])
@pytest.mark.parametrize("turn", [4.0, 40.0, 150.0])
def test_a_ribbon_that_bends_has_neither_gaps_nor_notches(angle: float, turn: float) -> None:
    """Pieces follow x and y by turns; what lies within half a width of the middle is covered, and nothing else but the
    corners of mitres. Each pixel is one piece's, the one that it lies beside."""
    wide = 12.0
    ways = np.radians(angle + turn * np.array([-0.5, 0.5, -0.5, 0.5, -0.5]))
    steps = 17 * np.stack([np.cos(ways), np.sin(ways)], 1)
    line = np.concatenate([[[0, 0]], steps.cumsum(0)])
    line += 64.3 - line.mean(0)
    seen = identity(drawn([np.insert(line, 2, 0.5, axis=1)], 128, 128, [np.full(6, wide)]))
    y, x = np.mgrid[:128, :128] + 0.5
    places = np.stack([x, y], 2)[..., None, :]
    t = np.clip(((places - line[:-1]) * steps).sum(-1) / 17**2, 0, 1)
    away = np.linalg.norm(places - line[:-1] - t[..., None] * steps, axis=-1)
    # but for what is beyond the strand's ends, which are straight
    inside = (away.min(2) < wide / 2 - 0.01) & ~((t[..., 0] == 0) & (away[..., 1:].min(2) > wide / 2))
    inside &= ~((t[..., -1] == 1) & (away[..., :-1].min(2) > wide / 2))
    assert inside.sum() > 0.5 * wide * 85 * np.cos(np.radians(turn / 2))
    assert not (inside & (seen < 0)).any()
    corner = wide / 2 / np.cos(np.radians(min(turn, 90.0) / 2)) + 0.01
    assert away.min(2)[seen >= 0].max() < max(corner, np.hypot(wide / 2, 0.01) + 0.01)
    if turn < 90:
        sure = (seen >= 0) & (np.sort(away, 2)[..., 1] - away.min(2) > 0.01)
        assert sure.sum() > 0.6 * (seen >= 0).sum()
        np.testing.assert_array_equal(away.argmin(2)[sure], seen[sure])


def test_a_depth_that_rounds_below_zero_does_not_come_to_the_front() -> None:
    """Eight thousand steps from very near to very far: what rounding adds up is more than the far end."""
    rng = np.random.default_rng(7)
    front = np.array([[8000.0, 0.5, 0.5], [8192.0, 0.5, 0.5]])
    for _ in range(150):
        line = np.array([[rng.uniform(0, 5), 0.5, 100.0], [8191.5 + rng.uniform(0, 0.01), 0.5, 1e-5]])
        keys = drawn([line, front], 8192, 1)
        assert identity(keys)[0, -1] == 2


@settings(max_examples=150, deadline=None)
@given(
    st.lists(
        st.tuples(*[st.floats(-1e8, 1e8, width=32) | st.floats(-5, 20, width=32)] * 2, st.floats(0, 1000, width=32)),
        min_size=1,
        max_size=6,
    ),
    st.sampled_from([None, 1.0, 7.0, 1e4]),
)
def test_whatever_the_coordinates_only_the_picture_is_written(
    points: list[tuple[float, float, float]], wide: float | None
) -> None:
    line = np.array(points)
    keys = drawn([line], 15, 12, None if wide is None else [np.full(len(line), wide)])
    there = keys[keys != EMPTY]
    assert ((there & LOW) < len(line)).all()
    assert np.isfinite(depth(there)).all()
