"""Bounds of moving strands, of children, and of curves."""

from __future__ import annotations

import numpy as np

from ....constants import VECTOR
from ....jit import device, parallel, prange
from ....simd import lane_count, load, load3, pointer, sqrt, store3

ONE = np.float32(1.0)
LANES = VECTOR // 4
"""Numbers of a vector."""
TINY = np.float32(1e-20)


@parallel
def move(now, before, rest, fall, out):
    """Write to out the particles a step later: Verlet's rule with a constant fall, metres, then from the root on each
    segment at its rest length.

    now, before, out (blocks, n, 3, lanes) metres; rest (blocks, lanes) metres; lanes: a multiple of a vector's. The
    root stays.
    """
    for block in prange(now.shape[0]):
        move_block(now, before, rest, fall, out, np.int64(block))


@device
def move_block(now, before, rest, fall, out, block):
    """Move the strands of one block."""
    here, past, to, sizes = pointer(now), pointer(before), pointer(out), pointer(rest)
    n, lanes = now.shape[1], now.shape[3]
    for k in range(0, lanes, lane_count(here)):
        o = block * n * 3 * lanes + k
        long = load(sizes, block * lanes + k)
        ax, ay, az = load3(here, o, lanes)
        store3(to, o, lanes, ax, ay, az)
        for _ in range(1, n):
            o += 3 * lanes
            x, y, z = load3(here, o, lanes)
            u, v, w = load3(past, o, lanes)
            x, y, z = x + (x - u) - ax, y + (y - v) - fall - ay, z + (z - w) - az
            size = long / sqrt(x * x + y * y + z * z + TINY)
            ax, ay, az = ax + x * size, ay + y * size, az + z * size
            store3(to, o, lanes, ax, ay, az)


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

    controls (blocks, n + 3, 3, lanes) metres; lanes: those of a vector; basis (pieces, 4): weights of four controls
    that follow each other; view (3, 4): rows right, down and forward, each with a shift, in pixels and metres; world
    (blocks * lanes, n * pieces, 3) metres; screen of that shape: x, y in pixels, and inverse depth, 1/m.
    """
    for block in prange(controls.shape[0]):
        work = np.empty(6 * LANES, np.float32)
        tessellate_block(controls, basis, view, world, screen, work, np.int64(block))


@parallel
def project(world, view, screen):
    """Write where points (n, 3, lanes), metres, are on the screen, of that shape; view, lanes: as in `tessellate`."""
    for row in prange(world.shape[0]):
        project_row(world, view, screen, np.int64(row))


@device
def project_row(world, view, screen, row):
    """Project the points of one row."""
    o = row * 3 * LANES
    x, y, z = load3(pointer(world), o, LANES)
    over = ONE / (view[2, 0] * x + view[2, 1] * y + view[2, 2] * z + view[2, 3])
    u = (view[0, 0] * x + view[0, 1] * y + view[0, 2] * z + view[0, 3]) * over
    v = (view[1, 0] * x + view[1, 1] * y + view[1, 2] * z + view[1, 3]) * over
    store3(pointer(screen), o, LANES, u, v, over)


@device
def tessellate_block(controls, basis, view, world, screen, work, block):
    """Write the points of one block's curves; work (6 * LANES,): scratch."""
    rows, row = pointer(controls), pointer(work)
    pieces, n = basis.shape[0], controls.shape[1]
    for i in range(n - 3):
        o = (block * n + i) * 3 * LANES
        ax, ay, az = load3(rows, o, LANES)
        bx, by, bz = load3(rows, o + 3 * LANES, LANES)
        cx, cy, cz = load3(rows, o + 6 * LANES, LANES)
        dx, dy, dz = load3(rows, o + 9 * LANES, LANES)
        for j in range(pieces):
            a, b, c, d = basis[j, 0], basis[j, 1], basis[j, 2], basis[j, 3]
            x = a * ax + b * bx + c * cx + d * dx
            y = a * ay + b * by + c * cy + d * dy
            z = a * az + b * bz + c * cz + d * dz
            over = ONE / (view[2, 0] * x + view[2, 1] * y + view[2, 2] * z + view[2, 3])
            store3(row, 0, LANES, x, y, z)
            u = (view[0, 0] * x + view[0, 1] * y + view[0, 2] * z + view[0, 3]) * over
            v = (view[1, 0] * x + view[1, 1] * y + view[1, 2] * z + view[1, 3]) * over
            store3(row, 3 * LANES, LANES, u, v, over)
            place = np.uint64(i * pieces + j)
            for k in range(np.uint64(LANES)):
                s = np.uint64(block * LANES) + k
                for at in range(np.uint64(3)):
                    world[s, place, at] = work[at * np.uint64(LANES) + k]
                    screen[s, place, at] = work[(at + np.uint64(3)) * np.uint64(LANES) + k]
