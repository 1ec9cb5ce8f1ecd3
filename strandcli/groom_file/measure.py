"""How much of the view strands take up, and where a camera stands that sees them all."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..common.rotations import xyz
from ..constants import W
from ..exchange.strands import Strands
from ..scene.motion import emitter_pose

if TYPE_CHECKING:
    from ..scene.model import Camera, Scene

Floats = NDArray[np.float64]
LOOKED_AT = 200_000
"""Points, at most, evenly chosen."""
CELLS = 32
"""Of a grid along the longest side of the box, by which the area is measured."""
WIDEST = 1 / 200
"""Width of strands over the longest side of the box about all, at most: more of them would be noodles."""
WIDE = 1024
"""Points that are compared at once."""
APART, USUAL = 10.0, 99.0
"""Points so many times as far from the middle as so many of 100 at most are apart: no picture is fitted to them."""
NEAR = 0.01
"""Greatest share of its distance from what it sees at which a camera has its near plane."""


@dataclass(frozen=True, eq=False)
class Seen:
    """What strands look like as a whole, in the emitter's frame."""

    points: NDArray[np.float32]
    """(k, 3) metres: some of their points, tips and roots among them, none apart from the rest."""
    area: float
    """Square metres that they are seen before, on average over views along the three axes."""
    length: float
    """Metres of all strands together, of one that is far longer than the rest a part."""
    apart: int
    """Points that were looked at and are apart."""
    radius: float
    """Metres, of a ball about all points that were looked at, those too that are apart."""


def seen_of(strands: Strands, lengths: Floats) -> Seen:
    """The same of strands that are so long each (S,)."""
    step = max(strands.points.shape[0] // LOOKED_AT, 1)
    ends_step = max(strands.count // (LOOKED_AT // 4), 1)
    roots, tips = strands.first[:-1:ends_step], strands.first[1::ends_step] - 1
    few = np.concatenate([strands.points[::step], strands.points[roots], strands.points[tips]])
    near = together(few)
    usual = np.minimum(lengths, APART * np.percentile(lengths, USUAL))
    low, high = box_of(few)
    radius = 0.5 * float(np.linalg.norm(high - low))
    return Seen(near, area_of(near), float(usual.sum()), few.shape[0] - near.shape[0], radius)


def together(points: NDArray[np.float32]) -> NDArray[np.float32]:
    """Points (k, 3) without those apart from the rest."""
    far = np.linalg.norm(points - np.median(points, axis=0), axis=1)
    return points[far <= APART * np.percentile(far, USUAL)]


def some_of(packed: NDArray[np.float32]) -> NDArray[np.float32]:
    """(k, 3) some of the points of strands (blocks, n + 1, 3 W), those apart from the rest or not finite left out."""
    points = packed[:: max(packed[:, 1:].size // (3 * LOOKED_AT), 1), 1:].reshape(-1, 3, W).transpose(0, 2, 1)
    finite = points[np.isfinite(points).all(axis=-1)]
    return together(finite) if finite.size else finite


def box_of(points: NDArray[np.float32]) -> Floats:
    """Least and greatest coordinates (2, 3) of points (k, 3)."""
    whole = points.shape[0] - points.shape[0] % WIDE
    rows, rest = points[:whole].reshape(-1, WIDE, 3), points[whole:]
    parts = [rows.min(axis=0), rows.max(axis=0)] if whole else []  # NumPy takes ten times as long for short rows
    every = np.concatenate([*parts, rest])
    return np.stack([every.min(axis=0), every.max(axis=0)]).astype(np.float64)


def area_of(points: NDArray[np.float32]) -> float:
    """Square metres that points (k, 3) are seen before, the mean of three views: cells of a grid that hold any."""
    low, high = points.min(axis=0).astype(np.float64), points.max(axis=0).astype(np.float64)
    cell = max(float((high - low).max()) / CELLS, 1e-30)
    places = np.minimum(((points - low) / cell).astype(np.int64), CELLS - 1)
    found = [np.unique(places[:, a] * CELLS + places[:, b]).size for a, b in ((0, 1), (1, 2), (2, 0))]
    return float(np.mean(found)) * cell * cell


def width_for(seen: Seen, times: float) -> float:
    """Metres that strands are wide that cover the area so many times; where they are few, `WIDEST` of their box."""
    low, high = box_of(seen.points)
    return min(times * seen.area / seen.length, WIDEST * float((high - low).max()))


def fitted(scene: Scene, points: NDArray[np.float32]) -> Camera:
    """The scene's camera, moved along and across its direction so that points (k, 3) in the emitter's frame fill the
    share `fit` of the picture."""
    camera = scene.camera
    assert camera.fit is not None
    pose = emitter_pose(scene.emitter, 0.0)
    placed = points.astype(np.float64) @ np.array(pose.rotation).T + np.array(pose.translation)
    return framed(camera, placed, scene.image.size)


def framed(camera: Camera, points: Floats, size: tuple[int, int]) -> Camera:
    """A camera, moved along and across its direction so that points (k, 3) fill the share `fit` of a picture of a size,
    pixels."""
    assert camera.fit is not None
    ahead = np.subtract(camera.target, camera.position, dtype=np.float64)
    ahead /= np.linalg.norm(ahead)
    right = np.cross(ahead, camera.up)
    right /= np.linalg.norm(right)
    above = np.cross(right, ahead)
    middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
    x, y, z = ((points - middle) @ axis for axis in (right, above, ahead))
    width, height = size
    if camera.kind == "orthographic":
        across, tall = np.ptp(x), np.ptp(y)
        view = max(float(tall), float(across) * height / width, 1e-6) / camera.fit
        away = 2 * view - float(z.min())
        moved = middle + 0.5 * (x.min() + x.max()) * right + 0.5 * (y.min() + y.max()) * above
    else:
        steep = math.tan(math.radians(camera.fov) / 2) * camera.fit
        (aside, back), (lifted, off) = _framed(x, z, steep * width / height), _framed(y, z, steep)
        away, view = max(back, off, 1e-6 - float(z.min())), camera.height
        moved = middle + aside * right + lifted * above
    near = min(camera.near, NEAR * max(away + float(z.min()), 1e-3 * away))
    eye = moved - away * ahead
    return replace(
        camera, position=xyz(eye), target=xyz(moved), height=view, near=near, fit=None,
    )  # fmt: skip


def _framed(x: Floats, z: Floats, slope: float) -> tuple[float, float]:
    """Where a camera stands across its axis, and how far before the origin of z along it, whose view of that slope just
    holds all points: |x − aside| ≤ slope (away + z)."""
    one, other = float((x - slope * z).max()), float((-x - slope * z).max())
    return 0.5 * (one - other), 0.5 * (one + other) / slope
