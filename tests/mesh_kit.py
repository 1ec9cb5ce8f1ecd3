"""Meshes for tests, and what is known of them by going through all triangles."""

from __future__ import annotations

from functools import cache

import numpy as np

from strandcli.meshes.make import make_mesh
from strandcli.meshes.mesh import TriangleMesh

CUBE = np.array([
    (0, 2, 1), (1, 2, 3), (4, 5, 6), (5, 7, 6), (0, 1, 4), (1, 5, 4), (2, 6, 3), (3, 6, 7), (0, 4, 2), (2, 4, 6),
    (1, 3, 5), (3, 7, 5),
])  # fmt: skip


def cube() -> tuple[np.ndarray, np.ndarray]:
    """The box of corners -1 and 1, wound outward."""
    vertices = np.array([[x, y, z] for z in (-1.0, 1.0) for y in (-1.0, 1.0) for x in (-1.0, 1.0)])
    return vertices, CUBE


def sphere(times: int = 3) -> tuple[np.ndarray, np.ndarray]:
    """A sphere of radius 1: an octahedron whose edges are halved so many times."""
    vertices = np.array([[1.0, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]])
    triangles = np.array([(0, 2, 4), (2, 1, 4), (1, 3, 4), (3, 0, 4), (2, 0, 5), (1, 2, 5), (3, 1, 5), (0, 3, 5)])
    for _ in range(times):
        edges = np.sort(np.concatenate([triangles[:, (0, 1)], triangles[:, (1, 2)], triangles[:, (2, 0)]]), axis=1)
        ends, row = np.unique(edges, axis=0, return_inverse=True)
        middles = vertices[ends].sum(axis=1)
        new = vertices.shape[0] + row.reshape(3, -1).T
        vertices = np.concatenate([vertices, middles / np.linalg.norm(middles, axis=1, keepdims=True)])
        a, b, c = triangles.T
        ab, bc, ca = new.T
        triangles = np.concatenate(
            [np.stack(one, axis=1) for one in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))]
        )
    return vertices, triangles


@cache
def mesh(name: str) -> TriangleMesh:
    """A closed ball and box, a bowl that is open above, triangles anywhere, and slivers."""
    generator = np.random.default_rng(7)
    if name == "ball":
        return make_mesh(*sphere())
    if name == "box":
        return make_mesh(*cube())
    if name == "bowl":
        vertices, triangles = sphere()
        return make_mesh(vertices, triangles[(vertices[triangles, 1] < 0.5).all(axis=1)])
    if name == "sliver":
        vertices = np.repeat(generator.normal(size=(60, 3)), 3, axis=0)
        vertices[1::3] += generator.normal(size=(60, 3))
        vertices[2::3] = vertices[1::3] + 1e-5 * generator.normal(size=(60, 3))
        return make_mesh(vertices, np.arange(180).reshape(-1, 3))
    assert name == "soup"
    return make_mesh(generator.normal(size=(180, 3)), np.arange(180).reshape(-1, 3))


def all_hits(mesh: TriangleMesh, origins: np.ndarray, directions: np.ndarray) -> tuple[np.ndarray, ...]:
    """t, u, v (R, T) of rays and all triangles; t infinite where they do not meet (Möller & Trumbore 1997)."""
    a, b, c = np.moveaxis(mesh.vertices[mesh.triangles], 1, 0)
    along, across = b - a, c - a
    p = np.cross(directions[:, None], across)
    with np.errstate(all="ignore"):
        inverse = 1.0 / (along * p).sum(axis=2)
        from_a = origins[:, None] - a
        u = (from_a * p).sum(axis=2) * inverse
        q = np.cross(from_a, along)
        v = (directions[:, None] * q).sum(axis=2) * inverse
        t = (across * q).sum(axis=2) * inverse
        met = (u >= 0) & (v >= 0) & (u + v <= 1) & (t >= 0)
    return np.where(met, t, np.inf), u, v
