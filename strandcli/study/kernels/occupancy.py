"""Fragments laid over a picture two ways: sorted, and in no order by what occupancy maps tell of what is in front."""

from __future__ import annotations

import math

import numpy as np

from ...draw.common.kernels.approximations import exp
from ...draw.coverage.kernels.resolve import RUN, rank
from ...draw.coverage.kernels.tiles import NUMBERS, PIXELS, TILE_HEIGHT, TILE_WIDTH
from ...jit import function, parallel, prange

NEAREST = np.float32(-1e6)


@parallel
def undo(begin, place, weight, along, stride, screen, alpha, depth):
    """From sorted fragments' weights, shares of the pixel's light, to opacities; their depth; and out of the order of
    depth into that in which strands are drawn.

    begin (P + 1,) int64: where each pixel's fragments begin; place (F,) int64 lit vertices, those from V on edges of
    solids; weight, along (F,) float32 places to the next lit vertex; screen (V, 3); alpha, depth (F,) float32 written,
    depth growing away from the eye.
    """
    for p in prange(begin.shape[0] - 1):
        through = 1.0
        for f in range(begin[p], begin[p + 1]):
            alpha[f] = min(weight[f] / max(through, 1e-6), 1.0)
            through -= weight[f]
            v = place[f]
            if v < screen.shape[0]:
                depth[f] = -(screen[v, 2] + along[f] * (screen[v + stride, 2] - screen[v, 2]))
            else:  # the edge of a solid: right behind what is in front of it
                depth[f] = depth[f - 1] if f > begin[p] else NEAREST
        for f in range(begin[p] + 1, begin[p + 1]):  # by vertex
            a, b, c, d = place[f], alpha[f], along[f], depth[f]
            g = f - 1
            while g >= begin[p] and place[g] > a:
                place[g + 1], alpha[g + 1], along[g + 1], depth[g + 1] = place[g], alpha[g], along[g], depth[g]
                g -= 1
            place[g + 1], alpha[g + 1], along[g + 1], depth[g + 1] = a, b, c, d


@function
def light(vertex, edges, place, along, stride, f, c):
    """Radiance of a fragment in one channel."""
    v = place[f]
    if v >= vertex.shape[0]:
        return edges[v - vertex.shape[0], c]
    return vertex[v, c] + along[f] * (vertex[v + stride, c] - vertex[v, c])


