"""The arrays of meshes, and the columns of their table, which tells where the parts of each begin and end."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

NODES, NODES_END = 0, 1
TRIANGLES, TRIANGLES_END = 2, 3
VALUES, VALUES_END = 4, 5
"""Distances of its grid."""
COLOURS, COLOURS_END = 6, 7
UV, UV_END = 8, 9
TEXELS, TEXELS_END = 10, 11
LEVELS, LEVELS_END = 12, 13
NZ, NY, NX = 14, 15, 16
"""Nodes of its grid along each axis."""
SIZE = 17


class Data(NamedTuple):
    """Prepared meshes, as `shape` reads them. Those that several solids share are there once."""

    table: NDArray[np.int64]
    """(solids, `SIZE`) where the parts of each begin."""
    low: NDArray[np.float32]
    """(solids, 4) the first node of its grid, and the spacing of nodes, metres."""
    boxes: NDArray[np.float32]
    """(N, 6) `strandcli.meshes.kernels.tree.Bvh`, also the next four."""
    child: NDArray[np.int32]
    counts: NDArray[np.int32]
    corners: NDArray[np.float64]
    triangle: NDArray[np.int32]
    faces: NDArray[np.float32]
    """(T, 3) unit normals of triangles, as the file has them in order."""
    normals: NDArray[np.float32]
    """(T, 3, 3) of corners, of triangles in the trees' order, as those below."""
    colours: NDArray[np.float32]
    """(T, 3, 3) linear; rows for meshes that have them."""
    uv: NDArray[np.float32]
    """(T, 3, 2); rows for meshes with a texture, as `density`."""
    density: NDArray[np.float32]
    """(T,) texels a metre."""
    texels: NDArray[np.uint8]
    """(n, 3) sRGB of all levels of textures."""
    levels: NDArray[np.int64]
    """(L, 3) first texel of a level among those of its texture, its width and its height."""
    linear: NDArray[np.float32]
    """(256,) linear light of codes of sRGB."""
    values: NDArray[np.float32]
    """(G,) signed distances at the nodes of grids, z the slowest, metres."""
