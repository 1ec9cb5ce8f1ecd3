"""Which pixels solids may cover in part: those whose solid differs from a neighbour's, inside or beside the picture."""

from __future__ import annotations

import numpy as np

from ....constants import W
from ....jit import device, parallel, prange
from ...common.kernels.keys import EMPTY, FIRST, LOW
from ...common.kernels.numbers import HALF, ONE
from ...common.kernels.view_columns import AXIS_X, AXIS_Y, DEPTH_RANGE, FOCAL, PERSPECTIVE
from .edges import meet_one, within
from .rasterise import key_at
from .rays import BATCH, aim

EVEN = np.uint64(0)


@parallel
def look_outside(width, height, view, solids, frames, found):
    """Write the keys of the pixels beside the picture's border to found (2 (width + height),) uint64, in the order of
    `outside`. Arguments as in `sample`."""
    flat = ONE - view[PERSPECTIVE]
    far = ONE / view[DEPTH_RANGE]
    for task in prange((found.shape[0] + W - 1) // W):
        begin = np.int64(task) * W
        count = min(W, found.shape[0] - begin)
        work = np.zeros(BATCH, np.float32)
        for j in range(count):
            x, y = outside(begin + j, width, height)
            aim(
                work, j, view, (np.float32(x) + HALF - view[AXIS_X]) / view[FOCAL],
                (view[AXIS_Y] - np.float32(y) - HALF) / view[FOCAL],
            )  # fmt: skip
            found[begin + j] = EMPTY
        for m in range(frames.shape[0]):
            for j in range(count):
                x, y = outside(begin + j, width, height)
                if within(x, y, frames, m):
                    key = key_at(meet_one(work, j, solids, m), view, flat, far, FIRST + np.uint64(m))
                    found[begin + j] = min(found[begin + j], key)


@device
def outside(number, width, height):
    """Return column and row of a pixel beside the border: those above the picture, below it, left and right of it."""
    if number < 2 * width:
        return number % width, np.int64(-1) if number < width else np.int64(height)
    number -= 2 * width
    return np.int64(-1) if number < height else np.int64(width), number % height


@parallel
def find(keys, beside, width, height, ends):
    """Mark the pixels that may contain an edge: those whose solid differs from that of one of the four neighbours.

    beside: from `look_outside`; ends (height * width,) uint8 out: 1 for marked pixels, else 0.
    """
    for row in prange(height):
        y = np.int64(row)  # the index is unsigned, for which `compare` would be compiled a second time
        compare(keys, y * width, max(y - 1, 0) * width, min(y + 1, height - 1) * width, width, ends)
        if y in (0, height - 1):
            for x in range(width):
                ends[y * width + x] = differs(keys, beside, x, y, width, height)
        ends[y * width] = differs(keys, beside, np.int64(0), y, width, height)
        ends[(y + 1) * width - 1] = differs(keys, beside, np.int64(width - 1), y, width, height)


@device
def differs(keys, beside, x, y, width, height):
    """Return 1 if the solid of a pixel at the picture's border differs from that of one of the four neighbours, else
    0."""
    at = y * width + x
    above = keys[at - width] if y > 0 else beside[x]
    below = keys[at + width] if y < height - 1 else beside[width + x]
    left = keys[at - 1] if x > 0 else beside[2 * width + y]
    right = keys[at + 1] if x < width - 1 else beside[2 * width + height + y]
    other = (above ^ keys[at]) | (below ^ keys[at]) | (left ^ keys[at]) | (right ^ keys[at])
    return np.uint8((other & LOW) != EVEN)


@device
def compare(keys, own, above, below, width, ends):
    """Mark the pixels of one row, except its first and last; own, above, below: first pixel of this and the adjacent
    rows. The loop is vectorised."""
    for x in range(np.uint64(1), np.uint64(width - 1)):
        at = np.uint64(own) + x
        key = keys[at]
        other = (keys[at - np.uint64(1)] ^ key) | (keys[at + np.uint64(1)] ^ key)
        other |= (keys[np.uint64(above) + x] ^ key) | (keys[np.uint64(below) + x] ^ key)
        ends[at] = np.uint8((other & LOW) != EVEN)
