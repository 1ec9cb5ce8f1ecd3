"""Bounds of what is drawn into buffers: opacity maps, min/max maps, tiles of fragments and z-buffers."""

from __future__ import annotations

import numpy as np

from ....jit import device, parallel, prange

ZERO = np.float32(0.0)
ONE = np.float32(1.0)


@parallel
def add_splats(splats, layer, area, side, maps):
    """Add areas linearly to two texels beside each other each, in a layer of their own.

    maps (tiles, layers, side * side): changed; splats (tiles, n, 2): column and row, 0 ≤ x < side − 1, of which the row
    is rounded down; layer (tiles, n) int32; area (tiles, n).
    """
    for tile in prange(maps.shape[0]):
        t = np.uint64(tile)
        for k in range(np.uint64(splats.shape[1])):
            u = splats[t, k, 0]
            column, row = np.int64(u), np.int64(splats[t, k, 1])
            part = area[t, k] * (u - np.float32(column))
            at, deep = np.uint64(row * side + column), np.uint64(layer[t, k])
            maps[t, deep, at] += area[t, k] - part
            maps[t, deep, at + np.uint64(1)] += part


@parallel
def widen(place, depth, tiles):
    """Widen the nearest and farthest depth of texels: tiles (tiles, texels, 2), changed; place (tiles, n) int32, depth
    (tiles, n)."""
    for tile in prange(tiles.shape[0]):
        t = np.uint64(tile)
        for k in range(np.uint64(place.shape[1])):
            p, d = np.uint64(place[t, k]), depth[t, k]
            tiles[t, p, 0] = min(tiles[t, p, 0], d)
            tiles[t, p, 1] = max(tiles[t, p, 1], d)


@parallel
def sort_fragments(pixel, depth, counts, out, order):
    """Sort the fragments of tiles by pixel, those of a pixel as they come, and count each pixel's.

    pixel (tiles, n) int32, depth (tiles, n); counts (tiles, pixels) int32, out (tiles, n): depths, order (tiles, n)
    int32: numbers of the fragments; all three written.
    """
    for tile in prange(counts.shape[0]):
        t = np.uint64(tile)
        ends = np.zeros(counts.shape[1], np.int32)
        tally(pixel, t, counts)
        total = np.int32(0)
        for p in range(np.uint64(counts.shape[1])):
            ends[p] = total
            total += counts[t, p]
        for k in range(np.uint64(pixel.shape[1])):
            p = np.uint64(pixel[t, k])
            o = np.uint64(ends[p])
            ends[p] += np.int32(1)
            out[t, o] = depth[t, k]
            order[t, o] = np.int32(k)


@device
def tally(pixel, t, counts):
    """Count the fragments of each pixel of tile t."""
    for p in range(np.uint64(counts.shape[1])):
        counts[t, p] = np.int32(0)
    for k in range(np.uint64(pixel.shape[1])):
        counts[t, np.uint64(pixel[t, k])] += np.int32(1)


@parallel
def keep_nearest(place, key, tiles):
    """Keep the least key of each sample: tiles (tiles, samples) uint64, changed; place (tiles, n) int32, key (tiles, n)
    uint64."""
    for tile in prange(tiles.shape[0]):
        t = np.uint64(tile)
        for k in range(np.uint64(place.shape[1])):
            p = np.uint64(place[t, k])
            tiles[t, p] = min(tiles[t, p], key[t, k])
