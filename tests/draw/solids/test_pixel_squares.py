"""Pixels of solids are found square by square: those to be shaded, each once."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import pytest
from numba import njit

from strandcli.draw.common.kernels.keys import EMPTY, FIRST
from strandcli.draw.solids.kernels import pixel_squares

of_squares, places = pixel_squares.find_pixels, pixel_squares.places_in


class Screen(NamedTuple):
    """What is read of `inputs.Screen`."""

    keys: Any
    spots: Any
    hidden: Any
    wanted: Any
    begin: int
    end: int


@njit
def find_pixels(screen, width, found):  # type: ignore[no-untyped-def]
    """Only compiled functions can call it."""
    return of_squares(screen, np.int64(0), places(screen, width), width, found)


@pytest.mark.parametrize("wanted", [0, 2, None])
@pytest.mark.parametrize(("width", "begin", "end"), [(24, 0, 16), (29, 3, 18), (5, 0, 3)])
def test_pixels_found_are_those_to_be_shaded(wanted: int | None, width: int, begin: int, end: int) -> None:
    rng = np.random.default_rng(width)
    count = 20 * width
    solid = rng.random(count) < 0.5
    keys = np.where(solid, np.uint64(FIRST) + np.uint64(1), np.uint64(EMPTY))
    hidden = rng.choice(np.array([0, 1, 2], np.uint8), count, p=[0.1, 0.8, 0.1])
    hidden[~solid & (hidden == 2)] = 1  # what is marked shows a solid
    hidden[: 8 * width].reshape(8, width)[:, :8] = 1  # a square without any
    shown = solid & (hidden == wanted) if wanted is not None else solid
    hidden = hidden if wanted is not None else hidden[:0]
    screen = Screen(keys, np.zeros((0, 2), np.float32), hidden, np.uint8(wanted or 0), begin, end)
    found = np.full(32 * 64, -1)
    n = find_pixels(screen, width, found)
    expected = np.flatnonzero(shown)
    expected = expected[(expected >= begin * width) & (expected < end * width)]
    np.testing.assert_array_equal(np.sort(found[:n]), expected)
    row, column = found[:n] // width - begin, found[:n] % width
    squares = row // 8 * width + column // 8
    assert (np.diff(squares) >= 0).all()
