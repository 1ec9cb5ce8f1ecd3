"""Light on solids at every second pixel of every second row, and which pixels between may have it from there.

Shadows of solids and of strands on solids vary less from pixel to pixel than normals and patches do, and take most of
the time. A pixel takes the mean of the lattice pixels about it, two or four, where all show its solid and agree.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ....jit import device, parallel, prange
from ...common.kernels.keys import EMPTY, FIRST, LOW
from ...solids.kernels import appearance, blended
from ...solids.kernels.surface_pixels import folded

ZERO, UNKNOWN = np.float32(0.0), np.float32(-1.0)
"""`UNKNOWN`: of a pixel of the lattice, where light is not one number."""
ONE = np.int64(1)
EVEN = np.uint64(0)
ALIKE = np.float32(1.0 / 10.0)
"""Share of a light by which pixels that agree may differ."""
DRAWN, HIDDEN, BETWEEN = np.uint8(0), np.uint8(1), np.uint8(2)
"""What becomes of a pixel: light is computed there; it is left as it is; it has the light of the lattice."""
ASKED = np.uint8(1)
"""Of a pixel of the lattice: its light is needed."""


class Frame(NamedTuple):
    """Rows of a picture, and where its lattice lies."""

    top: int
    bottom: int
    """The rows top <= y < bottom."""
    width: int
    """Of the picture, samples."""
    down: int
    right: int
    """1 where the first row and the first column are no part of the lattice, else 0."""


@parallel
def ask(keys, hidden, frame, asked):
    """Set asked (P,) to `ASKED` at the pixels of the lattice that the frame's rows need, to 0 at other pixels of these
    rows and of those beside them. keys (P,): z-buffer; hidden (P,): `HIDDEN` where nothing is drawn; frame: `Frame`."""
    top, bottom, width = np.int64(frame.top), np.int64(frame.bottom), np.int64(frame.width)
    height = np.int64(keys.shape[0]) // width
    first, last = max(top - 1, 0), min(bottom + 1, height)
    for row in prange(last - first):
        y = first + np.int64(row)
        asked[y * width : (y + 1) * width] = 0
        if (y + frame.down) & ONE != 0:
            continue
        for x in range(frame.right, width, 2):
            at = y * width + x
            if keys[at] != EMPTY and (keys[at] & LOW) >= FIRST:
                asked[at] = np.uint8(any_drawn(keys, hidden, at, x, y, frame))


@device
def any_drawn(keys, hidden, at, x, y, frame):
    """Return whether a pixel, or one of the eight about it, in the frame's rows is drawn and shows the same solid."""
    top, bottom, width = np.int64(frame.top), np.int64(frame.bottom), np.int64(frame.width)
    for below in range(max(y - 1, top), min(y + 2, bottom)):
        for beside in range(max(x - 1, 0), min(x + 2, width)):
            other = below * width + beside
            if hidden[other] == DRAWN and ((keys[other] ^ keys[at]) & LOW) == EVEN:
                return True
    return False


@parallel
def choose(keys, camera, solids, asked, values, frame, hidden):
    """Set hidden (P,) to `BETWEEN` at the pixels that are drawn in the frame's rows and may have the light of the
    lattice, values: `inputs.Lights.known`; other arguments as in `ask`; camera: packed view; solids: `Solids`."""
    top, bottom, width = np.int64(frame.top), np.int64(frame.bottom), np.int64(frame.width)
    height = np.int64(keys.shape[0]) // width
    for row in prange(bottom - top):
        y = top + np.int64(row)
        down = (y + frame.down) & ONE
        if y < down or y + down >= height:
            continue
        for x in range(1, width - 1):
            at = y * width + x
            key = keys[at]
            if hidden[at] != DRAWN or key == EMPTY or (key & LOW) < FIRST:
                continue
            right = (x + frame.right) & ONE
            step = down * width
            if not (
                there(keys, asked, key, at - step - right) and there(keys, asked, key, at - step + right)
                and there(keys, asked, key, at + step - right) and there(keys, asked, key, at + step + right)
            ):  # fmt: skip
                continue
            own = np.int64((key & LOW) - FIRST)
            parts = blended.blends(solids, own) or appearance.folds(solids, own)
            if parts and folded(keys, at, x, width, camera):
                continue
            if alike(values, (y - down + frame.down) >> 1, (x - right + frame.right) >> 1, down, right):
                hidden[at] = BETWEEN


@device
def there(keys, asked, key, at):
    """Return whether the light of a pixel of the lattice is known, and it shows the same solid."""
    return asked[at] == ASKED and ((keys[at] ^ key) & LOW) == EVEN


@device
def alike(values, j, i, down, right):
    """Return whether the light of the lattice differs by no more than `ALIKE` between places (j, i) and
    (j + down, i + right)."""
    for light in range(values.shape[2]):
        for c in range(3):
            a, b = values[j, i, light, c], values[j, i + right, light, c]
            d, e = values[j + down, i, light, c], values[j + down, i + right, light, c]
            least = min(min(a, b), min(d, e))
            if least < ZERO or max(max(a, b), max(d, e)) > least + ALIKE:
                return False
    return True
