"""Ambient occlusion: how much of the light from everywhere strands and solids leave a place.

A shadow map for each of many directions would have to be read for each of them at each vertex. Here strands are counted
once in the cells of a grid; light is swept through it from each direction; and each cell keeps the mean of what arrives
and its direction, which is all that surfaces and strands need: a surface's own half of the sky comes out exactly.
`strandcli study PRESET --axis occlusion` measures the error against rays that meet cylinders.

Not in it: light that solids reflect, and that a cell is larger than a strand's distance from the next.
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
from .kernels import occlusion_cells, occlusion_sweep
from .kernels.occlusion_columns import CHANNELS

FEWEST, MOST = 12, 256
"""Cells along each axis."""
ENOUGH = 6000
"""Strands that are counted at the least where there are more; each then stands for several."""
AROUND = 0.5
"""Part of the strands' extent by which solids beside them widen the box."""
GRAIN = 1e-6
"""Of places in single precision, as a share of their distance from the origin, and some more."""
GOLDEN = math.pi * (3.0 - math.sqrt(5.0))


@dataclass(frozen=True)
class Occlusion:
    """A grid, as `kernels.occlusion.seen` reads it."""

    volume: NDArray[np.float32]
    """(V, 4): what is seen, as the best linear fit v₀ + v · ω over directions ω."""
    box: NDArray[np.float32]
    """(10,) columns of `kernels.occlusion_columns`."""

    def at(self, points: NDArray[np.floating], normals: NDArray[np.floating] | None = None) -> NDArray[np.float64]:
        """(P,) shares of the sky that points (P, 3) see: all of it, or what faces unit normals (P, 3)."""
        flat = np.zeros_like(points) if normals is None else normals
        rows = np.column_stack([points, flat]).astype(np.float32)
        return np.array([kernel.seen(self.volume, self.box, *row) for row in rows], np.float64)


def build(
    settings: AmbientOcclusion, positions: NDArray[np.float32], strands: int, bounds: NDArray[np.float64],
    thickness: Thickness, level: Level | None, packed: Solids | None, scratch: Scratch,
) -> Occlusion:  # fmt: skip
    """The occlusion by the first ``strands`` of positions (blocks, n + 1, 3 W), whose box is ``bounds`` (2, 3), and by
    solids packed by `strandcli.solids.pack`."""
    low, high = _box(bounds, packed)
    counts, sides, box = _grid(low, high, settings.cells)
    total = int(np.prod(counts))
    cells = scratch.take("occlusion_cells", (total, CHANNELS), np.float32)
    cells.fill(0)
    step = max(strands // ENOUGH, 1)
    weight = strands / len(range(0, strands, step)) / float(np.prod(sides.astype(np.float64)))
    occlusion_cells.count_strands(
        positions, np.int64(strands), np.int64(step), np.float32(thickness.width), np.float32(thickness.taper),
        None if level is None else level.scale, np.float32(weight), box, cells,
    )  # fmt: skip
    ways = directions(settings.directions)
    left = scratch.take("occlusion_left", (len(ways), total), np.uint8)
    occlusion_sweep.sweep(cells, counts, sides, ways, left)
    volume = scratch.take("occlusion", (total, 4), np.float32)
    occlusion_sweep.combine(cells, counts, sides, box, ways, left, packed or NONE, volume)
    return Occlusion(volume, box)


def nothing() -> Occlusion:
    """Of a scene without strands or solids: all is seen."""
    volume = np.zeros((8, 4), np.float32)
    volume[:, 0] = 1
    return Occlusion(volume, np.array([-1, -1, -1, 0.5, 0.5, 0.5, 2, 2, 2, 1], np.float32))


def directions(count: int) -> NDArray[np.float32]:
    """(count or one more, 3) unit vectors evenly over the sphere, each with its opposite, so that half of them see any
    half of the sky: a Fibonacci spiral over the upper half."""
    half = -(-count // 2)
    y = (np.arange(half) + 0.5) / half
    around = GOLDEN * np.arange(half) + 0.1  # none along an axis of the grid
    ring = np.sqrt(1.0 - y * y)
    upper = np.stack([ring * np.cos(around), y, ring * np.sin(around)], 1)
    return np.concatenate([upper, -upper]).astype(np.float32)


def _box(
    bounds: NDArray[np.float64], packed: Solids | None
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Corners of the box about the strands, and about what of solids is near them."""
    _, radius = ball(bounds)
    low, high = bounds[0].copy(), bounds[1].copy()
    for kind, row in rows_of(packed or NONE):
        if kind != "plane":
            centre, reach = ball_of(kind, row)
            low, high = np.minimum(low, centre - reach), np.maximum(high, centre + reach)
    room = AROUND * (bounds[1] - bounds[0])
    low, high = np.maximum(low, bounds[0] - room), np.minimum(high, bounds[1] + room)
    # far from the origin single precision may put all strands into one place
    margin = max(1e-3 * radius, GRAIN * float(np.abs(bounds).max()))
    return low - margin, high + margin


def _grid(
    low: NDArray[np.float64], high: NDArray[np.float64], cells: int
) -> tuple[NDArray[np.int64], NDArray[np.float32], NDArray[np.float32]]:
    """Cells along each axis, their sides in metres, and the box that kernels read: about so many cells, as even as
    `FEWEST` and `MOST` let them be."""
    extent = high - low
    counts = np.zeros(3)
    free = np.ones(3, bool)
    for _ in range(3):
        side = (np.prod(extent[free]) / (cells / np.prod(counts[~free]))) ** (1.0 / free.sum())
        counts[free] = np.clip(np.ceil(extent[free] / side), FEWEST, MOST)
        held = free & (counts == FEWEST)
        if not held.any() or not (free & ~held).any():
            break
        free &= ~held
    sides = extent / counts
    box = np.array([*(low + sides / 2), *(1.0 / sides), *counts, 0.5 * float(extent.mean())], np.float32)
    return counts.astype(np.int64), sides.astype(np.float32), box
