"""Which triangles of a mesh meet at edges, which way round they have to be, and whether they close it."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from .kernels.topology import ALONE, balanced, meet, order_edges, orient, rings
from .mesh import Indices, Vectors, face_vectors, slices

Flags = npt.NDArray[np.bool_]
FLAT = 0.01
"""A part whose volume is less than this times the power 3/2 of its area is a sheet, without an outside; of a sphere it
is .094."""


def oriented(vertices: Vectors, triangles: Indices) -> tuple[Flags, dict[str, int], bool]:
    """Which triangles (T,) have to be turned so that neighbours agree and parts are wound outward; facts about edges;
    and whether the mesh is closed then."""
    order = edges_in_order(triangles, vertices.shape[0])
    neighbours, opposed, crowded = across_edges(triangles, order)
    boundary = sum(int(np.count_nonzero(neighbours[rows] == ALONE)) for rows in slices(triangles.shape[0]))
    holes = 0
    if boundary:
        holes = int(rings(triangles, neighbours, np.empty(vertices.shape[0], np.int32)))
        order = order[:0].copy()  # which would only tell whether a mesh without a boundary is closed
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
    return turned, facts, not boundary and bool(balanced(triangles, order, turned))


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


def edges_in_order(triangles: Indices, vertices: int) -> Indices:
    """The half edges (3 T,) in the order of their edges: half edge 3 t + k goes from corner k of triangle t to the
    next one."""
    order, scratch = (np.empty(triangles.size, np.int32) for _ in range(2))
    order_edges(triangles, np.empty(vertices + 1, np.int32), scratch, order)
    return order


def across_edges(triangles: Indices, order: Indices) -> tuple[Indices, Flags, int]:
    """Neighbours (T, 3), as of `meet`, whether they are wound the other way, and the number of edges of three triangles
    or more."""
    neighbours, opposed = np.empty(triangles.shape, np.int32), np.empty(triangles.shape, np.bool_)
    return neighbours, opposed, int(meet(triangles, order, neighbours, opposed))
