"""A bounding volume hierarchy of triangles: what it consists of, how it is built, and how it follows moved corners.

Binned surface area heuristic (Wald 2007, "On fast construction of SAH-based bounding volume hierarchies"). One thread
builds, so nothing depends on how many there are.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...jit import device, function

BINS = 16
LEAF = 4
"""Triangles of a leaf, at most."""
BALANCED = 48
"""Depth from which nodes are halved by number, so that the depth stays below the places of a stack: 48 + 31 levels."""
LEAST, LARGE = np.float32(1e-30), np.float32(np.inf)
"""A width over which `BINS` is finite; and more than any."""
NODE, BEGIN, END, PARENT, DEPTH = range(5)
"""Columns of the nodes that are still to be made; `NODE` is not used."""


class Bvh(NamedTuple):
    """A binary tree of boxes over the triangles of a mesh. Nodes stand in the order of a walk that takes the first
    child first, so that the first child of a node is the next one.

    boxes: (N, 6) float32, low and high corners, rounded outward; units of the mesh.
    child: (N,) int32, of an inner node its second child; of a leaf the first of its triangles in tree order.
    counts: (N,) int32, triangles of a leaf, at most 4; 0 of an inner node.
    corners: (T, 3, 3) float64, of each triangle in tree order its corners.
    triangle: (T,) int32, of each triangle in tree order its number in the mesh.
    moments: (N, 8) float64, of each node what winding numbers take of it; columns in `winding`.
    """

    boxes: NDArray[np.float32]
    child: NDArray[np.int32]
    counts: NDArray[np.int32]
    corners: NDArray[np.float64]
    triangle: NDArray[np.int32]
    moments: NDArray[np.float64]


@device
def area(box):
    """Half the surface of a box (6,)."""
    x, y, z = box[3] - box[0], box[4] - box[1], box[5] - box[2]
    return x * y + y * z + z * x


@device
def clear(box):
    """Make a box (6,) that holds nothing."""
    for k in range(3):
        box[k] = LARGE
        box[3 + k] = -LARGE


@device
def widen(box, other):
    """Let a box hold another one too."""
    for k in range(3):
        box[k] = min(box[k], other[k])
        box[3 + k] = max(box[3 + k], other[3 + k])


@device
def bin_of(box, k, low, scale):
    """The bin along axis k, of `BINS`, in which twice the middle of a triangle's box lies."""
    return max(min(int((box[k] + box[3 + k] - low) * scale), BINS - 1), 0)


@device
def best_split(boxes, order, begin, end, middle, bins, counts):
    """The axis and the first bin of the second child at the least cost, and that cost; axis -1 where all centres
    are the same. middle: (6,) box of the doubled centres; bins: (BINS, 6), counts: (BINS,) scratch."""
    cost, axis, place = LARGE, -1, 0
    for k in range(3):
        wide = middle[3 + k] - middle[k]
        if not wide > LEAST:
            continue
        scale = np.float32(BINS) / wide
        for b in range(BINS):
            clear(bins[b])
            counts[b] = 0
        for i in range(begin, end):
            b = bin_of(boxes[order[i]], k, middle[k], scale)
            widen(bins[b], boxes[order[i]])
            counts[b] += 1
        cost, axis, place = sweep(bins, counts, k, cost, axis, place)
    return axis, place, cost


@device
def sweep(bins, counts, k, cost, axis, place):
    """The cheapest split among those known and those between the bins of axis k. Rows of `bins` from `BINS` on are
    scratch: the box of all bins from one on."""
    clear(bins[BINS + BINS])  # above the last bin there is nothing
    for b in range(BINS - 1, 0, -1):
        above = bins[BINS + b]
        clear(above)
        widen(above, bins[BINS + b + 1])
        widen(above, bins[b])
        counts[BINS + b] = counts[b] + (counts[BINS + b + 1] if b < BINS - 1 else 0)
    below = bins[BINS]
    clear(below)
    number = 0
    for b in range(1, BINS):
        widen(below, bins[b - 1])
        number += counts[b - 1]
        after = counts[BINS + b]
        if number > 0 and after > 0:
            found = area(below) * np.float32(number) + area(bins[BINS + b]) * np.float32(after)
            if found < cost:
                cost, axis, place = found, k, b
    return cost, axis, place


@device
def partition(boxes, order, spare, begin, end, axis, place, middle):
    """Put the triangles of the first child before those of the second, each in the order they had; returns where the
    second begins."""
    scale = np.float32(BINS) / (middle[3 + axis] - middle[axis])
    low, high = begin, 0
    for i in range(begin, end):
        one = order[i]
        if bin_of(boxes[one], axis, middle[axis], scale) < place:
            order[low] = one
            low += 1
        else:
            spare[high] = one
            high += 1
    for i in range(high):
        order[low + i] = spare[i]
    return low


@function
def build(boxes, order, spare, bvh, tasks, bins, counts):
    """The number of nodes of the tree, which is written into `bvh`.

    boxes: (T, 6) float32 of triangles; order: (T,) int32, 0 to T - 1, becomes the tree's; spare: (T,) int32 scratch;
    bvh: arrays for 2 T - 1 nodes; tasks: (128, 5) int32, bins: (2 BINS + 2, 6) float32, counts: (2 BINS,) int32
    scratch.
    """
    middle = bins[2 * BINS + 1]
    tasks[0, BEGIN], tasks[0, END], tasks[0, PARENT], tasks[0, DEPTH] = 0, boxes.shape[0], -1, 0
    waiting, nodes = 1, 0
    while waiting > 0:
        waiting -= 1
        begin, end, depth = tasks[waiting, BEGIN], tasks[waiting, END], tasks[waiting, DEPTH]
        if tasks[waiting, PARENT] >= 0:
            bvh.child[tasks[waiting, PARENT]] = nodes
        box = bvh.boxes[nodes]
        clear(box)
        clear(middle)
        for i in range(begin, end):
            one = boxes[order[i]]
            widen(box, one)
            for k in range(3):
                centre = one[k] + one[3 + k]
                middle[k], middle[3 + k] = min(middle[k], centre), max(middle[3 + k], centre)
        count = end - begin
        axis, place, cost = -1, 0, LARGE
        if count > 1 and depth < BALANCED:
            axis, place, cost = best_split(boxes, order, begin, end, middle, bins, counts)
        if count <= LEAF and not (axis >= 0 and cost + area(box) < area(box) * np.float32(count)):
            bvh.child[nodes], bvh.counts[nodes] = begin, count
            nodes += 1
            continue
        cut = begin + count // 2
        if axis >= 0:
            cut = partition(boxes, order, spare, begin, end, axis, place, middle)
        bvh.counts[nodes] = 0
        for second in range(1, -1, -1):  # the first child is taken next
            tasks[waiting, BEGIN] = cut if second else begin
            tasks[waiting, END] = end if second else cut
            tasks[waiting, PARENT] = nodes if second else -1
            tasks[waiting, DEPTH] = depth + 1
            waiting += 1
        nodes += 1
    return nodes


@function
def refit(boxes, bvh):
    """Make the boxes of a tree's nodes those of moved triangles; boxes: (T, 6) float32 in tree order."""
    for node in range(bvh.boxes.shape[0] - 1, -1, -1):
        box = bvh.boxes[node]
        clear(box)
        if bvh.counts[node] > 0:
            for i in range(bvh.child[node], bvh.child[node] + bvh.counts[node]):
                widen(box, boxes[i])
        else:
            widen(box, bvh.boxes[node + 1])
            widen(box, bvh.boxes[bvh.child[node]])
