"""Signed distance from a grid: linear between its nodes, and a lower bound outside of it."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...jit import device, inlined
from ...simd import floor, gather2, pointer, sqrt, where

TINY = np.float32(1e-30)


class DistanceGrid(NamedTuple):
    """Signed distances from a mesh at the nodes of a grid, negative inside.

    values: (nz, ny, nx) float32, units of the mesh; low: (3,) float32, x, y, z of node (0, 0, 0); spacing: of nodes,
    the same along all axes.
    """

    values: NDArray[np.float32]
    low: NDArray[np.float32]
    spacing: np.float32


@device
def within(at, count):
    """A coordinate, or a vector of them, counted in nodes, put within the grid; 0 for what is not a number, as lanes
    without a point may have it."""
    return min(max(np.float32(0), at), np.float32(count - 1))


@device
def distance_and_gradient(grid, x, y, z):
    """Signed distance of a point from the mesh, and its gradient: d, gx, gy, gz.

    Within the grid d is linear between its nodes, and the gradient is that of d; it is not of length 1, and is 0 where
    the surface on both sides is as near. Outside of the grid d is the hypotenuse of the distances to the grid and from
    there to the mesh, which is never more than the distance.
    """
    values, spacing = grid.values, grid.spacing
    nz, ny, nx = values.shape
    per = np.float32(1) / spacing
    u, v, w = (x - grid.low[0]) * per, (y - grid.low[1]) * per, (z - grid.low[2]) * per
    cu, cv, cw = within(u, nx), within(v, ny), within(w, nz)
    i, j, k = min(int(cu), nx - 2), min(int(cv), ny - 2), min(int(cw), nz - 2)
    u1, v1, w1 = cu - np.float32(i), cv - np.float32(j), cw - np.float32(k)
    a, b = values[k, j, i], values[k, j, i + 1]
    c, d = values[k, j + 1, i], values[k, j + 1, i + 1]
    e, f = values[k + 1, j, i], values[k + 1, j, i + 1]
    g, h = values[k + 1, j + 1, i], values[k + 1, j + 1, i + 1]
    ab, cd, ef, gh = a + u1 * (b - a), c + u1 * (d - c), e + u1 * (f - e), g + u1 * (h - g)
    below, above = ab + v1 * (cd - ab), ef + v1 * (gh - ef)
    near = below + w1 * (above - below)
    gx0, gx1 = (b - a) + v1 * ((d - c) - (b - a)), (f - e) + v1 * ((h - g) - (f - e))
    gx, gy = (gx0 + w1 * (gx1 - gx0)) * per, ((cd - ab) + w1 * ((gh - ef) - (cd - ab))) * per
    gz = (above - below) * per
    ox, oy, oz = (u - cu) * spacing, (v - cv) * spacing, (w - cw) * spacing
    out = ox * ox + oy * oy + oz * oz
    if out > 0.0:
        far = math.sqrt(out + near * near)
        scale = 1 / far
        gx = ox * scale if ox != 0.0 else gx * near * scale
        gy = oy * scale if oy != 0.0 else gy * near * scale
        gz = oz * scale if oz != 0.0 else gz * near * scale
        near = far
    return near, gx, gy, gz


@inlined
def vector_distance_and_gradient(grid, x, y, z):
    """`distance_and_gradient` of vectors of points."""
    values, spacing = grid.values, grid.spacing
    nz, ny, nx = values.shape
    per = np.float32(1) / spacing
    u, v, w = (x - grid.low[0]) * per, (y - grid.low[1]) * per, (z - grid.low[2]) * per
    cu, cv, cw = within(u, nx), within(v, ny), within(w, nz)
    i, j, k = (
        floor(min(cu, np.float32(nx - 2))),
        floor(min(cv, np.float32(ny - 2))),
        floor(min(cw, np.float32(nz - 2))),
    )
    u1, v1, w1 = cu - i, cv - j, cw - k
    numbers = pointer(values)
    row, slab = k * np.float32(ny) + j, nx * ny  # rows are counted exactly: there are less than 2^24
    a, b = gather2(numbers, 0, row, nx, i)
    c, d = gather2(numbers, nx, row, nx, i)
    e, f = gather2(numbers, slab, row, nx, i)
    g, h = gather2(numbers, slab + nx, row, nx, i)
    ab, cd, ef, gh = a + u1 * (b - a), c + u1 * (d - c), e + u1 * (f - e), g + u1 * (h - g)
    below, above = ab + v1 * (cd - ab), ef + v1 * (gh - ef)
    near = below + w1 * (above - below)
    gx0, gx1 = (b - a) + v1 * ((d - c) - (b - a)), (f - e) + v1 * ((h - g) - (f - e))
    gx, gy = (gx0 + w1 * (gx1 - gx0)) * per, ((cd - ab) + w1 * ((gh - ef) - (cd - ab))) * per
    gz = (above - below) * per
    ox, oy, oz = (u - cu) * spacing, (v - cv) * spacing, (w - cw) * spacing
    out = ox * ox + oy * oy + oz * oz
    beyond = out > np.float32(0)
    far = sqrt(out + near * near)
    scale = np.float32(1) / max(far, TINY)
    return (
        where(beyond, far, near), vector_slope(beyond, ox, gx, near, scale), vector_slope(beyond, oy, gy, near, scale),
        vector_slope(beyond, oz, gz, near, scale),
    )  # fmt: skip


@inlined
def vector_slope(beyond, over, slope, near, scale):
    """Return the gradient along an axis, where points beyond the grid are ``over`` its border along that."""
    outside = where(abs(over) > np.float32(0), over * scale, slope * near * scale)
    return where(beyond, outside, slope)
