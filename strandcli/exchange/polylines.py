"""Strands of lines that name rows of a table of points, as formats of meshes have them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from .strands import Offsets

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
    """Offsets (S + 1,) of strands, the row of each of their points, and the number of each one's object. A line that
    begins at the row where the one before it ends goes on with it: many programs write a line a segment."""
    lengths, objects = lines.lengths[lines.lengths > 0].astype(np.int64), lines.objects[lines.lengths > 0]
    if not lengths.size:
        return np.zeros(1, np.int64), lines.rows[:0], objects
    ends = np.cumsum(lengths)
    begins = ends - lengths
    goes_on = np.zeros(lengths.size, np.bool_)
    goes_on[1:] = (lines.rows[begins[1:]] == lines.rows[ends[:-1] - 1]) & (lengths[1:] > 1) & (lengths[:-1] > 1)
    goes_on[1:] &= objects[1:] == objects[:-1]
    keep = np.ones(lines.rows.size, np.bool_)
    keep[begins[goes_on]] = False
    counts = np.add.reduceat(lengths - goes_on, np.flatnonzero(~goes_on))
    return np.concatenate([[0], np.cumsum(counts)]), lines.rows[keep], objects[~goes_on]
