"""Normals that a mesh is shaded with: the file's, or smooth ones that keep creases."""

from __future__ import annotations

import math

import numpy as np

from ..meshes.mesh import TriangleMesh, Vectors, unit

SAME = 1e-3
"""Sine of the angle within which a file's normal is that of its face; files have some six digits."""
FACETS = 0.99
"""Share of triangles whose normals are those of their faces, from which on a file tells no more than faces do."""


def shading_normals(mesh: TriangleMesh, crease: float) -> Vectors:
    """Unit normals (T, 3, 3) of the corners of triangles: the file's own; where it has none, or those of the faces
    alone, smooth ones, but not across edges where faces meet at ``crease`` degrees or more."""
    if mesh.corner_normals is not None and not _of_faces(mesh):
        return mesh.corner_normals
    return smooth(mesh, crease)


def _of_faces(mesh: TriangleMesh) -> bool:
    """Whether a file's normals are only those of its faces."""
    own = mesh.normals_of_corners()
    off = np.linalg.norm(np.cross(np.broadcast_to(mesh.face_normals()[:, None], own.shape), own), axis=2)
    return bool((off < SAME).all(axis=1).mean() > FACETS)


def smooth(mesh: TriangleMesh, crease: float) -> Vectors:
    """Unit normals (T, 3, 3): at each corner the mean of the triangles around the vertex whose faces are turned against
    its own by less than ``crease`` degrees, weighted by their angles there."""
    faces, corners = mesh.face_normals(), mesh.vertices[mesh.triangles]
    if crease >= 180.0:
        return mesh.normals[mesh.triangles]
    weighted = np.empty((len(faces), 3, 3))
    for k in range(3):
        a = unit(corners[:, (k + 1) % 3] - corners[:, k])
        b = unit(corners[:, (k + 2) % 3] - corners[:, k])
        angle = 2.0 * np.arctan2(np.linalg.norm(a - b, axis=1), np.linalg.norm(a + b, axis=1))
        weighted[:, k] = angle[:, None] * faces
    flat = weighted.reshape(-1, 3)
    vertex = mesh.triangles.reshape(-1)
    order = np.argsort(vertex, kind="stable")
    begin = np.searchsorted(vertex[order], np.arange(len(mesh.vertices) + 1))
    around = np.diff(begin)[vertex]
    place = np.empty(len(order), np.int64)
    place[order] = np.arange(len(order)) - begin[vertex[order]]
    least = math.cos(math.radians(crease))
    found = flat.copy()
    for step in range(1, int(around.max())):  # each corner together with the next, the one after that and so on
        mine = np.flatnonzero(around > step)
        other = order[begin[vertex[mine]] + (place[mine] + step) % around[mine]]
        near = np.einsum("ij,ij->i", faces[mine // 3], faces[other // 3]) > least
        found[mine[near]] += flat[other[near]]
    made: Vectors = unit(found).reshape(-1, 3, 3)
    return made
