"""Pixels that show solids and are to be shaded, square by square."""

from __future__ import annotations

import numpy as np

from ....jit import device, inlined
from ...common.kernels.keys import EMPTY, FIRST, LOW

SIDE_BITS = np.int64(3)
SIDE = np.int64(8)
"""Side of a square of pixels that are shaded one after the other."""


@device
def find_pixels(screen, p, end, width, found):
    """Write to found (places,) int64 the pixels to shade among the places p … end − 1, in their order: square by
    square (`within_square`), or in their own where they have positions of their own. Return how many they are. Squares
    without any are passed over by loops without branches."""
    n = np.int64(0)
    for begin in range(p, end, SIDE * SIDE):
        stop = min(begin + SIDE * SIDE, end)
        if screen.spots.shape[0] > 0:
            for place in range(begin, stop):
                at = screen.begin * width + place
                found[n] = at
                n += np.int64(is_wanted(screen, at))
        elif shows_solids(screen, begin, width):
            column, row = square_at(begin, screen, width)
            whole = column + SIDE <= width and row + SIDE <= screen.end
            for place in range(begin, stop):
                down, across = within_square(place)
                inside = whole or (column + across < width and row + down < screen.end)
                at = (row + down) * width + column + across if inside else np.int64(0)
                found[n] = at
                n += np.int64(inside & is_wanted(screen, at))
    return n


@inlined
def is_wanted(screen, at):
    """Return whether pixel number `at` shows a solid and is to be shaded. Without branches."""
    key = screen.keys[np.uint64(at)]
    shown = (key != EMPTY) & ((key & LOW) >= FIRST)
    if screen.hidden.shape[0] > 0:
        shown &= screen.hidden[np.uint64(at)] == screen.wanted
    return shown


@device
def shows_solids(screen, p, width):
    """Return whether a pixel of the square that begins at place p shows a solid and is to be shaded."""
    column, row = square_at(p, screen, width)
    any_shown = False
    for y in range(row, min(row + SIDE, np.int64(screen.end))):
        for at in range(y * width + column, y * width + min(column + SIDE, np.int64(width))):
            any_shown |= is_wanted(screen, at)
    return any_shown


@inlined
def places_in(screen, width):
    """Return the number of places of `find_pixels`."""
    rows, columns = np.int64(screen.end - screen.begin), np.int64(width)
    if screen.spots.shape[0] > 0:
        return rows * columns
    return ((rows + SIDE - 1) >> SIDE_BITS) * ((columns + SIDE - 1) >> SIDE_BITS) * SIDE * SIDE


@inlined
def square_at(place, screen, width):
    """Return column and row of the first pixel of the square that a place is in."""
    across = (np.int64(width) + SIDE - 1) >> SIDE_BITS
    square = place >> (2 * SIDE_BITS)
    down = square // across
    return (square - down * across) * SIDE, screen.begin + down * SIDE


@inlined
def within_square(place):
    """Return how many rows down and columns across a place is from the first pixel of its square, in an order in which
    sixteen pixels one after the other are a square of 4 × 4, and of every second pixel of every second row a square,
    too: they read the same texels."""
    within = place & (SIDE * SIDE - 1)
    across = (within & 1) + ((within >> 1) & 2) + ((within >> 2) & 4)
    return ((within >> 1) & 1) + ((within >> 2) & 2) + ((within >> 3) & 4), across
