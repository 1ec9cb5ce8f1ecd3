"""Fragments behind what hides most of them, which take light from fewer vertices."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from strandcli.draw.common.scratch import Scratch
from strandcli.draw.coverage import coverage
from strandcli.draw.coverage.coverage import FAINT, SLIGHT, Coverage
from strandcli.draw.coverage.kernels.tiles import alone, between, over_two, rank_of
from strandcli.draw.geometry.curves import Polylines

SIZE = (48, 40)
VERTICES = 8
"""Of a strand: the last has an odd rank."""
OPACITY = 0.8
VEILS, NEAR = 2, 0.95
THROUGH = (1 - OPACITY) ** VEILS
assert float(SLIGHT) > THROUGH > float(FAINT)


def strands(count: int, vertices: int = VERTICES) -> np.ndarray:
    """(count, vertices, 3) of x, y and depth number: at random."""
    rng = np.random.default_rng(3)
    across = np.linspace(2, 44, vertices) + np.zeros((count, 1))
    down = rng.uniform(2, 38, (count, 1)) + rng.normal(0, 3, (count, vertices)).cumsum(1)
    return np.stack([across, down, rng.uniform(0.2, 0.9, (count, 1)) + 0 * across], 2).astype(np.float32)


def drawn(
    lines: np.ndarray, width: float, colours: np.ndarray, room: int = 400_000, exact: bool = False, veiled: bool = True
) -> tuple[np.ndarray, np.ndarray, int]:
    """The picture of strands of one width on black, perhaps behind a black veil that lets through `THROUGH` of their
    light, over that; the vertices that were lit, and the number of layers."""
    if veiled:
        vertices = lines.shape[1]
        veil = np.stack([np.linspace(-100, 200, vertices), np.full(vertices, 20.0), np.full(vertices, NEAR)], 1)
        lines = np.concatenate([np.repeat(veil[None], VEILS, 0), lines]).astype(np.float32)
        lines[:VEILS, :, 2] += np.arange(VEILS, dtype=np.float32)[:, None] * 0.01
        colours = np.concatenate([np.zeros((VEILS * lines.shape[1], 3), np.float32), colours])
    screen = np.ascontiguousarray(lines.reshape(-1, 3))
    first = np.arange(0, len(screen) + 1, lines.shape[1])
    widths = np.full(len(screen), width / OPACITY, np.float32)
    widths[: VEILS * lines.shape[1] * veiled] = 300
    image, lit, layers = np.zeros((*SIZE[::-1], 3), np.float32), np.zeros(len(screen), bool), 0
    more: dict[str, Any] = {"exact": exact}
    for layer in Coverage(SIZE, OPACITY, room).layers(
        Polylines(first, screen), screen, widths, None, 1, Scratch(), **more
    ):  # fmt: skip
        lit |= layer.marks != 0
        seen = np.where(lit[:, None], colours, np.nan).astype(np.float32)
        layer.blend(seen, image)
        layers += 1
    if veiled:
        image, lit = image / THROUGH, lit[VEILS * lines.shape[1] :]
    return image, lit.reshape(-1, lines.shape[1]), layers


def lit_by(lines: np.ndarray) -> np.ndarray:
    """The vertices that were lit of strands behind a veil."""
    white = np.ones((lines.size // 3, 3), np.float32)
    image, lit, _ = drawn(lines, 0.006, white)
    assert np.isfinite(image).all()
    exact, all_lit, _ = drawn(lines, 0.006, white, exact=True)
    assert all_lit.mean() > 0.9
    np.testing.assert_allclose(image, exact, atol=1e-6)
    return lit


@pytest.mark.parametrize("vertices", [5, 6, 7, 8, 9])
def test_behind_nearly_all_strands_are_lit_at_every_fourth_vertex(monkeypatch, vertices) -> None:
    """And at the last one, or one beside it, where these do not reach the end."""
    monkeypatch.setattr(coverage, "FAINT", np.float32(0.1))
    lit = lit_by(strands(40, vertices))
    fourth = np.arange(vertices) % 4 == 0
    assert lit[:, fourth & (np.arange(vertices) < vertices - 2)].mean() > 0.9
    assert not lit[:, ~fourth & (np.arange(vertices) < vertices - 2)].any()


@pytest.mark.parametrize("vertices", [3, 4, 5, 8, 9])
def test_behind_most_strands_are_lit_at_every_second_vertex(vertices) -> None:
    lit = lit_by(strands(40, vertices))
    assert lit[:, ::2].mean() > 0.9
    assert lit[:, -1].mean() > 0.8
    odd = lit[:, 1:-1:2]  # where their number is even the last segment has the one before it in the middle
    assert not (odd if vertices % 2 else odd[:, :-1]).any()
    white = np.ones((40 * vertices, 3), np.float32)
    # however thin they are; some leave the picture
    assert drawn(strands(40, vertices), 0.006, white, veiled=False)[1].mean() > 0.9


def test_strands_of_one_segment_are_lit_at_both_ends() -> None:
    assert lit_by(strands(40, 2)).all(1).mean() > 0.8


def test_light_is_between_that_of_every_second_vertex() -> None:
    """Where it rises along strands, it is right everywhere; where it is that of the middle vertex alone, it is not
    seen."""
    lines = strands(30)
    rise = np.tile(np.arange(VERTICES, dtype=np.float32)[:, None], (len(lines), 3))
    thin, _, _ = drawn(lines, 0.002, rise)
    exact, _, _ = drawn(lines, 0.002, rise, exact=True)
    np.testing.assert_allclose(thin, exact, atol=2e-5 * VERTICES)


def test_light_is_that_of_the_nearer_of_every_fourth_vertex(monkeypatch) -> None:
    """Where it rises along strands, it is right in the mean; nowhere is it farther off than two vertices."""
    monkeypatch.setattr(coverage, "FAINT", np.float32(0.1))
    lines = strands(30, 9)
    rise = np.tile(np.arange(9, dtype=np.float32)[:, None], (len(lines), 3))
    thin, _, _ = drawn(lines, 0.002, rise)
    exact, _, _ = drawn(lines, 0.002, rise, exact=True)
    cover, _, _ = drawn(lines, 0.002, np.ones_like(rise))
    off = (thin - exact)[cover > 0] / cover[cover > 0]
    assert 1.9 < np.abs(off).max() <= 2.001
    inner = slice(8, 38)  # as much before these vertices as after them
    assert abs((thin - exact)[:, inner].sum() / cover[:, inner].sum()) < 0.2


def test_neither_layers_nor_the_order_of_strands_change_a_bit() -> None:
    lines = strands(150)
    colours = np.random.default_rng(4).uniform(0, 1, (lines.size // 3, 3)).astype(np.float32)
    image, lit, layers = drawn(lines, 1.0, colours, veiled=False)
    assert layers == 1
    assert 0.5 < lit.mean() < 0.95
    in_parts, lit_in_parts, parts = drawn(lines, 1.0, colours, room=4000, veiled=False)
    assert parts > 1
    np.testing.assert_array_equal(in_parts, image)
    np.testing.assert_array_equal(lit_in_parts, lit)
    turned, _, _ = drawn(lines[::-1], 1.0, colours.reshape(-1, VERTICES, 3)[::-1].reshape(-1, 3), veiled=False)
    np.testing.assert_allclose(turned, image, atol=1e-6)


def test_the_place_of_such_a_fragment_is_kept() -> None:
    for vertex, place in ((8, 0.0), (8, 0.75), (9, 0.5), (7, 0.0), (7, 0.75), (6, 0.0), (6, 0.25)):
        told = alone.py_func(np.float32(vertex - 8 + place))
        assert told < 0
        assert between.py_func(8, told, 1) == (vertex, place)
    for odd, place in ((0, 0.0), (0, 0.75), (1, 0.0), (1, 0.5)):
        told = over_two.py_func(np.float32(place), odd)
        assert 2 <= told < 3
        assert between.py_func(6, told, 4) == (6 + 4 * odd, place)
    assert between.py_func(3, np.float32(0.25), 1) == (3, np.float32(0.25))


@pytest.mark.parametrize("stride", [1, 4])
@pytest.mark.parametrize("segments", range(1, 10))
def test_no_segment_takes_light_from_beyond_its_strand(stride, segments) -> None:
    begin, last = 100, 100 + segments * stride
    for v in range(begin, last):
        rank, piece = divmod(rank_of.py_func(v, begin, last + 1, stride), stride)
        lit = v - piece
        assert (lit - begin) % stride == 0
        fourth = lit + ((rank & 2) * 2 - rank) * stride
        low = lit - (rank & 1) * stride
        assert begin <= fourth <= last
        if segments > 1:
            assert begin <= low
            assert low + 2 * stride <= last
