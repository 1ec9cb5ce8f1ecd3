"""Light on solids at every second pixel of every second row, and which pixels between may have it from there.

Shadows of solids and of strands on solids vary less from pixel to pixel than normals and patches do, and take most of
the time. A pixel takes the mean of the lattice pixels about it, two or four, where all show its solid and agree. So
does a pixel of the lattice itself of those at every fourth pixel of every fourth row, where they agree more closely.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ....jit import device, inlined, parallel, prange
from ....simd import any_lane, lane_count, load, pointer, where
from ...common.kernels.keys import EMPTY, FIRST, LOW
from ...common.kernels.numbers import HALF, STEPS
from ...solids.kernels.appearance import folds
from ...solids.kernels.surface_pixels import FOLD, bend, depth_at, folded, pixel_width

ZERO, UNKNOWN = np.float32(0.0), np.float32(-1.0)
"""`UNKNOWN`: of a pixel of the lattice, where light is not one number."""
ONE, TWO, THREE = np.int64(1), np.int64(2), np.int64(3)
FAR = THREE
"""Columns or rows from a pixel that is drawn within which the light of pixels four apart is needed."""
EVEN = np.uint64(0)
ALIKE = np.float32(1.0 / 10.0)
"""Share of a light by which pixels that agree may differ."""
FAINT = np.float32(0.1)
"""Of the radiance under a coat: the coat's is small beside it."""
LIT, COATED = (np.uint64(part) for part in range(2))
"""What the lattice knows behind the shares of lights: radiance of a white surface under its coat, and of the coat."""
ALL = np.int64(2)
"""Their number."""
CLOSELY = np.float32(1.0 / 32.0)
"""The same for pixels four apart, between which light may be missed."""
DRAWN, HIDDEN, BETWEEN, SMOOTH = np.uint8(0), np.uint8(1), np.uint8(2), np.uint8(4)
"""What becomes of a pixel: light is computed there; it is left as it is; it has the lattice's shares of each light; it
has the lattice's light, and only its own colour."""
COARSE, FINE, SPREAD = np.uint8(1), np.uint8(2), np.uint8(3)
"""Of pixels of the lattice whose light is needed: of those four apart; of the others; of others that have taken it from
those four apart."""


class Frame(NamedTuple):
    """Rows of a picture, and where its lattice lies."""

    top: int
    bottom: int
    """The rows top <= y < bottom."""
    width: int
    """Of the picture, samples."""
    down: int
    right: int
    """Of the first row and the first column: 0 to 3 after those of pixels four apart."""


@parallel
def ask(keys, hidden, frame, asked):
    """Set asked (P,) to `COARSE` or `FINE` at the pixels of the lattice that the frame's rows need, to 0 at other
    pixels of these rows and of the three on each side. keys (P,): z-buffer; hidden (P,): `HIDDEN` where nothing is
    drawn; frame: `Frame`."""
    top, bottom, width = np.int64(frame.top), np.int64(frame.bottom), np.int64(frame.width)
    height = np.int64(keys.shape[0]) // width
    first, last = max(top - FAR, 0), min(bottom + FAR, height)
    for row in prange(last - first):
        y = first + np.int64(row)
        asked[y * width : (y + 1) * width] = 0
        if (y + frame.down) & ONE != 0:
            continue
        for x in range(frame.right & ONE, width, 2):
            at = y * width + x
            if keys[at] != EMPTY and (keys[at] & LOW) >= FIRST:
                coarse = ((x + frame.right) | (y + frame.down)) & THREE == 0
                if any_drawn(keys, hidden, at, x, y, frame, FAR if coarse else ONE):
                    asked[at] = COARSE if coarse else FINE


@device
def any_drawn(keys, hidden, at, x, y, frame, reach):
    """Return whether a pixel in the frame's rows, no more than so many columns and rows away, is drawn and shows the
    same solid."""
    top, bottom, width = np.int64(frame.top), np.int64(frame.bottom), np.int64(frame.width)
    for below in range(max(y - reach, top), min(y + reach + 1, bottom)):
        for beside in range(max(x - reach, 0), min(x + reach + 1, width)):
            other = below * width + beside
            if hidden[other] == DRAWN and ((keys[other] ^ keys[at]) & LOW) == EVEN:
                return True
    return False


