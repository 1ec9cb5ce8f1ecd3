"""Signed distances at the nodes of a grid."""

from __future__ import annotations

import numpy as np

from ...jit import device, parallel, prange
from ...simd import any_lane, broadcast, load, pointer, sqrt, store, where
from .packets import PacketTree, nearest, winding

SIDE = 4
"""Nodes along x and along y that a packet has: 4 × 4."""
SLACK = 1.0001
"""Factor by which bounds are widened for rounding."""
LARGE = 1e37


@parallel
def fill(boxes, child, counts, moments, rows, lanes, low, spacing, closed, out):
    """Write signed distances to out (by, bx, nz, 16) float32: of each column of 4 × 4 nodes and each height a packet.

    boxes, child, counts, moments, rows: a `PacketTree`; lanes: (2, 16) float32, where the nodes of a packet lie along x
    and y; low: (3,) float32, the first node; spacing: of nodes; closed: whether the mesh has no edge where its winding
    number changes.
    """
    for place in prange(out.shape[0] * out.shape[1]):
        task = np.int64(place)
        tree = PacketTree(boxes, child, counts, moments, rows)
        column(tree, lanes, low, spacing, closed, out[task // out.shape[1], task % out.shape[1]], task, out.shape[1])


@device
def column(tree, lanes, low, spacing, closed, out, task, columns):
    """Write the packets of a column, upward: distances change by no more than the spacing from one to the next, and a
    sign changes only where the surface is nearer than that."""
    left = low[0] + spacing * SIDE * (task % columns)
    front = low[1] + spacing * SIDE * (task // columns)
    x = load(pointer(lanes), 0) + left
    y = load(pointer(lanes), lanes.shape[1]) + front
    best = broadcast(x, LARGE)
    sign = broadcast(x, 1.0)
    before = broadcast(x, 0.0)
    half = 0.5 * spacing * (SIDE - 1)
    for k in range(out.shape[0]):
        z = low[2] + spacing * k
        best = nearest(tree, x, y, broadcast(x, z), (left + half, front + half, z), best)
        distance = sqrt(best)
        if not closed or any_lane(distance + before <= spacing * SLACK):
            around = winding(tree, x, y, broadcast(x, z))
            sign = where(around > 0.5, broadcast(x, -1.0), 1.0)
        store(pointer(out), k * lanes.shape[1], sign * distance)
        before = distance
        best = (distance + spacing) * (distance + spacing) * SLACK
