"""The order of parts of strands on a light's map, and bands of its rows with as much to draw (see `map_parts`)."""

from __future__ import annotations

import numpy as np

from ....jit import device, function
from .map_parts import BOTTOM, COUNT, TOP


@function
def sort(found, places, costs, begin, loads, order, borders):
    """Write the parts that are there in their order, and borders of bands with about the same cost; return how many
    parts there are.

    found, places, costs: from `part_vertices.thin`, the last without rows where there is one band; begin (tiles + 1,)
    int64 and loads (rows,) float64: changed; order (R, 4), borders (threads + 1,) out: of `PartsInMap`.
    """
    begin[:] = 0
    loads[:] = 0.0
    whole = 0.0
    for part in range(found.shape[0]):
        if found[part, COUNT] > 0:
            begin[np.int64(places[part]) + 1] += 1
            if costs.shape[0] > 0:
                loads[(found[part, TOP] + found[part, BOTTOM]) >> 1] += costs[part]
                whole += costs[part]
    for tile in range(1, begin.shape[0]):
        begin[tile] += begin[tile - 1]
    for part in range(found.shape[0]):
        if found[part, COUNT] > 0:
            k = begin[np.int64(places[part])]
            begin[np.int64(places[part])] = k + 1
            for column in range(order.shape[1]):
                order[k, column] = found[part, column]
    share(loads, whole, borders)
    return begin[begin.shape[0] - 2]


@device
def share(loads, whole, borders):
    """Write even rows, between which about as much is to do; loads (rows,): what is to do, whole: in all."""
    bands = borders.shape[0] - 1
    borders[:] = loads.shape[0]
    borders[0] = 0
    done, band = 0.0, 1
    for row in range(0, loads.shape[0], 2):
        while band < bands and done * bands >= whole * band:
            borders[band] = row
            band += 1
        done += loads[row] + loads[row + 1]
