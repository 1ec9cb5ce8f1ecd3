"""Which triangles of a mesh meet at edges, which way round they have to be, and whether they close it."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from .kernels.winding import orient
from .mesh import Indices, Vectors, face_vectors, slices

Flags = npt.NDArray[np.bool_]
ALONE, CROWDED = -1, -2
"""In place of a neighbour, of an edge of one triangle alone, and of one of three or more."""
FLAT = 0.01
"""A part whose volume is less than this times the power 3/2 of its area is a sheet, without an outside; of a sphere it
is .094."""


def oriented(vertices: Vectors, triangles: Indices) -> tuple[Flags, dict[str, int], bool]:
    """Which triangles (T,) have to be turned so that neighbours agree and parts are wound outward; facts about edges;
    and whether the mesh is closed then."""
    half = half_edges(triangles, vertices.shape[0])
    neighbours, opposed, crowded = across_edges(half)
    alone = np.flatnonzero(neighbours.reshape(-1) == ALONE)
    boundary, holes = alone.size, 0
    if boundary:
        holes = rings(half.starts[alone], half.ends[alone])
    count = triangles.shape[0]
    part = np.full(count, -1, np.int32)
    turned = np.zeros(count, np.bool_)
    parts = orient(neighbours, opposed, part, turned, np.empty(count, np.int32))
    twisted = 0
    for rows in slices(count):
        agree = (neighbours[rows] < 0) | (turned[rows, None] ^ turned[neighbours[rows]] == opposed[rows])
        twisted += agree.size - int(np.count_nonzero(agree))
    del neighbours, opposed
    turned ^= _inward(vertices, triangles, part, turned, parts)[part]
    facts = {
        "boundary": boundary, "holes": holes, "crowded": crowded, "twisted": twisted // 2, "parts": parts,
    }  # fmt: skip
    return turned, facts, not boundary and balanced(half, turned)


def _inward(vertices: Vectors, triangles: Indices, part: Indices, turned: Flags, parts: int) -> Flags:
    """Which parts (parts,) have to be turned as a whole: those that are wound inward, and sheets that are wound against
    most of their triangles."""

    def sums(values: Any) -> npt.NDArray[np.float64]:
        """Sums (parts,) over triangles of what a function returns for rows of them."""
        found = np.zeros(parts)
        for rows in slices(part.size):
            np.add.at(found, part[rows], values(rows))
        return found

    def vectors(rows: slice) -> Vectors:
        return 0.5 * face_vectors(vertices[triangles[rows]]) * np.where(turned[rows], -1.0, 1.0)[:, None]

    def area(rows: slice) -> Vectors:
        found: Vectors = np.linalg.norm(vectors(rows), axis=1)
        return found

    def centres(rows: slice) -> Vectors:
        found: Vectors = vertices[triangles[rows]].mean(axis=1)
        return found

    whole = sums(area)
    middle = np.empty((parts, 3))
    for k in range(3):
        middle[:, k] = sums(lambda rows, k=k: area(rows) * centres(rows)[:, k]) / whole
    volume = sums(lambda rows: np.einsum("ij,ij->i", centres(rows) - middle[part[rows]], vectors(rows))) / 3.0
    against = sums(lambda rows: np.where(turned[rows], 1.0, -1.0)) > 0
    found: Flags = np.where(np.abs(volume) > FLAT * whole**1.5, volume < 0, against)
    return found


class HalfEdges(NamedTuple):
    """The half edges (3 T,) of triangles: half edge 3 t + k goes from corner k of triangle t to the next one."""

    starts: Indices
    ends: Indices
    order: Indices
    """(3 T,) in which those of an edge are neighbours, as they are."""
    begins: npt.NDArray[np.int64]
    """(E,) where each edge begins in the order."""
    sizes: npt.NDArray[np.int64]
    """(E,) how many each has."""


def half_edges(triangles: Indices, vertices: int) -> HalfEdges:
    """The half edges of triangles of so many vertices."""
    starts, ends = triangles.reshape(-1), triangles[:, (1, 2, 0)].reshape(-1)
    keys = np.minimum(starts, ends).astype(np.int64)
    keys *= vertices
    keys += np.maximum(starts, ends)
    order = np.argsort(keys, kind="stable").astype(np.int32)
    keys = keys[order]
    begins = np.concatenate([[0], np.flatnonzero(keys[1:] != keys[:-1]) + 1])
    return HalfEdges(starts, ends, order, begins, np.diff(begins, append=keys.size))


def across_edges(half: HalfEdges) -> tuple[Indices, Flags, int]:
    """(T, 3) the triangle across each edge, `ALONE` or `CROWDED` where there is none or are several; whether it is
    wound the opposite way; and the number of edges of three triangles or more."""
    neighbours, opposed = np.full(half.order.size, ALONE, np.int32), np.zeros(half.order.size, np.bool_)
    pairs = half.begins[half.sizes == 2]
    one, other = half.order[pairs], half.order[pairs + 1]
    neighbours[one], neighbours[other] = other // 3, one // 3
    forward = half.starts < half.ends
    opposed[one] = opposed[other] = forward[one] == forward[other]
    many = half.sizes > 2
    neighbours[half.order[np.repeat(many, half.sizes)]] = CROWDED
    return neighbours.reshape(-1, 3), opposed.reshape(-1, 3), int(np.count_nonzero(many))


def rings(starts: Indices, ends: Indices) -> int:
    """The number of rings of edges (n,), which hang together by vertices."""
    vertices, rows = np.unique(np.concatenate([starts, ends]), return_inverse=True)
    one, other = rows.reshape(2, -1)
    label = np.arange(vertices.size)
    while (label[one] != label[other]).any():  # all take the lowest label beside them, and that one's own
        least = np.minimum(label[one], label[other])
        for side in (one, other):
            np.minimum.at(label, label[side], least)
        label = label[label]
    return int(np.count_nonzero(label == np.arange(label.size)))


def balanced(half: HalfEdges, turned: Flags) -> bool:
    """Whether every edge is gone along as often in one direction as in the other; ``turned``: (T,) triangles that are
    wound the opposite way to how they stand there."""
    forward = (half.starts < half.ends) != np.repeat(turned, 3)
    sums = np.add.reduceat(np.where(forward, np.int8(1), np.int8(-1))[half.order], half.begins, dtype=np.int32)
    return not sums.any()
