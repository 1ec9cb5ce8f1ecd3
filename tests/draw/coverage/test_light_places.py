"""Light of faint fragments comes from coarser places: exact where it is linear along strands, nowhere undefined."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from numba import njit
from numpy.typing import NDArray

from strandcli.constants import FRAGMENTS
from strandcli.draw.common.scratch import Scratch
from strandcli.draw.coverage.coverage import Coverage
from strandcli.draw.coverage.kernels import tiles
from strandcli.draw.coverage.kernels.tiles import GROUP
from strandcli.draw.geometry.curves import Polylines

WIDTH, HEIGHT = 40, 48


of_segment = tiles.segment_number


@njit
def segment_number(past, count, stride, grouped):  # type: ignore[no-untyped-def]
    """Only compiled functions can call it."""
    return of_segment(past, count, stride, grouped)


@settings(deadline=None)
@given(st.integers(1, 40))
def test_a_group_ends_within_its_strand(count: int) -> None:
    """Segments are numbered in their group from the strand's beginning; those after the last whole group have none."""
    numbers = [segment_number(past, count, 1, 1) for past in range(count)]
    whole = count // GROUP * GROUP
    assert numbers == [past % GROUP for past in range(whole)] + [GROUP] * (count - whole)
    assert [segment_number(past, count, 4, 0) for past in range(count)] == [past % 4 for past in range(count)]


def crowd(seed: int, wide: float) -> tuple[Polylines, NDArray[np.float32], NDArray[np.float32]]:
    """Some hundred strands of 3 to 30 vertices, wavy and behind each other, on the screen; and their widths."""
    rng = np.random.default_rng(seed)
    lengths = rng.integers(3, 31, 700)
    first = np.cumsum([0, *lengths])
    steps = rng.normal(0, 1.0, (first[-1], 3)) * [1, 1, 0.002] + [0, 1.5, 0]
    starts = rng.uniform([0, -8, 0.3], [WIDTH, HEIGHT, 0.7], (len(lengths), 3))
    screen = np.concatenate([one + steps[a:b].cumsum(0) for one, (a, b) in zip(starts, pairwise(first), strict=True)])
    return Polylines(first, screen.astype(np.float32)), screen.astype(np.float32), np.full(len(screen), wide, "f4")


def picture(
    lines: Polylines, screen: NDArray[np.float32], widths: NDArray[np.float32], light: NDArray[np.float32],
    room: int = FRAGMENTS, workers: int = 1,
) -> tuple[NDArray[np.float32], int]:  # fmt: skip
    """The picture of strands of this light (V, 3), undefined where it is not asked for; and at how many it is."""
    image, asked = np.zeros((HEIGHT, WIDTH, 3), np.float32), np.full_like(light, np.nan)
    for layer in Coverage((WIDTH, HEIGHT), 1.0, room).layers(lines, screen, widths, None, workers, Scratch()):
        asked[layer.marks > 0] = light[layer.marks > 0]
        layer.blend(asked, image)
    return image, int(np.isfinite(asked[:, 0]).sum())


def by_all_vertices(
    lines: Polylines, screen: NDArray[np.float32], widths: NDArray[np.float32], light: NDArray[np.float32]
) -> NDArray[np.float32]:
    """The picture with light of the two vertices next to each fragment."""
    image = np.zeros((HEIGHT, WIDTH, 3), np.float32)
    for layer in Coverage((WIDTH, HEIGHT), 1.0).layers(lines, screen, widths, None, 1, Scratch()):
        found = layer.fragments
        coarse = found.along >= tiles.COARSE
        place = (found.along - tiles.COARSE) * GROUP
        piece = np.where(coarse, np.clip(np.floor(place), 0, GROUP - 1), 0)
        along = np.where(coarse, place - piece, found.along).astype(np.float32)
        fine = found._replace(vertex=(found.vertex + piece).astype(np.uint32), along=along)
        replace(layer, fragments=fine).blend(light, image)
    return image


def test_linear_light_is_exact_and_nothing_else_is_read() -> None:
    """Light that grows evenly along each strand is the same by coarse places as by all; fewer are asked for."""
    lines, screen, widths = crowd(1, 0.25)
    light = np.empty_like(screen)
    for a, b in pairwise(lines.first):
        light[a:b] = np.linspace([0.1, 0.2, 0.9], [0.8, 0.2, 0.1], b - a)
    found, few = picture(lines, screen, widths, light)
    assert np.isfinite(found).all()
    flat, _ = picture(lines, screen, widths, np.ones_like(light))
    assert flat.max() > 0.98  # crowded
    assert few < 0.95 * len(screen)
    np.testing.assert_allclose(found, by_all_vertices(lines, screen, widths, light), atol=2e-6)


def test_strands_that_are_lit_at_every_other_vertex_have_light_of_these_alone() -> None:
    """Their light is at coarse places already, and no group is asked for."""
    lines, screen, widths = crowd(3, 0.1)
    first = lines.first // 2 * 2
    first[1:] += 1  # an even number of segments
    first = first[:2]
    layers = Coverage((WIDTH, HEIGHT), 1.0).layers(
        Polylines(first, lines.world[: first[-1]], per=2, stride=2), screen[: first[-1]], widths[: first[-1]], None, 1,
        Scratch(),
    )  # fmt: skip
    marks = next(iter(layers)).marks
    assert len(marks) == first[-1]
    assert marks[::2].any()
    assert not marks[1::2].any()


def test_light_that_bends_differs_little_and_layers_threads_and_order_do_not_matter() -> None:
    """A light that varies as highlights do: a share of a per cent off; the same bits in any division of the work, and
    with strands in any order in memory."""
    lines, screen, widths = crowd(2, 0.2)
    light = np.sin(0.35 * np.arange(len(screen), dtype=np.float32))[:, None] * np.float32([0.4, 0.3, 0.2]) + 0.5
    light = light.astype(np.float32)
    found, _ = picture(lines, screen, widths, light)
    for room, workers in ((60_000, 1), (FRAGMENTS, 2), (40_000, 3)):
        again, _ = picture(lines, screen, widths, light, room, workers)
        np.testing.assert_array_equal(again, found)
    order = np.random.default_rng(5).permutation(len(lines.first) - 1)
    rows = np.concatenate([np.arange(lines.first[s], lines.first[s + 1]) for s in order])
    first = np.cumsum([0, *np.diff(lines.first)[order]])
    again, _ = picture(Polylines(first, lines.world[rows]), screen[rows], widths[rows], light[rows])
    np.testing.assert_array_equal(again, found)
    exact = by_all_vertices(lines, screen, widths, light)
    off = float(np.sqrt(np.mean((found - exact) ** 2)) / exact.mean())
    assert 0 < off < 0.01
