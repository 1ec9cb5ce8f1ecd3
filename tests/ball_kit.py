"""Meshes for tests, as OBJ files."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Faces = NDArray[np.int64]


def ball(rounds: int, radius: float = 1.0) -> tuple[Floats, Faces]:
    """Vertices on a sphere and triangles: an octahedron, each of whose faces is quartered ``rounds`` times. The volume
    is then enlarged to the sphere's."""
    points = [tuple(sign * one) for one in np.eye(3) for sign in (1, -1)]
    faces = [(0, 2, 4), (2, 1, 4), (1, 3, 4), (3, 0, 4), (2, 0, 5), (1, 2, 5), (3, 1, 5), (0, 3, 5)]
    vertices = [np.array(one) for one in points]
    for _ in range(rounds):
        middles: dict[tuple[int, int], int] = {}
        finer = []
        for a, b, c in faces:
            ab, bc, ca = (_middle(vertices, middles, *edge) for edge in ((a, b), (b, c), (c, a)))
            finer += [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
        faces = finer
    found, triangles = np.array(vertices, float), np.array(faces)
    corners = found[triangles]
    volume = float(np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum()) / 6
    return found * radius * (4 * np.pi / 3 / volume) ** (1 / 3), triangles


def _middle(vertices: list[Floats], known: dict[tuple[int, int], int], a: int, b: int) -> int:
    key = min(a, b), max(a, b)
    if key not in known:
        point = vertices[a] + vertices[b]
        vertices.append(point / np.linalg.norm(point))
        known[key] = len(vertices) - 1
    return known[key]


def write(
    path: Path, vertices: Floats, triangles: Faces, colours: Floats | None = None, uv: Floats | None = None
) -> Path:
    """An OBJ file; colours (V, 3) follow the vertices, uv (V, 2) are those of vertices."""
    rows = vertices if colours is None else np.hstack([vertices, colours])
    lines = ["v " + " ".join(f"{x:.9g}" for x in row) for row in rows]
    lines += [] if uv is None else [f"vt {s:.9g} {t:.9g}" for s, t in uv]
    lines += ["f " + " ".join(f"{i + 1}" if uv is None else f"{i + 1}/{i + 1}" for i in row) for row in triangles]
    path.write_text("\n".join(lines) + "\n")
    return path
