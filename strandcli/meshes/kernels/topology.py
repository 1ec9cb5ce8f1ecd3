"""Which triangles hang together, and which way round they are wound."""

from __future__ import annotations

from ...jit import device, function

ALONE, CROWDED = -1, -2
"""In place of a neighbour, of an edge of one triangle alone, and of one of three or more."""


@device
def root(parent, i):
    """The lowest of the items that i hangs together with, so far; paths to it become shorter."""
    while parent[i] != i:
        parent[i] = parent[parent[i]]
        i = parent[i]
    return i


@function
def rings(triangles, neighbours, parent):
    """The number of rings, of edges that hang together by vertices, among those of one triangle alone.

    triangles: (T, 3) int32; neighbours: (T, 3) int32, as of `meet`; parent: (V,) int32 scratch.
    """
    parent[:] = -1
    count = 0
    for t in range(triangles.shape[0]):
        for k in range(3):
            if neighbours[t, k] == ALONE:
                a, b = triangles[t, k], triangles[t, (k + 1) % 3]
                for vertex in (a, b):
                    if parent[vertex] < 0:
                        parent[vertex] = vertex
                        count += 1
                a, b = root(parent, a), root(parent, b)
                if a != b:
                    parent[max(a, b)] = min(a, b)
                    count -= 1
    return count


@function
def orient(neighbours, opposed, part, turned, queue):
    """The number of parts of a mesh. Triangles are gone through from neighbour to neighbour, and turned where that
    makes them agree.

    neighbours: (T, 3) int32, the triangle across each edge, negative of none; opposed: (T, 3), whether it is wound the
    other way;
    part: (T,) int32, of -1, becomes the number of its part; turned: (T,), becomes whether it has to be turned;
    queue: (T,) int32 scratch.
    """
    parts = 0
    for seed in range(part.shape[0]):
        if part[seed] >= 0:
            continue
        part[seed] = parts
        turned[seed] = False
        queue[0] = seed
        begin, end = 0, 1
        while begin < end:
            t = queue[begin]
            begin += 1
            for k in range(3):
                other = neighbours[t, k]
                if other >= 0 and part[other] < 0:
                    part[other] = parts
                    turned[other] = turned[t] != opposed[t, k]
                    queue[end] = other
                    end += 1
        parts += 1
    return parts


@device
def lower_end(triangles, half):
    """The lower vertex of a half edge, which goes from corner half % 3 of triangle half // 3 to the next corner."""
    return min(triangles[half // 3, half % 3], triangles[half // 3, (half + 1) % 3])


@device
def upper_end(triangles, half):
    """The higher vertex of a half edge."""
    return max(triangles[half // 3, half % 3], triangles[half // 3, (half + 1) % 3])


@device
def forward(triangles, half):
    """Whether a half edge goes from its lower vertex."""
    return triangles[half // 3, half % 3] < triangles[half // 3, (half + 1) % 3]


@device
def end_of_edge(triangles, order, begin):
    """Where the half edges of an edge end, which begin there in their order."""
    low, high = lower_end(triangles, order[begin]), upper_end(triangles, order[begin])
    end = begin + 1
    while end < order.shape[0] and lower_end(triangles, order[end]) == low and upper_end(triangles, order[end]) == high:
        end += 1
    return end


@function
def order_edges(triangles, begins, scratch, order):
    """Write the half edges (3 T,) int32 in the order of their edges: by the lower vertex, then by the higher, then as
    they are. Two sorts by counting, which keep what the first one ordered.

    triangles: (T, 3) int32; begins: (V + 1,) int32 scratch; scratch: (3 T,) int32.
    """
    for key in range(2):
        begins[:] = 0
        for half in range(order.shape[0]):
            begins[1 + (upper_end(triangles, half) if key == 0 else lower_end(triangles, half))] += 1
        for vertex in range(begins.shape[0] - 1):
            begins[vertex + 1] += begins[vertex]
        for k in range(order.shape[0]):
            half = k if key == 0 else scratch[k]
            vertex = upper_end(triangles, half) if key == 0 else lower_end(triangles, half)
            if key == 0:
                scratch[begins[vertex]] = half
            else:
                order[begins[vertex]] = half
            begins[vertex] += 1


@function
def meet(triangles, order, neighbours, opposed):
    """The number of edges of three triangles or more. Writes who meets across edges of two.

    triangles: (T, 3) int32; order: (3 T,) int32, as of `order_edges`; neighbours: (T, 3) int32, the triangle across
    each edge, `ALONE` or `CROWDED` where there is none or are several; opposed: (T, 3) bool, whether it is wound the
    other way.
    """
    crowded, begin = 0, 0
    while begin < order.shape[0]:
        end = end_of_edge(triangles, order, begin)
        for k in range(begin, end):
            t, side = order[k] // 3, order[k] % 3
            neighbours[t, side], opposed[t, side] = ALONE if end - begin == 1 else CROWDED, False
            if end - begin == 2:
                other = order[begin + end - 1 - k]
                neighbours[t, side] = other // 3
                opposed[t, side] = forward(triangles, order[k]) == forward(triangles, other)
        crowded += end - begin > 2
        begin = end
    return crowded


@function
def balanced(triangles, order, turned):
    """Whether every edge is gone along as often in one direction as in the other; arguments as of `meet`, and
    turned: (T,) bool, triangles that are wound the other way than they stand there."""
    begin = 0
    while begin < order.shape[0]:
        end, sum = end_of_edge(triangles, order, begin), 0
        for k in range(begin, end):
            sum += 1 if forward(triangles, order[k]) != turned[order[k] // 3] else -1
        if sum != 0:
            return False
        begin = end
    return True
