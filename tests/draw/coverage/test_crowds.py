"""Coverage at its ends: very wide strands, very many, any coordinates, and what is left out because nobody sees it."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from strandcli.draw.common.scratch import Scratch
from strandcli.draw.coverage import coverage
from strandcli.draw.coverage.coverage import SLIGHT, Coverage
from strandcli.draw.geometry.curves import Polylines
from strandcli.draw.geometry.kernels.ribbon import ScreenLines
from strandcli.errors import RefusedError
from tests.draw.coverage.test_coverage import bent, hiding, white

WIDTH, HEIGHT = 32, 24


def crowd(seed: int, count: int, low: float, high: float, wide: float) -> tuple[np.ndarray, np.ndarray]:
    """Strands (count, 2, 3) across the picture, with depth numbers from low to high, and their widths (count, 2)."""
    rng = np.random.default_rng(seed)
    ends = np.zeros((count, 2, 3))
    ends[:, :, 0] = [-1, WIDTH + 1]
    ends[:, :, 1] = rng.uniform(-4, HEIGHT + 4, (count, 1)) + rng.uniform(-3, 3, (count, 2))
    ends[:, :, 2] = rng.uniform(low, high, (count, 1))
    return ends, np.full((count, 2), wide)


def drawn(
    ends: np.ndarray, wide: np.ndarray, light: np.ndarray, workers: int = 1, opacity: float = 1.0
) -> tuple[np.ndarray, int]:
    """The picture of strands of these lights, (count, 3), and the number of fragments found."""
    screen = ends.reshape(-1, 3).astype(np.float32)
    image = np.full((HEIGHT, WIDTH, 3), 9, np.float32)
    coverage = Coverage((WIDTH, HEIGHT), opacity)
    first = np.arange(0, len(screen) + 1, 2)
    widths = wide.reshape(-1).astype(np.float32)
    for layer in coverage.layers(Polylines(first, screen), screen, widths, None, workers, Scratch()):
        layer.blend(np.repeat(light, 2, 0).astype(np.float32), image)
    return image, coverage.fragments


def test_what_stands_behind_a_crowd_changes_nothing_and_is_not_listed() -> None:
    """Thousands of strands behind some that let no light through, whether they come before or after these, and in the
    middle of the picture alone, where other pixels show what is behind."""
    rng = np.random.default_rng(1)
    front, wide = crowd(2, 1500, 0.5, 0.6, 0.3)
    light = rng.uniform(0, 1, (len(front), 3))
    alone, few = drawn(front, wide, light)
    assert alone.max() < 1.01  # nothing shows the background
    back, back_wide = crowd(3, 9000, 0.1, 0.49, 0.3)
    black = np.zeros((len(back), 3))
    for turn in (1, -1):
        ends, widths, lights = (
            np.concatenate(both[::turn]) for both in ((front, back), (wide, back_wide), (light, black))
        )
        for workers in (1, 3):
            image, found = drawn(ends, widths, lights, workers)
            np.testing.assert_array_equal(image, alone)
            assert found < 1.5 * few, "of the strands behind, six times as many, few are listed"
    narrow = front.copy()
    narrow[:, 1, 0] = WIDTH / 2
    ends, widths, lights = (
        np.concatenate([back, narrow]),
        np.concatenate([back_wide, wide]),
        np.concatenate([black, light]),
    )
    image, _ = drawn(ends, widths, lights)
    behind, _ = drawn(back, back_wide, black)
    np.testing.assert_array_equal(image[:, WIDTH // 2 + 1 :], behind[:, WIDTH // 2 + 1 :])


def test_transparent_strands_that_hide_others_together_leave_these_out_while_they_are_found() -> None:
    """Wide strands that let two fifths through, before others, in a tile of fewer rows than are ordered."""
    front, wide = crowd(6, 220, 0.5, 0.6, 3.0)
    back, back_wide = crowd(7, 150, 0.1, 0.4, 3.0)
    light = np.random.default_rng(8).uniform(0, 1, (len(front), 3))
    alone, few = drawn(front, wide, light, opacity=0.6)
    both = np.concatenate([front, back]), np.concatenate([wide, back_wide]), np.concatenate([light, 0 * light[:150]])
    image, found = drawn(*both, opacity=0.6)
    np.testing.assert_array_equal(image, alone)
    assert found < 1.05 * few


def test_a_crowd_of_faint_strands_is_seen_to_its_end() -> None:
    """A thousand strands behind each other let half of the light through: all of them count."""
    ends, wide = crowd(4, 3000, 0.2, 0.9, 0.003)
    both, found = drawn(ends, wide, np.zeros((len(ends), 3)))
    assert found > 2000 * WIDTH  # those that cross the picture
    front, back = ends[ends[:, 0, 2] > 0.5], ends[ends[:, 0, 2] <= 0.5]
    one = drawn(front, wide[: len(front)], np.zeros((len(front), 3)))[0].astype(np.float64) / 9
    two = drawn(back, wide[: len(back)], np.zeros((len(back), 3)))[0].astype(np.float64) / 9
    np.testing.assert_allclose(both / 9, one * two, rtol=2e-4)


@pytest.mark.parametrize("hidden", [False, True])
def test_behind_wide_opaque_strands_nothing_is_kept(hidden: bool) -> None:
    """Of so many strands in any order, each over the whole picture, a pixel keeps those that are in front of all before
    them: about the logarithm of their number."""
    count = 4000
    depth = np.random.default_rng(5).permutation(count) / count + 0.1
    screen = np.array([[[-40.0, 12.0, d], [80.0, 12.0, d]] for d in depth], np.float32).reshape(-1, 3)
    lines, widths = Polylines(np.arange(0, 2 * count + 1, 2), screen), np.full(2 * count, 90.0, np.float32)
    colours = np.repeat(np.random.default_rng(6).uniform(0, 1, (count, 3)).astype(np.float32), 2, axis=0)
    edges = None
    if hidden:  # by a solid in the left half
        hides = np.zeros((24, 40), np.float32)
        hides[:, :20] = 2
        edges = hiding(hides.ravel())
    for faint in (0.0, 0.01):
        coverage = Coverage((40, 24), 1.0 - faint)
        image = np.zeros((24, 40, 3), np.float32)
        for layer in coverage.layers(lines, screen, widths, edges, 1, Scratch()):
            layer.blend(colours, image)
        seen = image[:, 20:] if hidden else image
        front = colours[2 * int(depth.argmax())]
        assert coverage.fragments < 30 * seen[..., 0].size
        np.testing.assert_allclose(seen, np.broadcast_to(front, seen.shape), atol=1e-6 + faint)
        assert not hidden or not image[:, :20].any()


def test_too_many_in_one_row_are_refused_by_name() -> None:
    line = np.array([[0.0, 0.5, 0.5], [40.0, 0.6, 0.5]])
    with pytest.raises(RefusedError, match=r"row 0 of the picture holds .* fragments of strands"):
        white([line] * 50, [np.full(2, 0.5)] * 50, (40, 1), room=1000)
    assert white([line] * 50, [np.full(2, 0.5)] * 50, (40, 1), room=9000).max() > 0.99


@settings(max_examples=60, deadline=None)
@given(
    st.lists(
        st.tuples(*[st.floats(-1e8, 1e8, width=32) | st.floats(-5, 20, width=32)] * 2, st.floats(0, 1000, width=32)),
        min_size=1,
        max_size=6,
    ),
    st.sampled_from([None, 0.0, 1e-9, 0.003, 0.5, 7.0, 1e4]),
)
def test_whatever_the_coordinates_pixels_are_numbers_between_black_and_white(
    points: list[tuple[float, float, float]], wide: float | None
) -> None:
    line = np.array(points)
    image = white([line], None if wide is None else [np.full(len(line), wide)], (15, 12))
    assert np.isfinite(image).all()
    assert image.min() >= 0
    assert image.max() <= 1 + 1e-5


@settings(max_examples=40, deadline=None)
@given(
    st.lists(st.tuples(*[st.floats(-1e-5, 1e-5)] * 2), min_size=1, max_size=12),
    # not cut by the picture's border: a mitre takes from one side of the middle what it adds on the other
    st.floats(2, 10),
    st.floats(2, 10),
    st.sampled_from([0.01, 0.5, 3.0]),
)
def test_slivers_and_points_cover_no_more_than_their_length(
    steps: list[tuple[float, float]], x: float, y: float, wide: float
) -> None:
    walk = np.concatenate([[[x, y]], np.array([x, y]) + np.cumsum(steps, 0)])
    line = np.column_stack([walk, np.full(len(walk), 0.5)]).astype(np.float32)
    length = np.linalg.norm(np.diff(line[:, :2].astype(np.float64), axis=0), axis=1).sum()
    image = white([line], [np.full(len(line), wide)], (12, 12))
    assert np.isfinite(image).all()
    assert image.sum() <= 1.1 * length * wide + 2e-5


def test_fragments_of_a_first_frame_are_foreseen_and_strands_beside_the_picture_count_for_nothing() -> None:
    rng = np.random.default_rng(8)
    strands = [bent(rng, 96, 80, 0.3) for _ in range(100)]
    beside = [line + np.array([away, 0, 0]) for line in strands for away in (-400, 400)]
    rows = []
    for lines in (strands, strands + beside):
        screen = np.ascontiguousarray(np.concatenate(lines), np.float32)
        first, widths = np.cumsum([0, *map(len, lines)]), np.full(len(screen), 2, np.float32)
        coverage = Coverage((96, 80), 1.0)
        rows.append(coverage.estimate(ScreenLines(first, screen, widths)))
    np.testing.assert_allclose(rows[1], rows[0], atol=1e-4)
    for _ in coverage.layers(Polylines(first, screen), screen, widths, None, 1, Scratch()):
        pass
    assert rows[0].sum() == pytest.approx(coverage.fragments, rel=0.4)


SIZE = (48, 40)
VERTICES = 8
"""Of a strand: the last has an odd rank."""
OPACITY = 0.8
VEILS, NEAR = 2, 0.95
THROUGH = (1 - OPACITY) ** VEILS
assert float(SLIGHT) > THROUGH


def strands(count: int) -> np.ndarray:
    """(count, VERTICES, 3) of x, y and depth number: at random."""
    rng = np.random.default_rng(3)
    across = np.linspace(2, 44, VERTICES) + np.zeros((count, 1))
    down = rng.uniform(2, 38, (count, 1)) + rng.normal(0, 3, (count, VERTICES)).cumsum(1)
    return np.stack([across, down, rng.uniform(0.2, 0.9, (count, 1)) + 0 * across], 2).astype(np.float32)


def fragments_of(
    lines: np.ndarray, width: float, colours: np.ndarray, room: int = 400_000, veiled: bool = True
) -> tuple[np.ndarray, np.ndarray, int]:
    """The picture of strands of one width on black, perhaps behind a black veil that lets through `THROUGH` of their
    light, over that; the vertices that were lit, and the number of layers."""
    if veiled:
        veil = np.stack([np.linspace(-100, 200, VERTICES), np.full(VERTICES, 20.0), np.full(VERTICES, NEAR)], 1)
        lines = np.concatenate([np.repeat(veil[None], VEILS, 0), lines]).astype(np.float32)
        lines[:VEILS, :, 2] += np.arange(VEILS, dtype=np.float32)[:, None] * 0.01
        colours = np.concatenate([np.zeros((VEILS * VERTICES, 3), np.float32), colours])
    screen = np.ascontiguousarray(lines.reshape(-1, 3))
    first = np.arange(0, len(screen) + 1, lines.shape[1])
    widths = np.full(len(screen), width / OPACITY, np.float32)
    widths[: VEILS * VERTICES * veiled] = 300
    image, lit, layers = np.zeros((*SIZE[::-1], 3), np.float32), np.zeros(len(screen), bool), 0
    for layer in Coverage(SIZE, OPACITY, room).layers(Polylines(first, screen), screen, widths, None, 1, Scratch()):
        lit |= layer.marks != 0
        seen = np.where(lit[:, None], colours, np.nan).astype(np.float32)
        layer.blend(seen, image)
        layers += 1
    if veiled:
        image, lit = image / THROUGH, lit[VEILS * VERTICES :]
    return image, lit.reshape(-1, VERTICES), layers


def test_strands_of_little_weight_are_lit_at_every_second_vertex(monkeypatch: pytest.MonkeyPatch) -> None:
    lines = strands(40)
    white = np.ones((lines.size // 3, 3), np.float32)
    thin, lit, _ = fragments_of(lines, 0.006, white)
    assert lit[:, ::2].mean() > 0.95
    assert not lit[:, 1::2].any()
    assert np.isfinite(thin).all()
    assert fragments_of(lines, 0.006, white, veiled=False)[1].mean() > 0.95  # some leave the picture
    monkeypatch.setattr(coverage, "SLIGHT", np.float32(0))
    exact, all_lit, _ = fragments_of(lines, 0.006, white)
    assert all_lit.mean() > 0.95
    np.testing.assert_allclose(thin, exact, atol=1e-6)


def test_light_is_that_of_the_nearer_even_vertex(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where it rises along strands, it is right in the mean; nowhere is it farther off than one vertex."""
    lines = strands(30)
    rise = np.tile(np.arange(VERTICES, dtype=np.float32)[:, None], (len(lines), 3))
    thin, _, _ = fragments_of(lines, 0.002, rise)
    cover, _, _ = fragments_of(lines, 0.002, np.ones_like(rise))
    monkeypatch.setattr(coverage, "SLIGHT", np.float32(0))
    exact, _, _ = fragments_of(lines, 0.002, rise)
    off = (thin - exact)[cover > 0] / cover[cover > 0]
    assert 0.9 < np.abs(off).max() <= 1.001
    inner = slice(8, 32)  # as much before even vertices as after them
    assert abs((thin - exact)[:, inner].sum() / cover[:, inner].sum()) < 0.05
