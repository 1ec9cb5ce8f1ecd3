"""Z-buffer of solids: the nearest one on the ray through each pixel centre."""

from __future__ import annotations

import numpy as np

from ....jit import device, parallel, prange
from ....solids.kernels import capsule, plane, sphere
from ...common.kernels.keys import EMPTY, FIRST, LOW, SHIFT
from ...common.kernels.numbers import HALF, INF, ONE, ZERO
from ...common.kernels.view_columns import AXIS_X, AXIS_Y, DEPTH_RANGE, FOCAL, NEAR_PLANE, PERSPECTIVE
from .rays import meet, ray

LEFT, RIGHT, TOP, BOTTOM = range(4)
"""Columns of a solid's screen bounds: pixels, right and bottom exclusive."""


@parallel
def draw(solids, frames, view, width, height, keys):
    """Fill the z-buffer with solids, and with `keys.EMPTY` where there are none.

    frames (m, 4) int64: screen bounds of each solid, with the columns above; keys (height * width,) uint64 out.
    """
    # a row of a sphere, a capsule or a plane is one loop without branches, which LLVM vectorises
    spheres, capsules, planes = solids.spheres, solids.capsules, solids.planes
    round_ones = spheres.shape[0] + capsules.shape[0]
    flat = ONE - view[PERSPECTIVE]
    far = ONE / view[DEPTH_RANGE]
    for y in prange(height):
        row = keys[y * width : (y + 1) * width]
        row[:] = EMPTY
        up = (view[AXIS_Y] - np.float32(y) - HALF) / view[FOCAL]
        for m in range(frames.shape[0]):
            if y < frames[m, TOP] or y >= frames[m, BOTTOM]:
                continue
            identity = FIRST + np.uint64(m)
            part = row[frames[m, LEFT] : frames[m, RIGHT]]
            begin = np.float32(frames[m, LEFT]) + HALF - view[AXIS_X]
            if m < spheres.shape[0]:
                for x in range(part.shape[0]):
                    ox, oy, oz, dx, dy, dz = ray(view, (begin + np.float32(x)) / view[FOCAL], up)
                    key = key_at(sphere.meet(spheres, m, ox, oy, oz, dx, dy, dz), view, flat, far, identity)
                    part[x] = min(part[x], key)
            elif m < round_ones:
                own = m - spheres.shape[0]
                for x in range(part.shape[0]):
                    ox, oy, oz, dx, dy, dz = ray(view, (begin + np.float32(x)) / view[FOCAL], up)
                    key = key_at(capsule.meet(capsules, own, ox, oy, oz, dx, dy, dz), view, flat, far, identity)
                    part[x] = min(part[x], key)
            elif m < round_ones + planes.shape[0]:
                own = m - round_ones
                for x in range(part.shape[0]):
                    ox, oy, oz, dx, dy, dz = ray(view, (begin + np.float32(x)) / view[FOCAL], up)
                    key = key_at(plane.meet(planes, own, ox, oy, oz, dx, dy, dz), view, flat, far, identity)
                    part[x] = min(part[x], key)
            else:
                for x in range(part.shape[0]):
                    ox, oy, oz, dx, dy, dz = ray(view, (begin + np.float32(x)) / view[FOCAL], up)
                    t = meet(solids, m, ox, oy, oz, dx, dy, dz)
                    part[x] = min(part[x], key_at(t, view, flat, far, identity))


@device
def key_at(t, view, flat, far, identity):
    """Return the z-buffer key of a solid at depth t, metres, or `keys.EMPTY` if t is not in front of the near plane;
    flat: 1 for an orthographic view; far: one over its depth range."""
    # depths behind an orthographic view's range are clamped to its end
    q = (ONE - flat) / t + flat * max(ONE - (t - view[NEAR_PLANE]) * far, ZERO)
    key = ((LOW - np.uint64(np.float32(q).view(np.uint32))) << SHIFT) | identity
    return key if view[NEAR_PLANE] < t < INF else EMPTY
