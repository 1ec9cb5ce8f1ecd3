"""Whether hair of a file is meant for a solid as it stands, and which up axis and unit would bring its roots there;
and the nearest points of a solid's surface to points.

Every up axis is tried with every ratio of usual units; roots lie on the scalp with the right ones alone, unless the
solid is a ball, on which many fit.
"""

from __future__ import annotations

import itertools
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..common.rotations import AXES, turning
from ..errors import UsageError
from ..exchange.edits import reversed_all, strands_not_finite
from ..exchange.ends import ends, up_axis
from ..exchange.files import ReadOptions, read
from ..exchange.strands import Strands
from ..mesh_file.prepared import key_of, mesh_of, prepared
from ..meshes.bvh import closest
from .kernels.rows import grid_distances

Floats = NDArray[np.float64]

PLANE = 1.0
"""Metres that a plane counts as large."""
AT_ONCE = 1 << 20
"""Points that are looked at at once."""


class Near(NamedTuple):
    """Of points (n): the nearest ones of a surface (n, 3), signed distances (n,), negative inside, and unit vectors
    (n, 3) along which the distance grows."""

    points: Floats
    distances: Floats
    outward: Floats


class Surface:
    """The surface of a solid at the start, in its own frame, metres. ``size``: the longest side of its box."""

    def __init__(self, solid: Any) -> None:
        self.solid = solid
        if solid.kind == "mesh":
            self.mesh = prepared(key_of(solid, 0.0))
            self.size = mesh_of(solid).size()
        else:
            self.size = PLANE
            if solid.kind != "plane":
                self.half, self.radius = CORES[solid.kind](solid)
                self.size = 2 * (float(self.half.max()) + self.radius)

    def nearest(self, points: Floats) -> Near:
        """Return the nearest points of the surface to points (n, 3)."""
        if self.solid.kind == "plane":
            return Near(points * [1.0, 0.0, 1.0], points[:, 1].copy(), np.broadcast_to([0.0, 1.0, 0.0], points.shape))
        if self.solid.kind != "mesh":
            return _around(self.half, self.radius, points)
        found = closest(self.mesh.bvh, points)
        away = (points - found.points) / np.where(found.distances == 0, 1.0, found.distances)[:, None]
        faces = self.mesh.faces[found.triangles]
        on = np.abs(found.distances) < 1e-6 * self.size
        return Near(found.points, found.distances, np.where(on[:, None], faces, away))

    def least(self, points: Floats) -> NDArray[np.floating]:
        """Return (n,) numbers that are hardly above the distances of points (n, 3), quickly."""
        if self.solid.kind != "mesh":
            return self.nearest(points).distances
        found = np.empty(len(points), np.float32)
        grid_distances(self.mesh.grid, points, found)
        return np.asarray(found - self.mesh.grid.spacing)


CORES = {
    "sphere": lambda solid: (np.zeros(3), solid.radius),
    "capsule": lambda solid: (np.array([0.0, 0.5 * solid.length, 0.0]), solid.radius),
    "box": lambda solid: (0.5 * np.array(solid.size), 0.0),
}
"""Of solids half the size (3,) of a box, and the distance from it within which they are."""


def _around(half: Floats, radius: float, points: Floats) -> Near:
    """`Near` of all within a radius of a box."""
    core = np.clip(points, -half, half)
    outward = points - core
    distances = np.linalg.norm(outward, axis=1)
    outward /= np.where(distances > 0, distances, 1.0)[:, None]
    inside = np.flatnonzero(distances == 0)
    room = half - np.abs(points[inside])
    axis = np.argmin(room, axis=1)
    side = np.where(points[inside, axis] < 0, -1.0, 1.0)
    core[inside, axis] = side * half[axis]
    distances[inside] = -room[np.arange(len(inside)), axis]
    outward[inside] = 0.0
    outward[inside, axis] = side
    return Near(core + radius * outward, distances - radius, outward)


UP = "y"
"""The up axis of scenes."""
SURE, CLOSE = 0.002, 0.02
"""Median distance of roots from the surface, over the solid's size, up to which hair fits without doubt, and up to
which it does where no other placing is clearly better."""
CLEARLY = 0.2
"""Another placing is reported where it leaves at most so much of the distance."""
UNITS = (1.0, 0.0254, 0.1, 0.01, 0.001)
"""Metres of usual units."""
FACTORS = tuple(sorted({round(a / b, 9) for a, b in itertools.product(UNITS, UNITS)}))
SPREAD = 0.2
"""Longest side of the box of the roots, over the solid's, at least: a spot fits wherever it is."""
ENOUGH = 1000
"""Roots that are tried, evenly chosen."""


class Frame(NamedTuple):
    """How the solid stands in the frame of the roots: its rotation (3, 3) and its place (3,)."""

    turn: Floats
    shift: Floats

    def own(self, points: NDArray[np.floating]) -> Floats:
        """Points (n, 3) in the solid's own frame."""
        return np.asarray((points.astype(np.float64) - self.shift) @ self.turn)


