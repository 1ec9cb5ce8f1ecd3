"""A mesh as a shape of solid: `strandcli.scene.model.solids.SolidShape` by its tree of triangles and its grid of
distances. Numbers are the mesh's place in the data."""

from __future__ import annotations

import math

import numpy as np

from ...jit import device
from ...meshes.kernels.distance import distance_and_gradient, vector_distance_and_gradient
from ...meshes.kernels.nearest import apart, nearest, on_triangle, place
from ...meshes.kernels.rays import first_hit, first_hits
from ...simd import array_at
from .arrays import FACES, NORMALS, PAST, colour_at, grid_of, spacing_of, tree_of

CLOSE = 1e-3
"""Cells of the grid within which the point of the surface that is drawn is looked for first."""
LEAVES = 4.0
"""Way out of a surface that a shadow ray may have, in depths that count as on it."""
WITHIN = 1e-3
"""Share of a triangle from its edges within which the nearest triangle may be a neighbour."""
TINY = 1e-6
"""A gradient this short has no direction."""


def distance(x, y, z, numbers, data):
    """From the grid, whose error is of the order of the surface's bend over a cell."""
    return distance_and_gradient(grid_of(data, int(numbers[0])), x, y, z)[0]


def distances(x, y, z, numbers, data):
    """The same, of vectors."""
    return vector_distance_and_gradient(grid_of(data, int(numbers[0])), x, y, z)[0]


def slopes(x, y, z, numbers, data):
    """The same, and their gradients."""
    return vector_distance_and_gradient(grid_of(data, int(numbers[0])), x, y, z)


def bounds(numbers, data):
    """That of the grid, outside of which distances are no less than to it."""
    grid = grid_of(data, int(numbers[0]))
    x, y, z = grid.low[0], grid.low[1], grid.low[2]
    nz, ny, nx = grid.values.shape
    return (
        x, y, z,
        x + grid.spacing * np.float32(nx - 1), y + grid.spacing * np.float32(ny - 1),
        z + grid.spacing * np.float32(nz - 1),
    )  # fmt: skip


def normal(x, y, z, numbers, data):
    """The gradient of the grid's distances; where it has no direction, towards the nearest point of the surface or
    from there."""
    k = int(numbers[0])
    d, gx, gy, gz = distance_and_gradient(grid_of(data, k), x, y, z)
    if gx * gx + gy * gy + gz * gz > TINY:
        return 1.0 * gx, 1.0 * gy, 1.0 * gz
    tree = tree_of(data, k)
    square, _, u, v, row = nearest(tree, np.float64(x), np.float64(y), np.float64(z), np.inf)
    px, py, pz = place(tree.corners, row, u, v)
    side = -1.0 if d < 0 else 1.0
    if square > 0.0:
        return side * (x - px), side * (y - py), side * (z - pz)
    return 0.0, 1.0, 0.0


def meet(x, y, z, dx, dy, dz, numbers, data):
    """By the tree of triangles; both sides count."""
    return first_hit(tree_of(data, int(numbers[0])), x, y, z, dx, dy, dz, np.inf)[0]


def meets(rays, found, numbers, data):
    """The same of the rays of a pixel, together."""
    first_hits(tree_of(data, int(numbers[0])), rays, found)


def hides(x, y, z, dx, dy, dz, reach, skin, numbers, data):
    """Whether the mesh hides a light at ``reach`` along the unit vector d from a point that may be up to ``skin`` under
    its surface: a first triangle that the ray leaves the mesh through does not, where it is near."""
    k = int(numbers[0])
    tree = tree_of(data, k)
    t, i, _, _ = first_hit(tree, x, y, z, dx, dy, dz, reach)
    if i < 0:
        return False
    faces = array_at(np.float32, data.table[k, FACES], (len(tree.corners), 3))
    if t > LEAVES * skin or faces[i, 0] * dx + faces[i, 1] * dy + faces[i, 2] * dz <= 0.0:
        return True
    if distance_and_gradient(grid_of(data, k), x, y, z)[0] < -skin - spacing_of(data, k):
        return True
    t += CLOSE * skin
    return first_hit(tree, x + t * dx, y + t * dy, z + t * dz, dx, dy, dz, reach - t)[1] >= 0


