"""Wind that strands take from those behind them.

Air that goes through strands of density n (metres in a cubic metre) and thickness d is left with exp(−n d s) of its
velocity after a way s: each strand stops what it meets. The share T that is left follows downwind, layer by layer of
cells, from the cells upwind: T_c = T_u / (1 + τ + τ² / 2) with τ = n_u d s, a rational form of the exponential that has
the same bits on every machine.
"""

from __future__ import annotations

import numpy as np

from ...jit import device, function
from .crowd_records import MASS, SIZE


@function
def shelter(box, grid, way, stop, left):
    """Set the share of the wind that is left in each cell, ``left`` (cells,) float32.

    way (3,): the wind's unit direction, float32; stop: τ of a cell that holds a metre of strand, for a way as long as a
    cell's side, 1/m.
    """
    sides = box[SIZE : SIZE + 3]
    strides = (1, box[SIZE], box[SIZE] * box[SIZE + 1])
    main = 0
    for axis in range(1, 3):
        if abs(way[axis]) > abs(way[main]):
            main = axis
    first, second = (main + 1) % 3, (main + 2) % 3
    forward = 1 if way[main] > 0 else -1
    x, y = -forward * way[first] / way[main], -forward * way[second] / way[main]
    shifts = np.int64(np.floor(x)), np.int64(np.floor(y))
    shares = np.float32(x - shifts[0]), np.float32(y - shifts[1])
    stop = np.float32(stop / abs(way[main]))
    for layer in range(sides[main]):
        o = layer if forward > 0 else sides[main] - 1 - layer
        upwind = (o - forward) * strides[main]
        for n in range(sides[second]):
            for i in range(sides[first]):
                at = o * strides[main] + n * strides[second] + i * strides[first]
                if layer == 0:
                    left[at] = 1
                    continue
                place = i + shifts[0], n + shifts[1]
                passed, met = between(
                    left, grid, upwind, (strides[first], strides[second]), (sides[first], sides[second]), place, shares
                )  # fmt: skip
                depth = stop * met
                left[at] = passed / (1 + depth + np.float32(0.5) * depth * depth)


@device
def between(left, grid, at, strides, sides, place, shares):
    """Interpolate the share that is left, and the metres in a cell, of four cells of the layer that begins at ``at``,
    the first at ``place``, by the ``shares`` of the next ones along both axes; beside the box there is no strand."""
    a, c = shares
    one = np.float32(1)
    passed, met = np.float32(0), np.float32(0)
    if 0 <= place[0] < sides[0] - 1 and 0 <= place[1] < sides[1] - 1:
        cell = np.uint64(at + place[0] * strides[0] + place[1] * strides[1])
        next, beyond = cell + np.uint64(strides[0]), np.uint64(strides[1])
        e, f, g, h = (one - a) * (one - c), a * (one - c), (one - a) * c, a * c
        passed = e * left[cell] + f * left[next] + g * left[cell + beyond] + h * left[next + beyond]
        met = e * grid[cell, MASS] + f * grid[next, MASS]
        return passed, met + g * grid[cell + beyond, MASS] + h * grid[next + beyond, MASS]
    for k in range(4):
        p, q = place[0] + (k & 1), place[1] + (k >> 1)
        share = (a if k & 1 else one - a) * (c if k >> 1 else one - c)
        if p < 0 or q < 0 or p >= sides[0] or q >= sides[1]:
            passed += share
        else:
            cell = at + p * strides[0] + q * strides[1]
            passed += share * left[cell]
            met += share * grid[cell, MASS]
    return passed, met
