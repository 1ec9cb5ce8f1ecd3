"""Rays that meet triangles.

Watertight: a ray that passes through an edge or a corner meets one of the triangles there (Woop, Benthin & Wald 2013,
"Watertight ray/triangle intersection"; box tests widened as by Ize 2013, "Robust BVH ray traversal").
"""

from __future__ import annotations

import math

import numpy as np

from ...jit import device
from ...simd.local import local_float64, local_int32

WIDER = 1.0 + 6.0 * 2.0**-53
"""Factor that makes up for the rounding of a box test."""
STEEPEST = 1e300
"""Stands for 1 / 0, without making NaN of the product with 0."""


@device
def inverse(d):
    """1 / d, of 0 a number that is large."""
    return 1.0 / d if abs(d) > 1.0 / STEEPEST else math.copysign(STEEPEST, d)


@device
def box_entry(box, ox, oy, oz, ix, iy, iz, t_max):
    """Where a ray enters a box (6,), or infinity where it misses it or comes there after t_max; ix, iy, iz: inverse
    direction."""
    x0, x1 = (box[0] - ox) * ix, (box[3] - ox) * ix
    y0, y1 = (box[1] - oy) * iy, (box[4] - oy) * iy
    z0, z1 = (box[2] - oz) * iz, (box[5] - oz) * iz
    enter = max(max(min(x0, x1), min(y0, y1)), max(min(z0, z1), 0.0))
    leave = min(min(max(x0, x1), max(y0, y1)), max(z0, z1)) * WIDER
    return enter if enter <= min(leave, t_max) else np.inf


@device
def sheared(dx, dy, dz):
    """The axis along which a direction is longest, the two others in an order that keeps winding, and the shear that
    turns it to that axis: kx, ky, kz, sx, sy, sz."""
    kz = 0
    if abs(dy) > abs(dx):
        kz = 1
    if abs(dz) > max(abs(dx), abs(dy)):
        kz = 2
    kx, ky = (kz + 1) % 3, (kz + 2) % 3
    fx, fy, fz = component(dx, dy, dz, kx), component(dx, dy, dz, ky), component(dx, dy, dz, kz)
    if fz < 0.0:
        kx, ky, fx, fy = ky, kx, fy, fx
    return kx, ky, kz, fx / fz, fy / fz, 1.0 / fz


@device
def component(x, y, z, k):
    """Coordinate k."""
    return x if k == 0 else (y if k == 1 else z)


@device
def meet(corners, i, ox, oy, oz, shear):
    """Where a ray meets triangle i of `corners`: t, u, v, with the point u b + v c + (1 - u - v) a; t is -1 where it
    does not. Both sides count."""
    kx, ky, kz, sx, sy, sz = shear
    px, py, pz = component(ox, oy, oz, kx), component(ox, oy, oz, ky), component(ox, oy, oz, kz)
    az, bz, cz = corners[i, 0, kz] - pz, corners[i, 1, kz] - pz, corners[i, 2, kz] - pz
    ax, ay = (corners[i, 0, kx] - px) - sx * az, (corners[i, 0, ky] - py) - sy * az
    bx, by = (corners[i, 1, kx] - px) - sx * bz, (corners[i, 1, ky] - py) - sy * bz
    cx, cy = (corners[i, 2, kx] - px) - sx * cz, (corners[i, 2, ky] - py) - sy * cz
    u = cx * by - cy * bx
    v = ax * cy - ay * cx
    w = bx * ay - by * ax
    if (u < 0.0 or v < 0.0 or w < 0.0) and (u > 0.0 or v > 0.0 or w > 0.0):
        return -1.0, 0.0, 0.0
    whole = u + v + w
    if whole == 0.0:
        return -1.0, 0.0, 0.0
    t = sz * (u * az + v * bz + w * cz) / whole
    return t, v / whole, w / whole


@device
def first_hit(bvh, ox, oy, oz, dx, dy, dz, t_max):
    """The first triangle that a ray o + t d meets at 0 <= t <= t_max: t, its number in the mesh, u, v; where there is
    none t is infinite and the number -1.

    The point is a + u (b - a) + v (c - a) of the triangle's corners. t counts in lengths of d, which need not be a unit
    vector. Both sides of triangles count; of several at the same t the lowest number.
    """
    ox, oy, oz = np.float64(ox), np.float64(oy), np.float64(oz)
    dx, dy, dz = np.float64(dx), np.float64(dy), np.float64(dz)
    ix, iy, iz = inverse(dx), inverse(dy), inverse(dz)
    shear = sheared(dx, dy, dz)
    nodes, entries = local_int32(), local_float64()
    best, best_u, best_v, hit = np.float64(t_max), 0.0, 0.0, -1
    node, waiting, entry = 0, 0, box_entry(bvh.boxes[0], ox, oy, oz, ix, iy, iz, best)
    while True:
        if entry <= best:
            if bvh.counts[node] > 0:
                for i in range(bvh.child[node], bvh.child[node] + bvh.counts[node]):
                    t, u, v = meet(bvh.corners, i, ox, oy, oz, shear)
                    if t >= 0.0 and (t < best or (t == best and (hit < 0 or bvh.triangle[i] < hit))):
                        best, best_u, best_v, hit = t, u, v, bvh.triangle[i]
            else:
                first, second = node + 1, bvh.child[node]
                near = box_entry(bvh.boxes[first], ox, oy, oz, ix, iy, iz, best)
                far = box_entry(bvh.boxes[second], ox, oy, oz, ix, iy, iz, best)
                if far < near:
                    first, second, near, far = second, first, far, near
                if far < np.inf:
                    nodes[waiting], entries[waiting] = second, far
                    waiting += 1
                if near < np.inf:
                    node, entry = first, near
                    continue
        if waiting == 0:
            break
        waiting -= 1
        node, entry = nodes[waiting], entries[waiting]
    return (best if hit >= 0 else np.inf), hit, best_u, best_v


@device
def any_hit(bvh, ox, oy, oz, dx, dy, dz, t_max):
    """Whether a ray o + t d meets any triangle at 0 <= t <= t_max."""
    ox, oy, oz = np.float64(ox), np.float64(oy), np.float64(oz)
    dx, dy, dz = np.float64(dx), np.float64(dy), np.float64(dz)
    ix, iy, iz = inverse(dx), inverse(dy), inverse(dz)
    shear = sheared(dx, dy, dz)
    nodes = local_int32()
    most = np.float64(t_max)
    nodes[0] = 0
    waiting = 1
    while waiting > 0:
        waiting -= 1
        node = nodes[waiting]
        if box_entry(bvh.boxes[node], ox, oy, oz, ix, iy, iz, most) == np.inf:
            continue
        if bvh.counts[node] > 0:
            for i in range(bvh.child[node], bvh.child[node] + bvh.counts[node]):
                t, _, _ = meet(bvh.corners, i, ox, oy, oz, shear)
                if 0.0 <= t <= most:
                    return True
        else:
            nodes[waiting] = bvh.child[node]
            nodes[waiting + 1] = node + 1
            waiting += 2
    return False
