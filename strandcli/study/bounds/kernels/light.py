"""Bounds of shading: each light's transmittance at places on strands and solids, and a fibre's tables."""

from __future__ import annotations

import numpy as np

from ....constants import VECTOR
from ....draw.common.kernels.approximations import exp_lanes
from ....jit import device, inlined, parallel, prange
from ....simd import broadcast, floor, gather, lane_count, load_deinterleaved, pointer, sqrt, store

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
LANES = VECTOR // 4
"""Numbers of a vector."""
TASKS = 64
"""Parts that places are divided into, for threads."""


@inlined
def passed(maps, start, side, layers, u, v, d):
    """Return e^-τ at column u and row v of the map (layers + 1, side, side) that begins at number `start` of the
    pointer `maps`, at depth d in layers: bilinear in texels, linear in depth. Vectors; all within the map."""
    left, up = floor(u), floor(v)
    u, v = u - left, v - up
    k = floor(d)
    d = d - k
    total = broadcast(maps, ZERO)
    for texel in range(4):
        part = (u if texel & 1 else ONE - u) * (v if texel > 1 else ONE - v)
        at = (up + np.float32(texel >> 1)) * np.float32(side) + left + np.float32(texel & 1)
        low = gather(maps, start, k, side * side, at)
        high = gather(maps, start + side * side, k, side * side, at)
        total = total + part * (low + d * (high - low))
    return exp_lanes(-total)


@inlined
def table_at(tables, start, x, y, side):
    """Return the table (side, side) that begins at number `start` of the pointer `tables` between four entries, at x
    and y in entries. Vectors."""
    left, up = floor(x), floor(y)
    x, y = x - left, y - up
    a, b = gather(tables, start, up, side, left), gather(tables, start, up, side, left + ONE)
    c, d = gather(tables, start, up + ONE, side, left), gather(tables, start, up + ONE, side, left + ONE)
    low, high = a + x * (b - a), c + x * (d - c)
    return low + y * (high - low)


@inlined
def spread(total, work, first, out):
    """Write a vector of light from row `first` of out (n, 3) on, once, twice and three times as great."""
    store(pointer(work), 0, total)
    for k in range(LANES):
        for c in range(3):
            out[first + k, c] = work[k] * np.float32(1 + c)


@parallel
def light_vertices(places, ways, lights, mapped, maps, tables, out):
    """Write the light (V, 3) that all lights send along strands, V a multiple of `TASKS` vectors.

    places (V, 3) from 0 to 1; ways (V, 3): unit tangents; lights (L, 3): unit directions to lights; maps
    (L, layers + 1, side, side) of τ, of which the first `mapped` are read, along the axes of the places; tables
    (2, n, n): of the sine of a way and a light, and of the cosine between way and x axis.
    """
    count = places.shape[0] // TASKS
    for task in prange(TASKS):
        work = np.empty(LANES, np.float32)
        vertices(places, ways, lights, mapped, maps, tables, out, work, np.int64(task) * count)


@device
def vertices(places, ways, lights, mapped, maps, tables, out, work, begin):
    """Light one part of the vertices, from number `begin` on; work (LANES,): scratch."""
    rows, along, texels, fibre = pointer(places), pointer(ways), pointer(maps), pointer(tables)
    layers, side, entries = maps.shape[1] - 1, maps.shape[2], tables.shape[1]
    end = begin + places.shape[0] // TASKS
    deep, wide, fine = np.float32(layers) * (ONE - np.float32(1e-6)), np.float32(side - 2), np.float32(entries - 2)
    for v in range(begin, end, lane_count(rows)):
        x, y, z = load_deinterleaved(rows, 3 * v)
        tx, ty, tz = load_deinterleaved(along, 3 * v)
        turn = (tx * HALF + HALF) * fine
        total = broadcast(rows, ZERO)
        for i in range(lights.shape[0]):
            sine = tx * lights[i, 0] + ty * lights[i, 1] + tz * lights[i, 2]
            cosine = sqrt(max(ONE - sine * sine, ZERO))
            lit = cosine * table_at(fibre, 0, (sine * HALF + HALF) * fine, turn, entries)
            lit = lit * table_at(fibre, entries * entries, cosine * fine, turn, entries)
            if i < mapped:
                lit = lit * passed(texels, i * (layers + 1) * side * side, side, layers, x * wide, y * wide, z * deep)
            total = total + lit
        spread(total, work, v, out)


@parallel
def light_pixels(places, lights, mapped, maps, out):
    """Write the light (P, 3) of a matte surface that faces the y axis, P a multiple of `TASKS` vectors; the rest
    as in `light_vertices`."""
    count = places.shape[0] // TASKS
    for task in prange(TASKS):
        work = np.empty(LANES, np.float32)
        pixels(places, lights, mapped, maps, out, work, np.int64(task) * count)


@device
def pixels(places, lights, mapped, maps, out, work, begin):
    """Light one part of the pixels, from number `begin` on; work (LANES,): scratch."""
    rows, texels = pointer(places), pointer(maps)
    layers, side = maps.shape[1] - 1, maps.shape[2]
    end = begin + places.shape[0] // TASKS
    deep, wide = np.float32(layers) * (ONE - np.float32(1e-6)), np.float32(side - 2)
    for p in range(begin, end, lane_count(rows)):
        x, y, z = load_deinterleaved(rows, 3 * p)
        total = broadcast(rows, ZERO)
        for i in range(lights.shape[0]):
            lit = max(lights[i, 1], ZERO)
            if i < mapped:
                start = i * (layers + 1) * side * side
                total = total + lit * passed(texels, start, side, layers, x * wide, y * wide, z * deep)
            else:
                total = total + lit
        spread(total, work, p, out)
