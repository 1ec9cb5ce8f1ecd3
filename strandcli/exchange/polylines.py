"""Strands of lines that name rows of a table of points, as formats of meshes have them."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from .bounded import Growing
from .strands import CHUNK, Offsets

OF_POINT = 16
"""Bytes that a point of a strand and its row take; lines may name one point often."""
IS_MESH = (
    "is a mesh, neither a preset nor strands: it has no lines; 'strandcli info' draws it with --picture, "
    "emitter.shape of a preset has strands grow on it, and solids have it drawn"
)


class Lines(NamedTuple):
    """Lines of a file."""

    lengths: npt.NDArray[np.int32]
    """(L,) rows that each names."""
    rows: npt.NDArray[np.int32]
    """(I,) of the table, one line after the other."""
    objects: npt.NDArray[np.int32]
    """(L,) number of the object that each is of."""


def joined_lines(lines: Lines) -> tuple[Offsets, npt.NDArray[np.int32], npt.NDArray[np.int32]]:
    """Offsets (S + 1,) of strands, the row of each of their points, and the number of each one's object; the rows of
    the lines are of no use afterwards. A line that begins at the row where the one before it ends goes on with it: many
    programs write a line a segment."""
    first, objects = Growing(np.int64), Growing(np.int32)
    begin = done = 0
    last = np.array([0, -1, -1])
    """Of the line before: its rows, the last of them, and its object."""
    for at in range(0, lines.lengths.size, CHUNK):
        lengths, of = lines.lengths[at : at + CHUNK].astype(np.int64), lines.objects[at : at + CHUNK]
        lengths, of = lengths[lengths > 0], of[lengths > 0]
        if not lengths.size:
            continue
        ends = np.cumsum(lengths)
        rows, begin = lines.rows[begin : begin + int(ends[-1])], begin + int(ends[-1])
        lines_of = np.stack([lengths, rows[ends - 1], of], axis=1)
        before = np.concatenate([last[None], lines_of[:-1]])
        goes_on = (rows[ends - lengths] == before[:, 1]) & (lengths > 1) & (before[:, 0] > 1) & (of == before[:, 2])
        last = lines_of[-1]
        keep = np.ones(rows.size, np.bool_)
        keep[(ends - lengths)[goes_on]] = False
        first.add((done + ends - lengths - np.cumsum(goes_on))[~goes_on])
        objects.add(of[~goes_on])
        kept = rows[keep]
        lines.rows[done : done + kept.size] = kept
        done += kept.size
    first.add([done])
    return first.taken(), lines.rows[:done], objects.taken()


def at_rows(table: npt.NDArray[Any], rows: npt.NDArray[np.int32]) -> npt.NDArray[Any]:
    """The rows of a table (V, k) that strands name one after the other (P,); the table itself where they name it so."""
    steps = range(0, rows.size, CHUNK)
    if all((rows[at : at + CHUNK] == np.arange(at, min(at + CHUNK, rows.size))).all() for at in steps):
        return table[: rows.size]
    return table[rows]
