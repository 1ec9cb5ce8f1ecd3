"""What is wet of the fox, eyes and nose, as `presets/meshes/fox-eyes.ply`: a sheet a little above its skin, for a coat
that the skin has not. Run it after `fox.py`.

python examples/meshes/fox_eyes.py
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from fox_shape import EYE, NOSE
from ply import read, write

MESHES = Path(__file__).parents[2] / "presets/meshes"
ABOVE = 0.0001
"""Metres above the skin."""
EYES, NOSES = 0.0128, 0.016
"""Distances from the middles of eyes and nose within which bare skin is wet, metres."""


def wet(rows: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Rows of the fox's vertices that are wet, and triangles (M, 3) among them, of its vertices and triangles."""
    points = np.stack([rows[axis] for axis in "xyz"], 1)
    right = np.column_stack([np.abs(points[:, 0]), points[:, 1:]])
    near = (np.linalg.norm(right - EYE, axis=1) < EYES) | (np.linalg.norm(points - NOSE, axis=1) < NOSES)
    bare = near & (rows["density"] < 0.7)
    used, corners = np.unique(faces[bare[faces].all(axis=1)], return_inverse=True)
    return rows[used], corners.reshape(-1, 3)


def main() -> None:
    """Write the file."""
    rows, faces = wet(*read(MESHES / "fox.ply"))
    points, normals, colours = (
        np.stack([rows[name] for name in names], 1)
        for names in (("x", "y", "z"), ("nx", "ny", "nz"), ("red", "green", "blue"))
    )
    write(MESHES / "fox-eyes.ply", points + ABOVE * normals, normals, faces, colours, {})


if __name__ == "__main__":
    main()
