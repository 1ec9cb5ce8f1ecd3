"""Search for nearest neighbours, in the cells of a grid over two of their coordinates."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...jit import device, parallel, prange


class Cells(NamedTuple):
    """Points by the cells of a grid over the coordinates a and b, in ascending order of their cells."""

    points: NDArray[np.float32]
    """(G, D)"""
    names: NDArray[np.int32]
    """(G,) numbers by which they are called."""
    begins: NDArray[np.int32]
    """(rows * columns + 1,) index of the first point of each cell, row by row; then G."""
    a: int
    b: int
    low_a: float
    low_b: float
    """Where the grid begins along each."""
    size: float
    """Of a cell, along both."""
    columns: int
    rows: int
    slack: float
    """Distance by which rounding may displace a point from its cell."""


@parallel
def nearest(points, cells, out, squares):
    """Write the nearest K of other points to each point to out (N, K) int32, nearest first, and their squared distances
    to squares (N, K) float32.

    points (N, D) float32; cells: `Cells` of the candidates, K at least.
    """
    for i in prange(points.shape[0]):
        search(points[i], cells, out[i], squares[i])


@device
def search(point, cells, names, squares):
    """`nearest` of one point: in the cells about it, ring by ring, until what lies beyond a ring is farther away than
    what has been found."""
    squares[:] = np.float32(np.inf)
    last = names.shape[0] - 1
    a, b = np.float64(point[cells.a]) - cells.low_a, np.float64(point[cells.b]) - cells.low_b
    column = np.int64(min(max(a / cells.size, 0.0), np.float64(cells.columns - 1)))  # at the border the one next to it
    row = np.int64(min(max(b / cells.size, 0.0), np.float64(cells.rows - 1)))
    ring = np.int64(0)
    while True:
        left, right = max(column - ring, 0), min(column + ring, cells.columns - 1)
        for y in range(max(row - ring, 0), min(row + ring, cells.rows - 1) + 1):
            first = y * cells.columns
            if abs(y - row) == ring:
                visit(point, cells, first + left, first + right + 1, names, squares)
            else:  # of the rows between the outermost, the cells at both ends
                if column - ring >= 0:
                    visit(point, cells, first + left, first + left + 1, names, squares)
                if column + ring < cells.columns:
                    visit(point, cells, first + right, first + right + 1, names, squares)
        across = beyond(a, column, ring, cells.size, cells.columns)
        away = min(across, beyond(b, row, ring, cells.size, cells.rows)) - cells.slack
        if (away > 0.0 and away * away >= squares[last]) or away == np.inf:
            return
        ring += 1


@device
def beyond(x, cell, ring, size, count):
    """Return the distance from x to the nearest cell, along one axis, that is more than `ring` cells from a cell;
    infinite where the grid has none."""
    low = x - size * np.float64(cell - ring) if cell - ring > 0 else np.inf
    high = size * np.float64(cell + ring + 1) - x if cell + ring < count - 1 else np.inf
    return min(low, high)


@device
def visit(point, cells, cell, stop, names, squares):
    """Put the points of the cells from `cell` to stop − 1 in their places among those found, where they are nearer than
    the last of them."""
    last = names.shape[0] - 1
    for at in range(cells.begins[cell], cells.begins[stop]):
        square = np.float32(0.0)
        for c in range(point.shape[0]):
            d = point[c] - cells.points[at, c]
            square += d * d
            if not square < squares[last]:
                break
        if not square < squares[last]:
            continue
        k = last
        while k > 0 and square < squares[k - 1]:
            squares[k] = squares[k - 1]
            names[k] = names[k - 1]
            k -= 1
        squares[k] = square
        names[k] = cells.names[at]
