"""Coverage at its ends: very wide strands, very many, any coordinates, and what is known before."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from strandcli.draw.common.scratch import Scratch
from strandcli.draw.coverage.coverage import Coverage
from strandcli.draw.geometry.curves import Polylines
from strandcli.draw.geometry.kernels.ribbon import ScreenLines
from strandcli.errors import RefusedError
from tests.draw.coverage.test_coverage import bent, hiding, white


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
        coverage._estimate(ScreenLines(first, screen, widths))
        rows.append(coverage._rows.copy())
    np.testing.assert_allclose(rows[1], rows[0], atol=1e-4)
    for _ in coverage.layers(Polylines(first, screen), screen, widths, None, 1, Scratch()):
        pass
    assert rows[0].sum() == pytest.approx(coverage.fragments, rel=0.4)
