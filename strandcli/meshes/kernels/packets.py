"""Signed distances at the nodes of a grid, sixteen at once, which walk a tree together.

Points of a packet are neighbours, so nearly all of them want the same nodes. In single precision, about the middle of
the mesh.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...jit import device, parallel, prange
from ...simd import any_lane, broadcast, load, pointer, sqrt, store, where
from ...simd.local import local_int32
from .nearest import BOX, box_distance
from .winding import winding

ROW = 28
"""Numbers of a triangle's row: corner a; edges b - a, c - b, a - c; one over their squared lengths; unit normal;
directions in the plane, from each edge inward; one of padding."""
A, AB, BC, CA, SHORT, NORMAL, IN_AB, IN_BC, IN_CA = 0, 3, 6, 9, 12, 15, 18, 21, 24


class PacketTree(NamedTuple):
    """A tree as packets walk it, in single precision, moved so that the middle of the mesh is the origin.

    boxes: (N, 6), rounded outward; child, counts: (N,) int32, as of `Bvh`; rows: (T, 28) of triangles in tree order.
    """

    boxes: NDArray[np.float32]
    child: NDArray[np.int32]
    counts: NDArray[np.int32]
    rows: NDArray[np.float32]


@device
def dot(rows, o, x, y, z):
    """Scalar product of the vector at place o with vectors of lanes."""
    return rows[o] * x + rows[o + 1] * y + rows[o + 2] * z


@device
def edge_distance(rows, edge, short, x, y, z):
    """Squared distance of points from an edge at the origin."""
    t = min(max(dot(rows, edge, x, y, z) * rows[short], 0.0), 1.0)
    x = x - t * rows[edge]
    y = y - t * rows[edge + 1]
    z = z - t * rows[edge + 2]
    return x * x + y * y + z * z


@device
def triangle_distance(rows, o, x, y, z):
    """Squared distance of points from the triangle whose row begins at o: from its plane where they are above it, else
    from its nearest edge."""
    ax, ay, az = x - rows[o + A], y - rows[o + A + 1], z - rows[o + A + 2]
    bx, by, bz = ax - rows[o + AB], ay - rows[o + AB + 1], az - rows[o + AB + 2]
    cx, cy, cz = ax + rows[o + CA], ay + rows[o + CA + 1], az + rows[o + CA + 2]
    above = dot(rows, o + NORMAL, ax, ay, az)
    inside = dot(rows, o + IN_AB, ax, ay, az) > 0.0
    inside = inside & (dot(rows, o + IN_BC, bx, by, bz) > 0.0) & (dot(rows, o + IN_CA, cx, cy, cz) > 0.0)
    edges = min(
        min(edge_distance(rows, o + AB, o + SHORT, ax, ay, az), edge_distance(rows, o + BC, o + SHORT + 1, bx, by, bz)),
        edge_distance(rows, o + CA, o + SHORT + 2, cx, cy, cz),
    )
    return where(inside, above * above, edges)


@device
def nearest(tree, x, y, z, middle, best):
    """Squared distances of points from the mesh, where they are less than `best`, else that; middle: (x, y, z) of the
    packet."""
    boxes, rows = pointer(tree.boxes), pointer(tree.rows)
    nodes = local_int32()
    nodes[0] = 0
    waiting = 1
    while waiting > 0:
        waiting -= 1
        node = nodes[waiting]
        if not any_lane(box_distance(boxes, node * BOX, x, y, z) < best):
            continue
        if tree.counts[node] > 0:
            for i in range(tree.child[node], tree.child[node] + tree.counts[node]):
                best = min(best, triangle_distance(rows, i * ROW, x, y, z))
        else:
            first, second = node + 1, tree.child[node]
            near = box_distance(boxes, first * BOX, middle[0], middle[1], middle[2])
            far = box_distance(boxes, second * BOX, middle[0], middle[1], middle[2])
            if far < near:
                first, second = second, first
            nodes[waiting] = second
            nodes[waiting + 1] = first
            waiting += 2
    return best


SIDE = 4
"""Nodes along x and along y that a packet has: 4 × 4."""
SLACK = 1.0001
"""Factor by which bounds are widened for rounding."""
LARGE = 1e37


@parallel
def fill(bvh, tree, lanes, low, middle, spacing, closed, out):
    """Write signed distances to out (by, bx, nz, 16) float32: of each column of 4 × 4 nodes and each height a packet.

    bvh, tree: a mesh's, the latter about middle (3,); lanes: (2, 16) float32, where the nodes of a packet lie along x
    and y; low: (3,) float32, the first node, from there; spacing: of nodes; closed: whether the mesh has no edge where
    its winding number changes.
    """
    for place in prange(out.shape[0] * out.shape[1]):
        task = np.int64(place)
        packets = out[task // out.shape[1], task % out.shape[1]]
        column(bvh, tree, lanes, low, middle, spacing, closed, packets, task, out.shape[1])


@device
def column(bvh, tree, lanes, low, middle, spacing, closed, out, task, columns):
    """Write the packets of a column, upward: distances change by no more than the spacing from one to the next, and a
    sign changes only where the surface is nearer than that."""
    left = low[0] + spacing * SIDE * (task % columns)
    front = low[1] + spacing * SIDE * (task // columns)
    x = load(pointer(lanes), 0) + left
    y = load(pointer(lanes), lanes.shape[1]) + front
    best = broadcast(x, LARGE)
    before = broadcast(x, 0.0)
    half = 0.5 * spacing * (SIDE - 1)
    for k in range(out.shape[0]):
        z = low[2] + spacing * k
        best = nearest(tree, x, y, broadcast(x, z), (left + half, front + half, z), best)
        distance = sqrt(best)
        store(pointer(out), k * lanes.shape[1], distance)
        asked = k == 0 or not closed or any_lane(distance + before <= spacing * SLACK)
        for lane in range(lanes.shape[1]):
            if asked:
                px, py = lanes[0, lane] + left + middle[0], lanes[1, lane] + front + middle[1]
                inside = winding(bvh, px, py, z + middle[2]) > 0.5
            else:
                inside = math.copysign(1.0, out[k - 1, lane]) < 0.0
            if inside:
                out[k, lane] = -out[k, lane]
        before = distance
        best = (distance + spacing) * (distance + spacing) * SLACK
