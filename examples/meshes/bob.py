"""The scalp of the head as a bob grows on it, `presets/meshes/bob.ply`: cut out of `head.ply`, with the length of each
hair from its root to the line where all end, and the way it is combed. Run it after `head.py`.

python examples/meshes/bob.py
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from model import step
from ply import read, write
from surface import unit

MESHES = Path(__file__).parents[2] / "presets/meshes"
CROWN = np.array([0.0, 0.092, -0.045])
"""Where hair parts to all sides, metres."""
MIDDLE = np.array([0.0, 0.0, -0.012])
AXES = np.array([0.086, 0.100, 0.098])
"""Of the ellipsoid along which hair lies on the skull, metres."""
LINE, LINE_BEHIND = -0.132, -0.122
"""Heights at which hair ends: at the jaw, and at the nape."""
BROW = 0.010
"""Height at which the fringe ends."""
NAPE = 0.015
"""Length of what grows on the nape, under the rest, metres: longer, it would turn inward against the neck."""
LONGEST = 0.30
"""Length that is 1 in the file, metres."""


def fringe(points: np.ndarray) -> np.ndarray:
    """(N,) how much of the fringe hair at a place is, 0 to 1: of a triangle from the crown to the forehead."""
    x, _, z = points.T
    return step(np.abs(x) - np.minimum(0.7 * (z + 0.035), 0.047), 0.003, -0.003)


def lengths(points: np.ndarray) -> np.ndarray:
    """(N,) metres from roots to the line: over the skull down to where it is widest, and straight down from there."""
    flat = (points - MIDDLE)[:, [0, 2]]
    way = unit(flat + 1e-9)
    wide = 1 / np.sqrt((way[:, 0] / AXES[0]) ** 2 + (way[:, 1] / AXES[2]) ** 2)
    start = np.arctan2(points[:, 1] / AXES[1], np.linalg.norm(flat, axis=1) / wide)
    angle = np.linspace(0, 1, 65)[:, None] * np.maximum(start, 0)
    over = np.hypot(np.diff(wide * np.cos(angle), axis=0), np.diff(AXES[1] * np.sin(angle), axis=0)).sum(0)
    line = LINE + (LINE_BEHIND - LINE) * step(points[:, 2], -0.02, -0.09)
    fall = np.minimum(points[:, 1], 0) - line
    front = np.hypot(points[:, 1] - 0.055, points[:, 2] - 0.080) * 1.2 + 0.066 - BROW
    found = over + fall + fringe(points) * (front - over - fall)
    nape = step(points[:, 1], 0.000, -0.022) * step(points[:, 2], -0.025, -0.045)
    return found + nape * (np.minimum(found, NAPE) - found)


def ways(points: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """(N, 3) unit directions along the scalp: away from the crown and down, the fringe ahead."""
    away = points - CROWN
    away[:, 1] = 0
    away[:, 2] = np.minimum(away[:, 2], 0)  # to the sides, beside the fringe
    wanted = unit(away + 1e-9) + np.array([0, -1.0, -0.25])
    ahead = np.column_stack([4 * points[:, 0], np.full(len(points), -0.4), np.ones(len(points))])
    wanted += fringe(points)[:, None] * (ahead - wanted)
    return unit(wanted - normals * (normals * wanted).sum(1, keepdims=True))


def main() -> None:
    """Write the file."""
    rows, faces = read(MESHES / "head.ply")
    used, corners = np.unique(faces[(rows["scalp"] > 0)[faces].any(axis=1)], return_inverse=True)
    rows = rows[used]
    points, normals = (np.stack([rows[prefix + axis] for axis in "xyz"], 1).astype(float) for prefix in ("", "n"))
    colours = np.stack([rows[name] for name in ("red", "green", "blue")], 1)
    numbers = {"density": rows["scalp"], "length": np.clip(lengths(points) / LONGEST, 0.05, 1)}
    numbers |= {f"comb_{a}": column for a, column in zip("xyz", ways(points, normals).T, strict=True)}
    write(MESHES / "bob.ply", points, normals, corners.reshape(-1, 3), colours, numbers)


if __name__ == "__main__":
    main()