def look(x, y, z, eye, width, before, numbers, data):
    """The smooth normal, the point lifted to where the smooth surface would be (Hanika 2021, "Hacking the shadow
    terminator"), the colour of vertices or of the texture, and the place of the triangle, from which the next point
    is looked for."""
    k = int(numbers[0])
    tree = tree_of(data, k)
    u, v, row = drawn(tree, np.float64(x), np.float64(y), np.float64(z), before, CLOSE * spacing_of(data, k))
    px, py, pz = place(tree.corners, row, u, v)
    normals = array_at(np.float32, data.table[k, NORMALS], (len(tree.corners), 3, 3))
    nx = ny = nz = lx = ly = lz = 0.0
    for corner in range(3):
        share = (u if corner == 1 else v) if corner > 0 else 1.0 - u - v
        ax, ay, az = normals[row, corner, 0], normals[row, corner, 1], normals[row, corner, 2]
        nx += share * ax
        ny += share * ay
        nz += share * az
        over = (px - tree.corners[row, corner, 0]) * ax + (py - tree.corners[row, corner, 1]) * ay
        over += (pz - tree.corners[row, corner, 2]) * az
        lx -= share * min(over, 0.0) * ax
        ly -= share * min(over, 0.0) * ay
        lz -= share * min(over, 0.0) * az
    if nx * nx + ny * ny + nz * nz < TINY:
        faces = array_at(np.float32, data.table[k, FACES], (len(tree.corners), 3))
        i = tree.triangle[row]
        nx, ny, nz = 1.0 * faces[i, 0], 1.0 * faces[i, 1], 1.0 * faces[i, 2]
    facing = (nx * eye[0] + ny * eye[1] + nz * eye[2]) / math.sqrt(nx * nx + ny * ny + nz * nz)
    colour = colour_at(data, k, row, u, v, width, facing)
    return (nx, ny, nz), (x + lx, y + ly, z + lz), colour, row


@device
def drawn(tree, x, y, z, before, limit):
    """u, v and the place of the triangle nearest to a point, which is looked for among all unless the point is on that
    at place `before`, not near its edges. limit: metres from the surface within which a point is on it."""
    if before >= 0:
        u, v = on_triangle(tree.corners, before, x, y, z)
        if min(min(u, v), 1.0 - u - v) > WITHIN and apart(tree.corners, before, u, v, x, y, z) < limit * limit:
            return u, v, before
    _, _, u, v, row = nearest(tree, np.float64(x), np.float64(y), np.float64(z), np.float64(limit * limit))
    if row < 0:
        _, _, u, v, row = nearest(tree, np.float64(x), np.float64(y), np.float64(z), np.inf)
    return u, v, np.int64(row)


def drift(x, y, z, numbers, data):
    """How far the nearest point of the triangles came since the step before; 0 where the mesh did not change."""
    k = int(numbers[0])
    if data.table[k, PAST] == 0:
        return 0.0, 0.0, 0.0
    tree = tree_of(data, k)
    limit = abs(distance_and_gradient(grid_of(data, k), x, y, z)[0]) + spacing_of(data, k)
    _, _, u, v, row = nearest(tree, np.float64(x), np.float64(y), np.float64(z), np.float64(limit * limit))
    if row < 0:
        _, _, u, v, row = nearest(tree, np.float64(x), np.float64(y), np.float64(z), np.inf)
    past = array_at(np.float64, data.table[k, PAST], (tree.corners.shape[0], 3, 3))
    ax, ay, az = place(past, row, u, v)
    bx, by, bz = place(tree.corners, row, u, v)
    return bx - ax, by - ay, bz - az
