"""The arrays of meshes, as kernels read them: a table of their addresses.

A kernel that took each array by itself would hand on a hundred numbers in every call; that takes longer than to look up
a distance, to run and to compile.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...jit import device
from ...jit.indices import FIRST, SECOND, THIRD
from ...meshes.kernels.distance import DistanceGrid
from ...meshes.kernels.tree import Bvh
from ...simd import array_at

(
    LOW, VALUES, NZ, NY, NX, NODES, BOXES, CHILD, COUNTS, TRIANGLES, CORNERS, TRIANGLE, FACES, NORMALS, COLOURS, UV,
    DENSITY, TEXEL_COUNT, TEXELS, LEVEL_COUNT, LEVELS, LINEAR, PAST,
) = range(23)  # fmt: skip
"""Columns of the table: addresses of arrays, and their lengths, `NODES`, `TRIANGLES`, `TEXEL_COUNT`, `LEVEL_COUNT`,
`NZ`, `NY` and `NX`. An array that a mesh does not have is at 0.

LOW: (4,) float32, the first node of the grid, and the spacing of nodes, metres. VALUES: (NZ, NY, NX) float32, signed
distances at the nodes, metres. PAST: (`TRIANGLES`, 3, 3) float64, the corners at the step before, where they were
others. BOXES, CHILD, COUNTS, CORNERS, TRIANGLE: as in `strandcli.meshes.kernels.tree.Bvh`. FACES, NORMALS, COLOURS,
UV, DENSITY: as in `strandcli.mesh_file.prepared.Prepared`.
"""
SIZE = 23


class Data(NamedTuple):
    """Prepared meshes, as `shape` reads them. Solids may share one."""

    table: NDArray[np.int64]
    """(solids, `SIZE`) of each solid; it keeps the arrays."""


class Texture(NamedTuple):
    """A picture in levels."""

    texels: NDArray[np.uint8]
    """(n, 3) sRGB of all levels."""
    levels: NDArray[np.int64]
    """(L, 3) the first texel of a level, its width and its height."""
    linear: NDArray[np.float32]
    """(256,) linear light of codes of sRGB."""


@device
def grid_of(data, k):
    """The grid of distances of mesh k."""
    row = data.table[k]
    low = array_at(np.float32, row[LOW], (4,))
    return DistanceGrid(array_at(np.float32, row[VALUES], (row[NZ], row[NY], row[NX])), low, low[3])


@device
def spacing_of(data, k):
    """The spacing of the grid's nodes of mesh k, metres."""
    return array_at(np.float32, data.table[k, LOW], (4,))[3]


@device
def tree_of(data, k):
    """The tree of triangles of mesh k; it has no moments."""
    row = data.table[k]
    nodes, triangles = row[NODES], row[TRIANGLES]
    corners = array_at(np.float64, row[CORNERS], (triangles, 3, 3))
    return Bvh(
        array_at(np.float32, row[BOXES], (nodes, 6)), array_at(np.int32, row[CHILD], (nodes,)),
        array_at(np.int32, row[COUNTS], (nodes,)), corners, array_at(np.int32, row[TRIANGLE], (triangles,)),
        corners[:, 0],
    )  # fmt: skip


@device
def texture_of(data, k):
    """The texture of mesh k."""
    row = data.table[k]
    return Texture(
        array_at(np.uint8, row[TEXELS], (row[TEXEL_COUNT], 3)), array_at(np.int64, row[LEVELS], (row[LEVEL_COUNT], 3)),
        array_at(np.float32, row[LINEAR], (256,)),
    )  # fmt: skip


ONE = np.float32(1.0)
HALF = np.float32(0.5)
SLANT = 0.1
"""Least cosine to the eye at which a pixel's width on the surface still grows."""
NONE = (np.float32(-1.0), np.float32(-1.0), np.float32(-1.0))
"""The solid's own colour."""


@device
def colour_at(data, k, row, u, v, width, facing):
    """Linear colour of the point u, v of triangle ``row`` of mesh k; negative where it has no colours.

    width: of a pixel, metres; facing: cosine between the normal and the eye, by whose root a pixel is wider.
    """
    if data.table[k, COLOURS] != 0:
        colours = array_at(np.float32, data.table[k, COLOURS], (data.table[k, TRIANGLES], 3, 3))
        return mixed(colours, row, FIRST, u, v), mixed(colours, row, SECOND, u, v), mixed(colours, row, THIRD, u, v)
    if data.table[k, UV] != 0:
        uv = array_at(np.float32, data.table[k, UV], (data.table[k, TRIANGLES], 3, 2))
        density = array_at(np.float32, data.table[k, DENSITY], (data.table[k, TRIANGLES],))
        texels = width * density[row] / math.sqrt(max(facing, SLANT))
        s, t = mixed(uv, row, FIRST, u, v), mixed(uv, row, SECOND, u, v)
        return texture_at(texture_of(data, k), s, t, np.float32(texels))
    return NONE


@device
def mixed(corners, row, c, u, v):
    """Coordinate c of a triangle's corners, interpolated."""
    a = corners[row, 0, c]
    return np.float32(a + u * (corners[row, 1, c] - a) + v * (corners[row, 2, c] - a))


@device
def texture_at(texture, s, t, texels):
    """Linear colour of a texture at (s, t), of which the origin is at the lower left, over so many texels."""
    last = texture.levels.shape[0] - 1
    level = 0
    while texels > ONE + ONE and level < last:
        texels *= HALF
        level += 1
    r, g, b = bilinear(texture, level, s, t)
    if texels > ONE and level < last:
        share = texels - ONE
        x, y, z = bilinear(texture, level + 1, s, t)
        r, g, b = r + share * (x - r), g + share * (y - g), b + share * (z - b)
    return r, g, b


@device
def bilinear(texture, level, s, t):
    """Linear colour of a level of the texture, interpolated; the picture repeats."""
    texels, levels, linear = texture
    wide, high = levels[level, 1], levels[level, 2]
    x = (s - np.floor(s)) * np.float32(wide) - HALF
    y = (ONE - (t - np.floor(t))) * np.float32(high) - HALF
    i, j = int(np.floor(x)), int(np.floor(y))
    p, q = x - np.float32(i), y - np.float32(j)
    left, right = (i + wide) % wide, (i + 1) % wide
    base = levels[level, 0]
    above, below = base + (j + high) % high * wide, base + (j + 1) % high * wide
    return (
        between(texels, linear, above + left, above + right, below + left, below + right, FIRST, p, q),
        between(texels, linear, above + left, above + right, below + left, below + right, SECOND, p, q),
        between(texels, linear, above + left, above + right, below + left, below + right, THIRD, p, q),
    )


@device
def between(texels, linear, a, b, c, d, channel, p, q):
    """Light between four texels."""
    upper, lower = linear[texels[a, channel]], linear[texels[c, channel]]
    upper += p * (linear[texels[b, channel]] - upper)
    lower += p * (linear[texels[d, channel]] - lower)
    return upper + q * (lower - upper)
