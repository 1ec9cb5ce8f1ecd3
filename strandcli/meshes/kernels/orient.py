"""Which triangles hang together, and which way round they are wound."""

from __future__ import annotations

from ...jit import function


@function
def orient(neighbours, opposed, part, turned, queue):
    """The number of parts of a mesh. Triangles are gone through from neighbour to neighbour, and turned where that
    makes them agree.

    neighbours: (T, 3) int32, the triangle across each edge, negative of none; opposed: (T, 3), whether it is wound the
    opposite way;
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