@parallel
def spread(keys, camera, frame, asked, values):
    """Give pixels of the lattice the mean of those four apart, where these agree closely and no edge of the solid is
    between them: set asked to `SPREAD`. Arguments as in `choose`."""
    top, bottom, width = np.int64(frame.top), np.int64(frame.bottom), np.int64(frame.width)
    height = np.int64(keys.shape[0]) // width
    first, last = max(top - 1, 0), min(bottom + 1, height)
    for row in prange(last - first):
        y = first + np.int64(row)
        down = (y + frame.down) & TWO
        if (y + frame.down) & ONE != 0 or y < down or y + down >= height:
            continue
        for x in range(2 + (frame.right & ONE), width - 2, 2):
            at = y * width + x
            right = (x + frame.right) & TWO
            if asked[at] != FINE or not between(keys, asked, at, down * width, right):
                continue
            j, i = (y + frame.down) >> 1, (x + frame.right) >> 1
            b, a = down >> 1, right >> 1
            if alike(values, j - b, i - a, down, right, CLOSELY) and smooth(keys, camera, at, down * width, right):
                for light in range(values.shape[2]):
                    for c in range(3):
                        above = HALF * (values[j - b, i - a, light, c] + values[j - b, i + a, light, c])
                        below = HALF * (values[j + b, i - a, light, c] + values[j + b, i + a, light, c])
                        values[j, i, light, c] = HALF * (above + below)
                if not even(values, j - b, i - a, down, right):
                    values[j, i, np.uint64(values.shape[2] - ALL) + LIT, 0] = UNKNOWN
                asked[at] = SPREAD


@inlined
def between(keys, asked, at, step, right):
    """Return whether a pixel is between some whose light is known, that are so many columns to the right and left and
    so many pixels up and down, and that show its solid."""
    key = keys[at]
    return (
        there(keys, asked, key, at - step - right) and there(keys, asked, key, at - step + right)
        and there(keys, asked, key, at + step - right) and there(keys, asked, key, at + step + right)
    )  # fmt: skip


@device
def smooth(keys, camera, at, step, right):
    """Return whether a surface has no edge in front of itself at pixel number `at`, nor between the pixels that
    `between` looks at."""
    here = depth_at(keys, at, camera)
    most = max(bend(keys, at, step + right, here, camera), bend(keys, at, abs(step - right), here, camera))
    return most <= FOLD * pixel_width(here, camera)


