"""The path of children along their guides and clumps, a vector of them at a time."""

from __future__ import annotations

import numpy as np

from ...constants import W
from ...jit import device, inlined
from ...simd import any_lane, broadcast, floor, gather, gather2, gather4, load, load3, pointer, sqrt, store3
from .child_scratch import BASE, CHAIN, LINK, PARENT, PULL, REST, ROOT, SHARE, WEIGHT
from .inputs import PARENTS

TINY = 1e-30
ZERO = np.float32(0.0)
TOWARD = 0.3
"""Share of its lateral distance from the target path that a strand corrects within a segment."""


@device
def follow_guides(guides, clumps, scratch, x, b, k):
    """Write the paths of children to the lanes from k on of block b of rows x: particles in rows from 1 on, without
    waves, and in row 0 the direction at the root."""
    particles, ramps = pointer(guides.particles), pointer(clumps.ramps)
    stride = guides.particles.shape[1] * guides.particles.shape[2]
    m = guides.particles.shape[1] - 1
    share = load(scratch, SHARE * W + k)
    top = b * (m + 1) * 3 * W + k
    for j in range(m):
        u = min(share * np.float32(j), np.float32(m - 1))
        low = floor(min(u, np.float32(m - 2)))
        t = u - low
        px, py, pz = on_guides(particles, stride, scratch, CHAIN * W + k, low, t)
        for level in range(clumps.middles.shape[0] - 1, -1, -1):
            link = (CHAIN + (level + 1) * LINK) * W + k
            pull = load(scratch, link + PULL * W)
            if any_lane(pull > 0.0):
                ramp = gather(ramps, level * m, low, np.int64(1), 0.0)
                pull = pull * (ramp + t * (gather(ramps, level * m + 1, low, np.int64(1), 0.0) - ramp))
                qx, qy, qz = on_guides(particles, stride, scratch, link, low, t)
                px, py, pz = px + pull * (qx - px), py + pull * (qy - py), pz + pull * (qz - pz)
        store3(x, top + (j + 1) * 3 * W, W, px, py, pz)
    dx, dy, dz = before_root(particles, stride, scratch, CHAIN * W + k)
    store3(x, top, W, dx, dy, dz)


@inlined
def on_guides(particles, stride, scratch, link, low, t):
    """Return the points of children, whose `child_scratch` links begin at ``link``, at the share t between particles
    low and low + 1 of their guides, metres, before clumps and waves."""
    x, y, z = load3(scratch, link + ROOT * W, W)
    row = low * 3.0
    for p in range(PARENTS):
        g = load(scratch, link + (PARENT + p) * W)
        w = load(scratch, link + (WEIGHT + p) * W)
        bx, by, bz = load3(scratch, link + (BASE + 3 * p) * W, W)
        ax, ay, az, cx = gather4(particles, 3, g, stride, row)  # two points lie beside each other
        cy, cz = gather2(particles, 7, g, stride, row)
        x = x + w * (ax + t * (cx - ax) - bx)
        y = y + w * (ay + t * (cy - ay) - by)
        z = z + w * (az + t * (cz - az) - bz)
    return x, y, z


@inlined
def before_root(particles, stride, scratch, link):
    """Return the weighted vectors from the root to the row before it, of children's guides, metres."""
    x = y = z = broadcast(scratch, ZERO)
    for p in range(PARENTS):
        g = load(scratch, link + (PARENT + p) * W)
        w = load(scratch, link + (WEIGHT + p) * W)
        bx, by, bz = load3(scratch, link + (BASE + 3 * p) * W, W)
        x = x + w * (gather(particles, 0, g, stride, 0.0) - bx)
        y = y + w * (gather(particles, 1, g, stride, 0.0) - by)
        z = z + w * (gather(particles, 2, g, stride, 0.0) - bz)
    return x, y, z


@device
def restore_lengths(scratch, x, b, k, rows):
    """Set the segments of paths, in the lanes from k on of block b of x, from row 1 of ``rows`` on to the length that
    they have at rest, root to tip. Each keeps its direction, turned toward the original path in proportion to the
    lateral distance from it."""
    rest = load(scratch, REST * W + k)
    top = b * rows * 3 * W + k
    px, py, pz = load3(x, top + 3 * W, W)
    qx, qy, qz = px, py, pz
    per = TOWARD / max(rest, TINY)
    for j in range(2, rows):
        nx, ny, nz = load3(x, top + j * 3 * W, W)
        tx, ty, tz = unit(nx - qx, ny - qy, nz - qz)
        ex, ey, ez = qx - px, qy - py, qz - pz
        along = ex * tx + ey * ty + ez * tz
        tx, ty, tz = unit(tx + per * (ex - along * tx), ty + per * (ey - along * ty), tz + per * (ez - along * tz))
        qx, qy, qz = nx, ny, nz
        px, py, pz = px + rest * tx, py + rest * ty, pz + rest * tz
        store3(x, top + j * 3 * W, W, px, py, pz)


@inlined
def unit(x, y, z):
    """Return the unit vectors of vectors."""
    size = 1.0 / sqrt(max(x * x + y * y + z * z, TINY))
    return x * size, y * size, z * size
