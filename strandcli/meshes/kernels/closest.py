"""Nearest points of many points."""

from __future__ import annotations

import math

import numpy as np

from ...jit import device, parallel, prange
from . import nearest
from .winding import winding


@parallel
def closest(bvh, points, near, triangles, shares, distances):
    """Write of points (P, 3) the nearest ones of a mesh, near (P, 3), their triangles (P,), barycentric coordinates
    (P, 3) and signed distances (P,)."""
    for p in prange(points.shape[0]):
        one(bvh, points, p, near, triangles, shares, distances)


@device
def one(bvh, points, p, near, triangles, shares, distances):
    """`closest` of point p."""
    x, y, z = points[p, 0], points[p, 1], points[p, 2]
    squared, triangle, u, v, row = nearest.nearest(bvh, x, y, z, np.inf)
    near[p, 0], near[p, 1], near[p, 2] = nearest.place(bvh.corners, row, u, v)
    triangles[p] = triangle
    shares[p, 0], shares[p, 1], shares[p, 2] = 1.0 - u - v, u, v
    apart = math.sqrt(squared)
    distances[p] = -apart if winding(bvh, x, y, z) > 0.5 else apart