@parallel
def smooth_blocks(keys, solids, asked, values, frame, hidden):
    """Set hidden to `SMOOTH` as `choose` does, at four pixels at once, where the lattice pixels about them agree about
    all of them; arguments as there. values: room for a vector behind the last pixel that is known."""
    top, bottom, width = np.int64(frame.top), np.int64(frame.bottom), np.int64(frame.width)
    height = np.int64(keys.shape[0]) // width
    down, right = np.int64(frame.down) & ONE, np.int64(frame.right) & ONE
    known = pointer(values)
    along = np.int64(values.shape[2] * 3)
    below = np.int64(values.shape[1]) * along
    if along > lane_count(known):
        return
    for pair in prange((bottom - top) // 2 + 2):
        y = top - TWO + ((top + down) & ONE) + TWO * np.int64(pair)
        if y < 0 or y + TWO >= height:
            continue
        solid, parts = np.int64(-1), False
        lanes = load(pointer(STEPS), 0)
        for x in range(TWO - right, width - TWO, 2):
            at = y * width + x
            key = keys[np.uint64(at)]
            if key == EMPTY or (key & LOW) < FIRST:
                continue
            own = np.int64((key & LOW) - FIRST)
            if own != solid:
                solid, parts = own, folds(solids, own)
            if parts or not one_solid(keys, asked, key, at, TWO * width):
                continue
            o = ((y + frame.down) >> 1) * below + ((x + frame.right) >> 1) * along
            if agree(known, o, along, below, lanes):
                for row in range(max(y, top), min(y + TWO, bottom)):
                    set_smooth(keys, hidden, row * width + x, key)


@inlined
def one_solid(keys, asked, key, at, below):
    """Return whether the light of four pixels of the lattice is known, of which number `at` is the upper left, and all
    of them show the solid of a key; below: from a row of them to the next."""
    return (
        there(keys, asked, key, at) and there(keys, asked, key, at + TWO)
        and there(keys, asked, key, at + below) and there(keys, asked, key, at + below + TWO)
    )  # fmt: skip


@inlined
def set_smooth(keys, hidden, at, key):
    """Set two neighbouring pixels to `SMOOTH` that are drawn and show the solid of a key."""
    for place in range(np.uint64(at), np.uint64(at + TWO)):
        same = (hidden[place] == DRAWN) & (((keys[place] ^ key) & LOW) == EVEN)
        hidden[place] = SMOOTH if same else hidden[place]


@inlined
def agree(known, o, along, below, lanes):
    """Return whether light is `alike` and `even` between any two of four places of the lattice, by bounds of each
    channel alone. known: `pointer` to the lattice; o: index of the upper left place; along, below: numbers from a place
    to the next and to that below; lanes: 0, 1, …"""
    a, b = load(known, o), load(known, o + along)
    d, e = load(known, o + below), load(known, o + below + along)
    low, high = min(min(a, b), min(d, e)), max(max(a, b), max(d, e))
    coat, lit = np.float32(along - 3), np.float32(along - 6)
    place = o + along - 6
    faint = min(min(known[place], known[place + along]), min(known[place + below], known[place + below + along]))
    most = where(lanes < lit, ALIKE, ALIKE * where(lanes < coat, low, max(low, FAINT * faint)))
    off = (low < ZERO) | ~(high <= low + most)
    return not any_lane(off & (lanes < np.float32(along)))


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
        solid, parts = np.int64(-1), False
        for x in range(1, width - 1):
            at = y * width + x
            if hidden[np.uint64(at)] != DRAWN:
                continue
            key = keys[np.uint64(at)]
            if key == EMPTY or (key & LOW) < FIRST:
                continue
            right = (x + frame.right) & ONE
            step = down * width
            if not between(keys, asked, at, step, right):
                continue
            own = np.int64((key & LOW) - FIRST)
            if own != solid:
                solid, parts = own, folds(solids, own)
            if parts and folded(keys, at, x, width, camera):
                continue
            j, i = (y - down + frame.down) >> 1, (x - right + frame.right) >> 1
            if alike(values, j, i, down, right, ALIKE):
                hidden[at] = SMOOTH if even(values, j, i, down, right) else BETWEEN


@inlined
def there(keys, asked, key, at):
    """Return whether the light of a pixel of the lattice is known, and it shows the same solid."""
    place = np.uint64(at)
    return asked[place] != 0 and ((keys[place] ^ key) & LOW) == EVEN


@inlined
def alike(values, j, i, down, right, most):
    """Return whether the light of the lattice differs by no more than `most` between places (j, i) and
    (j + down, i + right)."""
    above, below, here, beside = np.uint64(j), np.uint64(j + down), np.uint64(i), np.uint64(i + right)
    for light in range(np.uint64(values.shape[2] - ALL)):
        for c in range(np.uint64(3)):
            a, b = values[above, here, light, c], values[above, beside, light, c]
            d, e = values[below, here, light, c], values[below, beside, light, c]
            least = min(min(a, b), min(d, e))
            if least < ZERO or max(max(a, b), max(d, e)) > least + most:
                return False
    return True


@inlined
def even(values, j, i, down, right):
    """Return whether radiance is known at places (j, i) to (j + down, i + right) of the lattice and differs by no more
    than `ALIKE` of the greatest; that of coats by no more than so much of the greatest of theirs, or of `FAINT`."""
    about = np.uint64(j), np.uint64(j + down), np.uint64(i), np.uint64(i + right)
    above, below, here, beside = about
    first = np.uint64(values.shape[2] - ALL)
    low, high = min(values[above, here, first, 0], values[above, beside, first, 0]), values[below, here, first, 0]
    if min(min(low, high), values[below, beside, first, 0]) < ZERO:
        return False
    lit, lit_apart = most_about(values, about, first + LIT)
    coated, coated_apart = most_about(values, about, first + COATED)
    return lit_apart <= ALIKE * lit and coated_apart <= ALIKE * max(coated, FAINT * lit)


@inlined
def most_about(values, about, part):
    """Return the greatest of three channels over four places, and by how much one of them differs at the most."""
    above, below, here, beside = about
    most = apart = ZERO
    for c in range(np.uint64(3)):
        a, b = values[above, here, part, c], values[above, beside, part, c]
        d, e = values[below, here, part, c], values[below, beside, part, c]
        high = max(max(a, b), max(d, e))
        most = max(most, high)
        apart = max(apart, high - min(min(a, b), min(d, e)))
    return most, apart
