"""Bounds of moving strands, of children, and of curves."""

from __future__ import annotations

import math

import numpy as np

from ....jit import parallel, prange

ZERO = np.float32(0.0)
ONE = np.float32(1.0)
TINY = np.float32(1e-20)


@parallel
def move(now, before, rest, fall, out):
    """Write to out the particles a step later: Verlet's rule with a constant fall, metres, then from the root on each
    segment at its rest length.

    now, before, out (blocks, n, 3, lanes) metres; rest (blocks, lanes) metres. The root stays.
    """
    lanes = now.shape[3]
    for block in prange(now.shape[0]):
        for lane in range(lanes):
            for c in range(3):
                out[block, 0, c, lane] = now[block, 0, c, lane]
        for i in range(1, now.shape[1]):
            for k in range(np.uint64(lanes)):
                x = now[block, i, 0, k] + (now[block, i, 0, k] - before[block, i, 0, k])
                y = now[block, i, 1, k] + (now[block, i, 1, k] - before[block, i, 1, k]) - fall
                z = now[block, i, 2, k] + (now[block, i, 2, k] - before[block, i, 2, k])
                x -= out[block, i - 1, 0, k]
                y -= out[block, i - 1, 1, k]
                z -= out[block, i - 1, 2, k]
                size = rest[block, k] / math.sqrt(x * x + y * y + z * z + TINY)
                out[block, i, 0, k] = out[block, i - 1, 0, k] + x * size
                out[block, i, 1, k] = out[block, i - 1, 1, k] + y * size
                out[block, i, 2, k] = out[block, i - 1, 2, k] + z * size


@parallel
def interpolate(guides, parents, weights, out):
    """Write to out (children, numbers) the weighted sums of three guides (guides, numbers); parents, weights
    (children, 3)."""
    for child in prange(out.shape[0]):
        a, b, c = np.uint64(parents[child, 0]), np.uint64(parents[child, 1]), np.uint64(parents[child, 2])
        u, v, w = weights[child, 0], weights[child, 1], weights[child, 2]
        row = np.uint64(child)
        for i in range(np.uint64(out.shape[1])):
            out[row, i] = u * guides[a, i] + v * guides[b, i] + w * guides[c, i]


@parallel
def tessellate(controls, basis, view, world, screen):
    """Write points of cubic curves, and where they are on the screen.

    controls (S, n + 3, 3) metres; basis (pieces, 4): weights of four controls that follow each other; view (3, 4): rows
    right, down and forward, each with a shift, in pixels and metres; world (S, n * pieces, 3) metres; screen of that
    shape: x, y in pixels, and inverse depth, 1/m.
    """
    pieces = basis.shape[0]
    for s in prange(controls.shape[0]):
        for i in range(controls.shape[1] - 3):
            for j in range(pieces):
                k = i * pieces + j
                x = y = z = ZERO
                for c in range(4):
                    w = basis[j, c]
                    x += w * controls[s, i + c, 0]
                    y += w * controls[s, i + c, 1]
                    z += w * controls[s, i + c, 2]
                world[s, k, 0] = x
                world[s, k, 1] = y
                world[s, k, 2] = z
                over = ONE / (view[2, 0] * x + view[2, 1] * y + view[2, 2] * z + view[2, 3])
                screen[s, k, 0] = (view[0, 0] * x + view[0, 1] * y + view[0, 2] * z + view[0, 3]) * over
                screen[s, k, 1] = (view[1, 0] * x + view[1, 1] * y + view[1, 2] * z + view[1, 3]) * over
                screen[s, k, 2] = over
