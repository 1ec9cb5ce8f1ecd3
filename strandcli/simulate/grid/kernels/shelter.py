"""Wind that strands take from those behind them.

Air that goes through strands of density n (metres in a cubic metre) and thickness d is left with exp(−n d s) of its
velocity after a way s: each strand stops what it meets. The share T that is left follows downwind, layer by layer of
cells, from the cells upwind: T_c = T_u / (1 + τ + τ² / 2) with τ = n_u d s, a rational form of the exponential that has
the same bits on every machine.

A layer is worked on in rows along x, or along y where the wind blows along x: a layer's cells follow from the layer
before alone. Both are held with a margin, beside which there is no strand.
"""

from __future__ import annotations

import numpy as np

from ....jit import device, function
from ....simd import gather, load, pointer, store, where
from .records import COUNTED, LANES, SIZE

MARGIN = 3
"""Rows that a layer's margin has: one before, and two after."""


def layer_size(wide: int, high: int, deep: int) -> int:
    """Cells of a layer with its margin, however the wind blows."""
    rows = (wide, high), (wide, deep), (-(-high // LANES) * LANES, deep)
    return max((row + 2 * LANES) * (count + MARGIN) for row, count in rows)


@device
def main_axis(way):
    """The axis along which the wind goes most."""
    main = 0
    for axis in range(1, 3):
        if abs(way[axis]) > abs(way[main]):
            main = axis
    return main


@function
def shelter(box, mass, way, stop, left, layers):
    """Set the share of the wind that is left in each cell, ``left`` (cells,) float32, which is laid out as `left_at`
    says.

    mass (cells,) float32: metres in them; way (3,): the wind's unit direction, float32; stop: τ of a cell that holds a
    metre of strand, for a way as long as a cell's side, 1/m; layers (4, `layer_size`) float32, scratch: metres in the
    last layer, the share that is left in it, and in this one, and metres that it has met.
    """
    main = main_axis(way)
    sizes, strides, fast, slow = layout(box, main)
    pitch = -(-sizes[fast] // LANES) * LANES + 2 * LANES
    layers[0], layers[1], layers[2] = 0, 1, 1
    corner = corner_of(way, main, pitch if (main + 1) % 3 == slow else 1, pitch if (main + 2) % 3 == slow else 1)
    forward = way[main] > 0
    stop = np.float32(stop / abs(way[main]))
    for layer in range(sizes[main]):
        o = layer if forward else sizes[main] - 1 - layer
        now, past = 1 + layer % 2, 2 - layer % 2
        for row in range(sizes[slow]):
            at = (row + 1) * pitch + LANES
            if layer > 0:
                meet(at, sizes[fast], corner, layers[0], layers[past], layers[now], layers[3])
                fade(at, sizes[fast], stop, layers[3], layers[now])
            place = (o * sizes[slow] + row) * sizes[fast] if main == 0 else o * strides[main] + row * strides[slow]
            for i in range(sizes[fast]):
                left[place + i] = layers[now, at + i]
        for row in range(sizes[slow]):
            at = (row + 1) * pitch + LANES
            fetch(o * strides[main] + row * strides[slow], strides[fast], sizes[fast], mass, layers[0], at)


@device
def layout(box, main):
    """Cells along the axes, how far neighbours lie apart, and which axis is along rows of a layer and which across."""
    wide, high, deep = box[SIZE], box[SIZE + 1], box[SIZE + 2]
    fast, slow = (1 if main == 0 else 0), (1 if main == 2 else 2)
    return (wide, high, deep), (np.int64(1), wide, wide * high), fast, slow


@device
def corner_of(way, main, first, second):
    """Where in the layer before the wind comes from, by how far neighbours lie apart along the two axes after the main
    one: the way to the first of four cells, those from it to the next ones, and the shares of all four."""
    forward = 1 if way[main] > 0 else -1
    x, y = -forward * way[(main + 1) % 3] / way[main], -forward * way[(main + 2) % 3] / way[main]
    shifts = np.int64(np.floor(x)), np.int64(np.floor(y))
    a, c = np.float32(x - shifts[0]), np.float32(y - shifts[1])
    one = np.float32(1)
    shares = (one - a) * (one - c), a * (one - c), (one - a) * c, a * c
    return shifts[0] * first + shifts[1] * second, first, second, shares


@device
def meet(at, count, corner, metres, past, now, met):
    """Interpolate the share that is left, and the metres in a cell, in the layer before, for a row of cells."""
    shift, first, second, shares = corner
    for place in range(at, at + count, LANES):
        store(pointer(now), place, between(pointer(past), place + shift, first, second, shares))
        store(pointer(met), place, between(pointer(metres), place + shift, first, second, shares))


@device
def between(rows, at, first, second, shares):
    """The mean of four cells, for a vector of cells."""
    e, f, g, h = shares
    near, far = e * load(rows, at) + f * load(rows, at + first), load(rows, at + first + second)
    return near + g * load(rows, at + second) + h * far


@device
def fade(at, count, stop, met, now):
    """Take from a row's shares what the cells before stop; what lies after the row stays as it is beside the box."""
    for i in range(at, at + count):
        depth = stop * met[i]
        now[i] = now[i] / (1 + depth + np.float32(0.5) * depth * depth)
    for i in range(at + count, at + -(-count // LANES) * LANES):
        now[i] = 1


@device
def fetch(place, stride, count, mass, metres, at):
    """Copy a row of cells' metres, which lie a ``stride`` apart."""
    rows, out, counted = pointer(mass), pointer(metres), load(pointer(COUNTED), 0)
    for i in range(0, count, LANES):
        if stride == 1:
            store(out, at + i, load(rows, place + i))
        else:
            found = gather(rows, place + i * stride, counted, stride, 0.0)
            store(out, at + i, where(counted < np.float32(count - i), found, 0.0))


@device
def left_at(box, main, place, left):
    """The share that is left in a vector of cells, whose ``place`` is layer and row, and the first one's in that."""
    o, n, i = place
    wide, high, deep = box[SIZE], box[SIZE + 1], box[SIZE + 2]
    if main != 0:
        return load(pointer(left), (o * high + n) * wide + i)
    return gather(pointer(left), (i * deep + o) * high + n, load(pointer(COUNTED), 0), deep * high, 0.0)