class Better(NamedTuple):
    """A placing: the file's up axis, a factor to its scale, and the median distance of roots then."""

    up: str
    factor: float
    median: float


def better(roots: Floats, up: str, surface: Surface, frame: Frame, likely: str | None = None) -> Better | None:
    """The placing with which roots (S, 3) are nearest to a surface; None where they fit as they are, none is clearly
    better, or several up axes are. ``up``: the axis of the file that is y in the roots' frame, and stays where it is
    among these; ``likely``: what hair that hangs tells of it, which comes first."""
    some = roots[:: max(len(roots) // ENOUGH, 1)]

    def median(axis: str, factor: float) -> float:
        turn = turning(axis, UP) @ turning(up, UP).T
        return float(np.median(np.abs(surface.nearest(frame.own(factor * (some @ turn.T))).distances)))

    now = median(up, 1.0)
    if surface.solid.kind == "plane" or now <= SURE * surface.size:
        return None
    large = float(np.ptp(some, axis=0).max()) / surface.size
    tried = [Better(a, f, median(a, f)) for f in FACTORS if SPREAD <= f * large <= 1 / SPREAD for a in AXES]
    # of each axis the best factor, of equal ones that which changes nothing
    fine = {one.up: one for one in sorted(tried, key=lambda one: (one.median, one.factor != 1), reverse=True)
            if one.median <= min(CLEARLY * now, CLOSE * surface.size)}  # fmt: skip
    least = min((one.median for one in fine.values()), default=0.0)
    rivals = {axis: one for axis, one in fine.items() if CLEARLY * one.median <= least}
    one_left = next(iter(rivals)) if len(rivals) == 1 else ""
    return next((rivals[axis] for axis in (likely, up, one_left) if axis in rivals), None)


def hangs_from(strands: Strands) -> str | None:
    """The axis that hair which hangs tells to be up, if roots are first; None where it does not."""
    known = ends(strands)
    found = up_axis(strands, known) if known.root == "first" else None
    return None if found is None else found[0]


def words(found: Better, up: str, size: float | None = None) -> str:
    """The settings of a placing that differ, ``up`` and ``size`` being those now; a size stands in place of a scale."""
    parts = [] if found.up == up else [f"emitter.groom.up: {found.up}"]
    if found.factor != 1 and size is not None:
        parts.append(f"emitter.groom.size: {found.factor * size:.4g}")
    elif found.factor != 1:
        parts.append(f"emitter.groom.scale multiplied by {found.factor:.4g}")
    return " and ".join(parts)


def facts_on(file: Path, given: ReadOptions, solid: Any) -> dict[str, Any]:
    """How the roots of a file, in its unit and axes or those that it tells, lie on a mesh: the settings of a solid of
    that kind, in its own frame. Raises `UsageError` for a file without finite strands."""
    mesh = solid.file
    strands = read(file, given)
    strands = strands.select(~strands_not_finite(strands))
    if not strands.count:
        raise UsageError(f"{file}: has no strand that could lie on {mesh}")
    if ends(strands).root == "last":
        strands, _ = reversed_all(strands)
    roots = strands.roots()
    up, unit = strands.source.up or UP, strands.source.unit or 1.0
    surface = Surface(solid)
    placed = unit * (roots.astype(np.float64) @ turning(up, UP).T)
    off = np.abs(surface.nearest(placed).distances)
    found = better(placed, up, surface, Frame(np.eye(3), np.zeros(3)), hangs_from(strands))
    median = float(np.median(off))
    mend = None
    if found is not None:
        mend = {"up": found.up, "scale": found.factor * unit, "median": found.median}
    fits = found is None and median <= CLOSE * surface.size
    return {
        "mesh": mesh, "size": surface.size, "median": median, "most": float(off.max()),
        "fits": fits, "up": up, "scale": unit, "mend": mend,
    }  # fmt: skip


def said(data: dict[str, Any]) -> str:
    """The same in a line."""
    there = (
        f"roots are {data['median']:.3g} off it in the median, {data['most']:.3g} at most, its size {data['size']:.3g}"
    )
    if data["fits"]:
        return f"{there}: they fit"
    mend = data["mend"]
    if mend is None:
        return f"{there}: neither another unit nor another up axis brings them there; move or scale one of them"
    options, settings = [], []
    if mend["scale"] != data["scale"]:
        options.append(f"--scale {mend['scale'] / data['scale']:.4g}")
        settings.append(f"emitter.groom.scale: {mend['scale']:.4g}")
    if mend["up"] != data["up"]:
        options.append(f"--up={mend['up']}")
        settings.append(f"emitter.groom.up: {mend['up']}")
    mended = f"with {' and '.join(settings)} they would be {mend['median']:.3g} off"
    return f"{there}: {mended}; 'convert {' '.join(options)}' writes them so"
