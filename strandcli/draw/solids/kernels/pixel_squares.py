"""Pixels that show solids and are to be shaded, square by square."""

from __future__ import annotations

import numpy as np

from ....jit import device, inlined
from ...common.kernels.keys import EMPTY, FIRST, LOW

SHADED = np.uint8(0)
"""In `Screen.hidden`: of pixels that are not left as they are."""
SIDE_BITS = np.int64(3)
SIDE = np.int64(8)
"""Side of a square of pixels that are shaded one after the other."""
WITHIN = np.arange(SIDE * SIDE)
DOWN = (WITHIN >> 1 & 1) + (WITHIN >> 2 & 2) + (WITHIN >> 3 & 4)
ACROSS = (WITHIN & 1) + (WITHIN >> 1 & 2) + (WITHIN >> 2 & 4)
"""Rows down and columns across from the first pixel of a square, in an order in which sixteen pixels one after the
other are a square of 4 × 4: they read the same texels."""


@device
def find_pixels(screen, p, end, width, found):
    """Write to found (places,) int64 the pixels to shade among the places p … end − 1, in their order: square by
    square (`DOWN`, `ACROSS`), or in their own where they have positions of their own. Return how many they are. Squares
    without any are passed over by loops without branches."""
    n = np.int64(0)
    for begin in range(p, end, SIDE * SIDE):
        if screen.spots.shape[0] > 0:
            for place in range(begin, min(begin + SIDE * SIDE, end)):
                at = screen.begin * width + place
                found[n] = at
                n += np.int64(is_wanted(screen, at))
            continue
        column, row = square_at(begin, screen, width)
        wide, tall = min(SIDE, np.int64(width) - column), min(SIDE, np.int64(screen.end) - row)
        first = row * width + column
        some = False
        for y in range(tall):
            for x in range(wide):
                some |= is_wanted(screen, first + y * width + x)
        for place in range(np.uint64(SIDE * SIDE if some else 0)):
            down, across = DOWN[place], ACROSS[place]
            inside = (across < wide) & (down < tall)
            at = first + (down * width + across if inside else np.int64(0))
            found[np.uint64(n)] = at
            n += np.int64(inside & is_wanted(screen, at))
    return n


@inlined
def is_wanted(screen, at):
    """Return whether pixel number `at` shows a solid and is to be shaded. Without branches."""
    key = screen.keys[np.uint64(at)]
    shown = (key != EMPTY) & ((key & LOW) >= FIRST)
    if screen.hidden.shape[0] > 0:
        shown &= screen.hidden[np.uint64(at)] == SHADED
    return shown


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
