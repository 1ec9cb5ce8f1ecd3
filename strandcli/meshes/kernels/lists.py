"""Rows of a PLY file that hold lists, whose lengths differ."""

from __future__ import annotations

from ...jit import device, function

SIZE, LENGTH_SIZE, LENGTH_SIGNED = range(3)
"""Columns of a layout: bytes of an item, bytes of a list's length, 0 where it is no list, and whether it is signed."""


@device
def whole_number(data, at, size, signed, big):
    """The whole number of so many bytes at a place."""
    found = 0
    for k in range(size):
        found = found * 256 + data[at + k if big else at + size - 1 - k]
    if signed and found >= 1 << (8 * size - 1):
        found -= 1 << (8 * size)
    return found


@function
def walk(data, layout, big, begins, lengths):
    """Where each property of each row begins, and how many items it has: the bytes of all rows, or a row's number less
    than none, -1 - row, of the first row that does not fit.

    data: (n,) uint8; layout: (k, 3) int64, a row a property; begins, lengths: (rows, k) int64, written.
    """
    at = 0
    for row in range(begins.shape[0]):
        for k in range(layout.shape[0]):
            count = 1
            if layout[k, LENGTH_SIZE] > 0:
                if at + layout[k, LENGTH_SIZE] > data.shape[0]:
                    return -1 - row
                count = whole_number(data, at, layout[k, LENGTH_SIZE], layout[k, LENGTH_SIGNED] > 0, big)
                at += layout[k, LENGTH_SIZE]
            if count < 0 or count * layout[k, SIZE] > data.shape[0] - at:
                return -1 - row
            begins[row, k] = at
            lengths[row, k] = count
            at += count * layout[k, SIZE]
    return at


@function
def walk_text(numbers, layout, begins, lengths):
    """The same of numbers of a text, (n,) float64; places are counted in numbers."""
    at = 0
    for row in range(begins.shape[0]):
        for k in range(layout.shape[0]):
            count = 1
            if layout[k, LENGTH_SIZE] > 0:
                if at >= numbers.shape[0] or not 0.0 <= numbers[at] <= numbers.shape[0]:
                    return -1 - row
                count = int(numbers[at])
                at += 1
            if count > numbers.shape[0] - at:
                return -1 - row
            begins[row, k] = at
            lengths[row, k] = count
            at += count
    return at


@function
def gather(data, begins, lengths, step, out):
    """Write the items of runs one after the other.

    data: (n,), bytes or numbers; begins, lengths: (rows,) int64, where runs begin, in entries of `data`, and how many
    items they have, of ``step`` entries each; out: (entries of all runs,).
    """
    at = 0
    for row in range(begins.shape[0]):
        for k in range(begins[row], begins[row] + lengths[row] * step):
            out[at] = data[k]
            at += 1
