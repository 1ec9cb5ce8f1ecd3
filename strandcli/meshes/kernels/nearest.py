"""The point of a mesh that is nearest to another one, or to each of many."""

from __future__ import annotations

import math

import numpy as np

from ...jit import device, parallel, prange
from ...simd import pointer
from ...simd.local import local_float64, local_int32
from .winding import winding

BOX = 6
"""Numbers of a box."""


@device
def box_distance(boxes, o, x, y, z):
    """Squared distance from the box that begins at o; 0 within. Of lanes or of plain numbers."""
    dx = max(max(boxes[o] - x, x - boxes[o + 3]), 0.0)
    dy = max(max(boxes[o + 1] - y, y - boxes[o + 4]), 0.0)
    dz = max(max(boxes[o + 2] - z, z - boxes[o + 5]), 0.0)
    return dx * dx + dy * dy + dz * dz


@device
def dot(ax, ay, az, bx, by, bz):
    """Scalar product."""
    return ax * bx + ay * by + az * bz


@device
def on_triangle(corners, i, x, y, z):
    """u, v of the point a + u (b - a) + v (c - a) of triangle i that is nearest to a point (Ericson 2004, "Real-time
    collision detection", 5.1.5). Triangles without area give a point of one of their edges."""
    ax, ay, az = corners[i, 0, 0], corners[i, 0, 1], corners[i, 0, 2]
    ux, uy, uz = corners[i, 1, 0] - ax, corners[i, 1, 1] - ay, corners[i, 1, 2] - az
    vx, vy, vz = corners[i, 2, 0] - ax, corners[i, 2, 1] - ay, corners[i, 2, 2] - az
    px, py, pz = x - ax, y - ay, z - az
    d1, d2 = dot(ux, uy, uz, px, py, pz), dot(vx, vy, vz, px, py, pz)
    if d1 <= 0.0 and d2 <= 0.0:
        return 0.0, 0.0
    qx, qy, qz = px - ux, py - uy, pz - uz
    d3, d4 = dot(ux, uy, uz, qx, qy, qz), dot(vx, vy, vz, qx, qy, qz)
    if d3 >= 0.0 and d4 <= d3:
        return 1.0, 0.0
    rx, ry, rz = px - vx, py - vy, pz - vz
    d5, d6 = dot(ux, uy, uz, rx, ry, rz), dot(vx, vy, vz, rx, ry, rz)
    if d6 >= 0.0 and d5 <= d6:
        return 0.0, 1.0
    of_c = d1 * d4 - d3 * d2
    if of_c <= 0.0 and d1 >= 0.0 and d3 <= 0.0 and d1 > d3:
        return d1 / (d1 - d3), 0.0
    of_b = d5 * d2 - d1 * d6
    if of_b <= 0.0 and d2 >= 0.0 and d6 <= 0.0 and d2 > d6:
        return 0.0, d2 / (d2 - d6)
    of_a = d3 * d6 - d5 * d4
    if of_a <= 0.0 and d4 >= d3 and d5 >= d6 and (d4 - d3) + (d5 - d6) > 0.0:
        share = (d4 - d3) / ((d4 - d3) + (d5 - d6))
        return 1.0 - share, share
    whole = of_a + of_b + of_c
    if not whole > 0.0:
        return 0.0, 0.0
    return of_b / whole, of_c / whole


@device
def place(corners, i, u, v):
    """The point a + u (b - a) + v (c - a) of triangle i."""
    ax, ay, az = corners[i, 0, 0], corners[i, 0, 1], corners[i, 0, 2]
    return (
        ax + u * (corners[i, 1, 0] - ax) + v * (corners[i, 2, 0] - ax),
        ay + u * (corners[i, 1, 1] - ay) + v * (corners[i, 2, 1] - ay),
        az + u * (corners[i, 1, 2] - az) + v * (corners[i, 2, 2] - az),
    )


@device
def apart(corners, i, u, v, x, y, z):
    """Squared distance of a point from the point u, v of triangle i."""
    px, py, pz = place(corners, i, u, v)
    return (px - x) ** 2 + (py - y) ** 2 + (pz - z) ** 2


@device
def nearest(bvh, x, y, z, limit):
    """The nearest point of a mesh: squared distance, number of its triangle in the mesh, u, v, and the triangle's place
    in tree order. Where nothing is nearer than `limit`, a squared distance, that is infinite and the numbers -1.

    All of them float64. The point is a + u (b - a) + v (c - a). Of triangles that are as near the lowest number.
    """
    nodes, distances, boxes = local_int32(), local_float64(), pointer(bvh.boxes)
    best, best_u, best_v, hit, row = limit, 0.0, 0.0, -1, -1
    node, waiting, entry = 0, 0, np.float64(0.0)
    while True:
        if entry <= best:
            if bvh.counts[node] > 0:
                for i in range(bvh.child[node], bvh.child[node] + bvh.counts[node]):
                    u, v = on_triangle(bvh.corners, i, x, y, z)
                    d = apart(bvh.corners, i, u, v, x, y, z)
                    if d < best or (d == best and hit >= 0 and bvh.triangle[i] < hit):
                        best, best_u, best_v, hit, row = d, u, v, bvh.triangle[i], i
            else:
                first, second = node + 1, bvh.child[node]
                near = box_distance(boxes, first * BOX, x, y, z)
                far = box_distance(boxes, second * BOX, x, y, z)
                if far < near:
                    first, second, near, far = second, first, far, near
                if far <= best:
                    nodes[waiting], distances[waiting] = second, far
                    waiting += 1
                if near <= best:
                    node, entry = first, near
                    continue
        if waiting == 0:
            break
        waiting -= 1
        node, entry = nodes[waiting], distances[waiting]
    return (best if hit >= 0 else np.inf), hit, best_u, best_v, row


@parallel
def closest(bvh, points, near, triangles, shares, distances):
    """Write of points (P, 3) the nearest ones of a mesh, near (P, 3), their triangles (P,), barycentric coordinates
    (P, 3) and signed distances (P,)."""
    for p in prange(points.shape[0]):
        one(bvh, points, p, near, triangles, shares, distances)


@device
def one(bvh, points, p, near, triangles, shares, distances):
    """`closest` of point p."""
    x, y, z = np.float64(points[p, 0]), np.float64(points[p, 1]), np.float64(points[p, 2])
    squared, triangle, u, v, row = nearest(bvh, x, y, z, np.inf)
    near[p, 0], near[p, 1], near[p, 2] = place(bvh.corners, row, u, v)
    triangles[p] = triangle
    shares[p, 0], shares[p, 1], shares[p, 2] = 1.0 - u - v, u, v
    apart = math.sqrt(squared)
    distances[p] = -apart if winding(bvh, x, y, z) > 0.5 else apart
