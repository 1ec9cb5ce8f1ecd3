"""Triangles with what belongs to them, and the faults that were found in them; polygons to
triangles, and colours as files have them to linear ones."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from ..common import srgb

Vectors = npt.NDArray[np.float64]
Indices = npt.NDArray[np.int32]
SLICE = 1 << 14
"""Triangles."""


@dataclass(frozen=True, slots=True)
class MeshFacts:
    """What was found in a mesh; all are numbers of things.

    no_area: triangles without area, left out; repeated: triangles that repeat another, left out; unused: vertices
    of no triangle, left out; merged: vertices that were at the place of another one; boundary: edges of one triangle
    alone; holes: rings of them; crowded: edges of three triangles or more; turned: triangles that were wound against
    the rest; twisted: edges whose triangles cannot be made to agree; parts: pieces that hang together by edges.
    """

    no_area: int = 0
    repeated: int = 0
    unused: int = 0
    merged: int = 0
    boundary: int = 0
    holes: int = 0
    crowded: int = 0
    turned: int = 0
    twisted: int = 0
    parts: int = 0


@dataclass(frozen=True, slots=True, eq=False)
class FileNormals:
    """Normals that a file has: values (n, 3), rows (T, 3) of them at the corners of triangles, in the order that these
    had in the file, and which triangles (T,) were turned since."""

    values: npt.NDArray[Any]
    rows: Indices
    turned: npt.NDArray[np.bool_]

    def of_corners(self, mesh: TriangleMesh, some: slice) -> Vectors:
        """Normals (k, 3, 3) of the corners of some triangles of their mesh; smooth ones where the file has none. Those
        of triangles that were wound wrongly point inward, as far as they agree with that winding."""
        turned, mine = self.turned[some], self.rows[some].copy()
        mine[turned] = mine[turned][:, (0, 2, 1)]
        found, usual = self.values[mine], mesh.normals[mesh.triangles[some]]
        found = unit(np.where(np.isfinite(found).all(axis=2, keepdims=True), found, 0.0))
        inward = turned & (np.einsum("tkj,tkj->t", found, usual) < 0)
        found[inward] *= -1.0
        return np.asarray(np.where(found.any(axis=2, keepdims=True), found, usual))


@dataclass(frozen=True, slots=True, eq=False)
class TriangleMesh:
    """A mesh whose triangles are wound counter-clockwise, seen from outside, as far as it has an outside.

    vertices: (V, 3) float64, units of the file; triangles: (T, 3) int32, rows of vertices, at least one triangle;
    smooth: `normals` where they are known already; own: normals of the file, or `corner_normals` of them; uv:
    (T, 3, 2) float32, of each corner, the origin at the lower left of the texture; colours: (V, 3) float32, linear, 0
    to 1; attributes: named numbers of vertices, (V,) or (V, k) float32; texture: (h, w, 3) uint8, sRGB, first row at
    the top; closed: whether no edge is where the winding number changes, so that inside and outside differ
    without doubt; facts: what was found; notes: the same as sentences, and what was left out; merge: (file's
    vertices,) int32, of each of them its row in
    `vertices` or -1.
    """

    vertices: Vectors
    triangles: Indices
    smooth: Vectors | None = None
    own: Vectors | FileNormals | None = None
    uv: npt.NDArray[np.float32] | None = None
    colours: npt.NDArray[np.float32] | None = None
    attributes: Mapping[str, npt.NDArray[np.float32]] = field(default_factory=dict)
    texture: npt.NDArray[np.uint8] | None = None
    closed: bool = False
    facts: MeshFacts = field(default_factory=MeshFacts)
    notes: tuple[str, ...] = ()
    merge: Indices | None = None

    @property
    def normals(self) -> Vectors:
        """(V, 3) unit length, smooth, weighted by angle; made when they are first asked for."""
        if self.smooth is None:
            object.__setattr__(self, "smooth", smooth_normals(self.vertices, self.triangles))
        assert self.smooth is not None
        return self.smooth

    @property
    def corner_normals(self) -> Vectors | None:
        """(T, 3, 3) unit length, of each corner, where the file has normals of its own, which keep creases; made when
        they are first asked for."""
        if isinstance(self.own, FileNormals):
            whole = np.empty((*self.triangles.shape, 3))
            for rows in slices(len(whole)):
                whole[rows] = self.own.of_corners(self, rows)
            object.__setattr__(self, "own", whole)
        assert not isinstance(self.own, FileNormals)
        return self.own

    def box(self) -> tuple[Vectors, Vectors]:
        """Low and high corner (3,) of the vertices."""
        return self.vertices.min(axis=0), self.vertices.max(axis=0)

    def size(self) -> float:
        """Longest side of the box, units of the file."""
        low, high = self.box()
        return float((high - low).max())

    def areas(self) -> Vectors:
        """Area of each triangle (T,)."""
        found: Vectors = 0.5 * np.linalg.norm(face_vectors(self.vertices[self.triangles]), axis=1)
        return found

    def face_normals(self) -> Vectors:
        """Unit normal of each triangle (T, 3), outward."""
        return unit(face_vectors(self.vertices[self.triangles]))

    def with_vertices(self, vertices: npt.NDArray[Any]) -> TriangleMesh:
        """The same triangles with their vertices (V, 3) elsewhere; normals are smooth ones."""
        moved = np.ascontiguousarray(vertices, np.float64)
        return replace(self, vertices=moved, smooth=None, own=None)

    def transformed(self, linear: npt.NDArray[Any], shift: npt.NDArray[Any]) -> TriangleMesh:
        """The mesh under p ↦ linear (3, 3) · p + shift (3,), which must not be flat; still wound outward where it
        mirrors."""
        matrix = np.asarray(linear, np.float64)
        vertices = self.vertices @ matrix.T + np.asarray(shift, np.float64)
        normals = np.linalg.inv(matrix)  # of rows: the inverse transposed keeps what is outward, mirrored or not
        order = np.array((0, 1, 2) if np.linalg.det(matrix) > 0 else (0, 2, 1))
        return replace(
            self, vertices=vertices, triangles=np.ascontiguousarray(self.triangles[:, order]),
            smooth=unit(self.normals @ normals),
            own=None if self.corner_normals is None else unit(self.corner_normals[:, order] @ normals),
            uv=None if self.uv is None else np.ascontiguousarray(self.uv[:, order]),
        )  # fmt: skip


def slices(count: int) -> Iterator[slice]:
    """Rows that are computed at once, so that what is computed meanwhile takes little memory."""
    for begin in range(0, count, SLICE):
        yield slice(begin, min(begin + SLICE, count))


def unit(vectors: npt.NDArray[Any]) -> Vectors:
    """Vectors of length 1, along the last axis; those of length 0 stay."""
    found = np.asarray(vectors, np.float64)
    most = np.abs(found).max(axis=-1, keepdims=True)
    found = np.divide(found, most, out=np.zeros_like(found), where=most > 0)
    size = np.linalg.norm(found, axis=-1, keepdims=True)
    return np.divide(found, size, out=found, where=size > 0)


def face_vectors(corners: Vectors) -> Vectors:
    """Normals of triangles (T, 3, 3), as long as twice their area."""
    return np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])


def angles(corners: Vectors, k: int) -> Vectors:
    """Angles (T,) of triangles (T, 3, 3) at their corner k (Kahan 2006)."""
    a, b = (unit(corners[:, (k + step) % 3] - corners[:, k]) for step in (1, 2))
    return np.asarray(2.0 * np.arctan2(np.linalg.norm(a - b, axis=1), np.linalg.norm(a + b, axis=1)))


def smooth_normals(vertices: Vectors, triangles: Indices) -> Vectors:
    """Normals (V, 3) of vertices: those of their triangles, weighted by the angle there (Thürmer & Wüthrich 1998)."""
    found = np.zeros_like(vertices)
    sums = np.empty((3, vertices.shape[0]))
    for k in range(3):
        sums[:] = 0.0
        for rows in slices(triangles.shape[0]):
            corners = vertices[triangles[rows]]
            faces = unit(face_vectors(corners))
            angle = angles(corners, k)
            for axis in range(3):
                np.add.at(sums[axis], triangles[rows, k], angle * faces[:, axis])
        found += sums.T
    for rows in slices(found.shape[0]):
        found[rows] = unit(found[rows])
    return found


def fans_of_lists(lengths: npt.NDArray[np.integer[Any]], values: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Values (T, 3, …) at the corners of triangles; values: (n, …) of corners of polygons that stand one after the
    other, of so many corners each. Those of fewer than three make no triangle."""
    if (lengths == 3).all():
        return values.reshape(-1, 3, *values.shape[1:])
    kind: Any = np.int32 if values.shape[0] < 2**31 else np.int64
    begins: npt.NDArray[Any] = np.cumsum(lengths, dtype=kind)
    np.subtract(begins, lengths, out=begins, casting="unsafe")
    enough = lengths >= 3
    if not enough.all():  # a byte of a file may be a polygon without corners, for which no more is to be taken
        begins, lengths = begins[enough], lengths[enough]
    many = (lengths - 2).astype(kind)
    first: npt.NDArray[Any] = np.repeat(begins, many)
    turn: npt.NDArray[Any] = np.arange(1, 1 + first.size, dtype=kind)
    turn -= np.repeat(np.cumsum(many, dtype=kind) - many, many)
    turn += first
    found = np.empty((first.size, 3, *values.shape[1:]), values.dtype)
    found[:, 0], found[:, 1] = values[first], values[turn]
    turn += 1
    found[:, 2] = values[turn]
    return found


def linear(colours: npt.NDArray[Any]) -> npt.NDArray[np.float32]:
    """Linear colours (n, 3) from sRGB ones (n, 3 or more), whole numbers to 255 or real ones to 1."""
    values = colours[:, :3]
    shown = values.astype(np.float64) / (255.0 if values.dtype.kind in "iu" else 1.0)
    shown = np.clip(np.nan_to_num(shown), 0.0, 1.0)
    return srgb.decoded(shown).astype(np.float32)
