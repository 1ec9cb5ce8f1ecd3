"""What the models of this folder share: the way from a sculpture to a file, and helpers for attributes."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from ply import write
from sculpt import Sculpture, smooth_curve
from surface import Remesher, crowded, net, unit

Points = np.ndarray
SHIPPED = Path(__file__).parents[2] / "presets/meshes"


@dataclass
class Model:
    """A sculpture and how it becomes a mesh. All functions take points (N, 3) of the sculpture.

    size: the wanted length of edges; axes: coordinates of the grid for a finest spacing; pose: displacement that is
    added in the end, which makes it less symmetric; colours: uint8, sRGB; numbers: attributes of vertices.
    """

    sculpture: Sculpture
    size: Callable[[Points], np.ndarray]
    axes: Callable[[float], tuple[np.ndarray, np.ndarray, np.ndarray]]
    pose: Callable[[Points], Points]
    colours: Callable[[Points], np.ndarray]
    numbers: Callable[[Points], Mapping[str, np.ndarray]]

    def mesh(self, spacing: float, coarser: float = 1, rounds: int = 7) -> tuple[Points, np.ndarray]:
        """Vertices on the sculpture, before its pose, and triangles; edges are `coarser` times as long as wanted."""
        points, faces = net(self.sculpture.field, self.axes(spacing))
        for _ in range(8):
            if not crowded(faces):
                break
            spacing *= 0.96  # two sheets in a cell of the grid; another grid parts them
            points, faces = net(self.sculpture.field, self.axes(spacing))
        remesher = Remesher(
            self.sculpture, lambda p: coarser * self.size(p), self.sculpture.project(points, 3), faces
        )  # fmt: skip
        remesher.run(rounds)
        return remesher.points, remesher.faces

    def save(self, path: Path, points: Points, faces: np.ndarray) -> None:
        """Write the mesh with normals of the field."""
        normals = unit(self.sculpture.gradient(points))
        write(path, points + self.pose(points), normals, faces, self.colours(points), self.numbers(points))

    def unposed(self, points: Points) -> Points:
        """Where vertices of the file are on the sculpture."""
        found = points
        for _ in range(12):
            found = points - self.pose(found)
        return found


def graded(low: float, high: float, fine: tuple[float, float], spacing: float, coarse: float) -> np.ndarray:
    """Coordinates from low to high, evenly spaced within `fine`, ever wider outside of it, up to `coarse`."""
    middle = np.arange(fine[0], fine[1], spacing)

    def steps(room: float) -> np.ndarray:
        widths = np.minimum(spacing * 1.15 ** np.arange(1, 400), coarse)
        far = np.cumsum(widths)
        return far[: np.searchsorted(far, room) + 1]

    return np.concatenate([(middle[0] - steps(middle[0] - low))[::-1], middle, middle[-1] + steps(high - middle[-1])])


def step(value: np.ndarray, low: float, high: float) -> np.ndarray:
    """0 up to `low`, 1 from `high` on, smooth between them; falling where low > high."""
    t = np.clip((value - low) / (high - low), 0, 1)
    return t * t * (3 - 2 * t)


def blob(points: Points, centre: Sequence[float], size: Sequence[float]) -> np.ndarray:
    """A Gaussian round a centre and its image on the other side; `size`: where it is 1/e, along each axis."""
    there = np.column_stack([np.abs(points[:, 0]), points[:, 1:]])
    return np.exp(-(((there - np.asarray(centre)) / np.asarray(size)) ** 2).sum(1))


def from_stroke(points: Points, curve: Sequence[Sequence[float]]) -> tuple[np.ndarray, np.ndarray]:
    """Seen from ahead: distance over width, and the place along the curve (0 to 1), for a curve of (x, y, width).

    The curve also appears on the other side.
    """
    knots = smooth_curve(np.asarray(curve, float), 8)
    there = np.column_stack([np.abs(points[:, 0]), points[:, 1]])
    a, b = knots[:-1], knots[1:]
    along = b[:, :2] - a[:, :2]
    t = ((there[:, None] - a[:, :2]) * along).sum(2) / (along**2).sum(1)
    t = np.clip(t, 0, 1)
    gap = np.linalg.norm(there[:, None] - a[:, :2] - t[..., None] * along, axis=2)
    gap = gap / (a[:, 2] + t * (b[:, 2] - a[:, 2]))
    best = gap.argmin(1)
    row = np.arange(len(points))
    return gap[row, best], (best + t[row, best]) / len(a)


def mixed(base: np.ndarray, colour: Sequence[float], share: np.ndarray) -> np.ndarray:
    """Colours (N, 3) with a share (N,) of another one."""
    return base + share[:, None] * (np.asarray(colour, float) - base)


def command(doc: str | None, model: Model, name: str, spacing: float) -> None:
    """Read the command line and write the file."""
    parser = argparse.ArgumentParser(description=doc, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("file", nargs="?", type=Path, default=SHIPPED / name)
    parser.add_argument("--coarser", type=float, default=1, help="edges are so many times as long")
    options = parser.parse_args()
    points, faces = model.mesh(spacing, options.coarser)
    options.file.parent.mkdir(parents=True, exist_ok=True)
    model.save(options.file, points, faces)
    print(f"{options.file}: {len(points)} vertices, {len(faces)} triangles")