@parallel
def in_order(begin, place, alpha, along, depth, stride, vertex, edges, image):
    """Sort each pixel's fragments and lay them over image (P, 3); vertex (V, 3), edges (E, 3) radiance."""
    most = 0
    for p in range(begin.shape[0] - 1):
        most = max(most, begin[p + 1] - begin[p])
    tasks = 64
    size = begin.shape[0] - 1
    for task in prange(tasks):
        fragments = np.empty(most * NUMBERS, np.int32)
        depths = np.empty(most + RUN, np.float32)
        behind = np.empty(RUN, np.float32)
        listed, order, spare = np.empty(most, np.uint32), np.empty(most, np.uint32), np.empty(most, np.uint32)
        counts, ends = np.empty(1, np.int64), np.empty(1, np.int64)
        for p in range(task * size // tasks, (task + 1) * size // tasks):
            n = begin[p + 1] - begin[p]
            if n == 0:
                continue
            for i in range(n):
                depths[i] = -depth[begin[p] + i]
                fragments[i * NUMBERS] = np.float32(depths[i]).view(np.int32)
                fragments[i * NUMBERS + 2] = i
                listed[i] = i
            counts[0] = ends[0] = n
            rank(fragments, counts, ends, depths, listed, behind, spare, order)
            through = 1.0
            r, g, b = 0.0, 0.0, 0.0
            for i in range(n):
                f = begin[p] + np.int64(order[i])
                w = through * alpha[f]
                r += w * light(vertex, edges, place, along, stride, f, 0)
                g += w * light(vertex, edges, place, along, stride, f, 1)
                b += w * light(vertex, edges, place, along, stride, f, 2)
                through -= w
            image[p, 0] = r + through * image[p, 0]
            image[p, 1] = g + through * image[p, 1]
            image[p, 2] = b + through * image[p, 2]


@parallel
def by_occupancy(begin, place, alpha, along, depth, slices, slabs, stride, vertex, edges, image):
    """Lay fragments over image (P, 3) in the order in which strands are drawn (Sintorn & Assarsson 2009).

    A pixel's depths, from its nearest fragment to its farthest, are divided into `slices`, of which one bit each tells
    whether anything is there, and into `slabs`, which count fragments. What is in front of a fragment is all in the
    slabs before its own, and of its own slab the share of its occupied slices that come before. The paper's strands are
    all as opaque; here the mean of log (1 − α) stands for each of those in front. What shows of the background is then
    exact, and weights are scaled to leave it so.
    """
    size = begin.shape[0] - 1
    tasks = 64
    per = slices // slabs
    for task in prange(tasks):
        bits = np.empty(slices, np.uint8)
        counts = np.empty(slabs, np.int64)
        before = np.empty(slices, np.float32)
        for p in range(task * size // tasks, (task + 1) * size // tasks):
            n = begin[p + 1] - begin[p]
            if n == 0:
                continue
            nearest = np.float32(np.inf)
            farthest = np.float32(-np.inf)
            through = 1.0
            for f in range(begin[p], begin[p + 1]):
                nearest = min(nearest, depth[f])
                farthest = max(farthest, depth[f])
                through *= max(1.0 - alpha[f], 1e-4)
            bits[:] = 0
            counts[:] = 0
            scale = slices / max(farthest - nearest, 1e-30)
            for f in range(begin[p], begin[p + 1]):
                k = min(np.int64((depth[f] - nearest) * scale), slices - 1)
                bits[k] = 1
                counts[k // per] += 1
            passed = 0
            for slab in range(slabs):
                held = 0
                for k in range(slab * per, (slab + 1) * per):
                    before[k] = held
                    held += bits[k]
                for k in range(slab * per, (slab + 1) * per):
                    before[k] = passed + counts[slab] * before[k] / max(held, 1)
                passed += counts[slab]
            each = np.float32(math.log(max(through, 1e-300)) / n)
            r, g, b, total = 0.0, 0.0, 0.0, 0.0
            for f in range(begin[p], begin[p + 1]):
                k = min(np.int64((depth[f] - nearest) * scale), slices - 1)
                w = alpha[f] * exp(each * before[k])
                r += w * light(vertex, edges, place, along, stride, f, 0)
                g += w * light(vertex, edges, place, along, stride, f, 1)
                b += w * light(vertex, edges, place, along, stride, f, 2)
                total += w
            share = (1.0 - through) / max(total, 1e-12)
            image[p, 0] = share * r + through * image[p, 0]
            image[p, 1] = share * g + through * image[p, 1]
            image[p, 2] = share * b + through * image[p, 2]


@parallel
def listed(begin, kept, place, weight, along, top, bottom, width, first, places, weights, alongs):
    """The fragments that a resolver has sorted, pixel after pixel in rows.

    begin … along, top, bottom: as `resolve.resolve` leaves them; first (P + 1,): where each pixel's fragments begin, of
    which so many are kept as `counted` says; places, weights, alongs (F,).
    """
    across = (width + TILE_WIDTH - 1) // TILE_WIDTH
    for one in prange(begin.shape[0]):
        tile = np.int64(one)
        f = begin[tile]
        if f < 0:
            continue
        y = tile // across * TILE_HEIGHT
        x = tile % across * TILE_WIDTH
        for row in range(y, min(y + TILE_HEIGHT, bottom - top)):
            for column in range(x, min(x + TILE_WIDTH, width)):
                o = first[row * width + column]
                for _ in range(kept[tile * PIXELS + (row - y) * TILE_WIDTH + column - x]):
                    places[o] = place[f]
                    weights[o] = weight[f]
                    alongs[o] = along[f]
                    o += 1
                    f += 1


@parallel
def counted(kept, top, bottom, width, out):
    """Fragments of each pixel, out ((bottom − top) · width,) int64."""
    across = (width + TILE_WIDTH - 1) // TILE_WIDTH
    for one in prange(bottom - top):
        row = np.int64(one)
        for column in range(width):
            tile = row // TILE_HEIGHT * across + column // TILE_WIDTH
            pixel = tile * PIXELS + row % TILE_HEIGHT * TILE_WIDTH + column % TILE_WIDTH
            out[row * width + column] = kept[pixel]
