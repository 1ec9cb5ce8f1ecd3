"""Ambient occlusion: the visible share of the sky among strands and solids.

Shadow maps from many directions would need one look-up for each direction at each vertex. Instead, the strands are
accumulated in the cells of a grid, light is swept through the grid from each direction, and each cell stores the best
linear fit of the visibility over directions. That is enough for surfaces and strands: an unoccluded hemisphere comes
out exactly. Tests compare it with rays that intersect cylinders.

Not modelled: light reflected by solids, and structure smaller than a cell, such as the gaps between strands.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...scene.model import AmbientOcclusion
from ...solids import Solids
from ..common.scratch import Scratch
from ..geometry.detail import Level
from ..geometry.extent import Thickness
from ..solids.solids import NONE, ball_of, rows_of
from ..view.camera import ball
from .kernels import occlusion as kernel
from .kernels import occlusion_sweep
from .kernels.occlusion import CHANNELS, MEAN

FEWEST, MOST = 12, 256
"""Least and greatest number of cells along each axis."""
ENOUGH = 6000
"""Least number of strands that are sampled if there are more; each then represents several."""
AROUND = 0.5
"""Greatest widening of the grid by nearby solids, as a share of the strands' extent."""
GRAIN = 1e-6
"""Relative margin that exceeds the spacing of single-precision coordinates."""
GOLDEN = math.pi * (3.0 - math.sqrt(5.0))


@dataclass(frozen=True)
class Occlusion:
    """A grid of sky visibility, read by `kernels.occlusion.sky_visibility`."""

    volume: NDArray[np.float32]
    """(V, 4) visibility of each cell, as the best linear fit v₀ + v · ω over directions ω."""
    box: NDArray[np.float32]
    """(10,) columns of `kernels.occlusion`."""

    def at(self, points: NDArray[np.floating], normals: NDArray[np.floating] | None = None) -> NDArray[np.float64]:
        """Return the visible share (P,) of the sky at points (P, 3), or of the hemispheres of unit normals (P, 3)."""
        flat = np.zeros_like(points) if normals is None else normals
        rows = np.column_stack([points, flat]).astype(np.float32)
        return np.array([kernel.sky_visibility(self.volume, self.box, *row) for row in rows], np.float64)


def build(
    settings: AmbientOcclusion, positions: NDArray[np.float32], strands: int, bounds: NDArray[np.float64],
    thickness: Thickness, level: Level | None, packed: Solids | None, scratch: Scratch,
    numbers: NDArray[np.int64] | None = None, shares: NDArray[np.float32] | None = None,
) -> Occlusion:  # fmt: skip
    """Return the occlusion by strands and solids.

    positions (blocks, n + 1, 3 W), of which the first ``strands`` count; bounds (2, 3): their bounding box, metres;
    packed: solids from `strandcli.solids.pack`; numbers: where the strands of positions are among the ``strands``,
    of which the rest have no width, None: 0, 1, …; shares (strands, n): of each strand's width, at its points, None:
    as the thickness tapers"""
    low, high = _box(bounds, packed)
    counts, sides, box = _grid(low, high, settings.cells)
    total = int(np.prod(counts))
    cells = scratch.borrow("occlusion_cells", (total, CHANNELS), np.float32)
    cells.fill(0)
    step = max(strands // ENOUGH, 1)
    weight = strands / len(range(0, strands, step)) / float(np.prod(sides.astype(np.float64)))
    chosen = np.arange(0, strands, step) if numbers is None else np.flatnonzero(numbers % step == 0)
    occlusion_sweep.count_strands(
        positions, chosen, np.float32(thickness.width), np.float32(thickness.taper),
        None if level is None else level.scale, shares, np.float32(weight), box, cells,
    )  # fmt: skip
    rays = directions(settings.directions)
    left = scratch.borrow("occlusion_left", (len(rays), total), np.uint8)
    occlusion_sweep.sweep(cells, counts, sides, rays, left)
    volume = scratch.borrow("occlusion", (total, 4), np.float32)
    occlusion_sweep.combine(cells, counts, sides, box, rays, left, packed or NONE, volume)
    return Occlusion(volume, box)


def nothing() -> Occlusion:
    """Return the occlusion of a scene without strands and solids: the whole sky is visible."""
    volume = np.zeros((8, 4), np.float32)
    volume[:, MEAN] = 1
    return Occlusion(volume, np.array([-1, -1, -1, 0.5, 0.5, 0.5, 2, 2, 2, 1], np.float32))


def directions(count: int) -> NDArray[np.float32]:
    """Return (count or count + 1, 3) unit vectors spread evenly over the sphere: a Fibonacci spiral over the upper
    half, and its opposites, so that every hemisphere contains half of them."""
    half = -(-count // 2)
    y = (np.arange(half) + 0.5) / half
    around = GOLDEN * np.arange(half) + 0.1  # the offset avoids directions along the grid's axes
    ring = np.sqrt(1.0 - y * y)
    upper = np.stack([ring * np.cos(around), y, ring * np.sin(around)], 1)
    return np.concatenate([upper, -upper]).astype(np.float32)


def _box(bounds: NDArray[np.float64], packed: Solids | None) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the corners of a box around the strands and the nearby parts of solids."""
    _, radius = ball(bounds)
    low, high = bounds[0].copy(), bounds[1].copy()
    for kind, row in rows_of(packed or NONE):
        if kind != "plane":
            centre, reach = ball_of(kind, row)
            low, high = np.minimum(low, centre - reach), np.maximum(high, centre + reach)
    room = AROUND * (bounds[1] - bounds[0])
    low, high = np.maximum(low, bounds[0] - room), np.minimum(high, bounds[1] + room)
    # far from the origin all strands may have the same coordinates in single precision
    margin = max(1e-3 * radius, GRAIN * float(np.abs(bounds).max()))
    return low - margin, high + margin


def _grid(
    low: NDArray[np.float64], high: NDArray[np.float64], cells: int
) -> tuple[NDArray[np.int64], NDArray[np.float32], NDArray[np.float32]]:
    """Return the number of cells along each axis, their sides in metres, and the box in `kernels.occlusion`: about
    ``cells`` cells, as close to cubes as `FEWEST` and `MOST` allow."""
    extent = high - low
    counts = np.zeros(3)
    free = np.ones(3, bool)
    for _ in range(3):
        side = (np.prod(extent[free]) / (cells / np.prod(counts[~free]))) ** (1.0 / free.sum())
        counts[free] = np.clip(np.ceil(extent[free] / side), FEWEST, MOST)
        fixed = free & (counts == FEWEST)
        if not fixed.any() or not (free & ~fixed).any():
            break
        free &= ~fixed
    sides = extent / counts
    box = np.array([*(low + sides / 2), *(1.0 / sides), *counts, 0.5 * float(extent.mean())], np.float32)
    return counts.astype(np.int64), sides.astype(np.float32), box
