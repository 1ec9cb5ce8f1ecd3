"""Rays that meet triangles.

Watertight: a ray that passes through an edge or a corner meets one of the triangles there (Woop, Benthin & Wald 2013,
"Watertight ray/triangle intersection"; box tests widened as by Ize 2013, "Robust BVH ray traversal").

Rays that lie close together, such as those of one pixel, go through the tree together: a node's box is tested against
vectors of rays. Whatever the order of nodes, a ray is tested against the triangles of each leaf whose box it enters
before its first hit, so hits are those of `first_hit`, to the bit.
"""

from __future__ import annotations

import math

import numpy as np

from ...jit import device, inlined
from ...simd import lane_count, load, movemask, pointer
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
    """The axis along which a direction is longest, the other two in an order that keeps winding, and the shear that
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


RAYS = 16
"""Rays that go together: six numbers of each fill a `local_float64`."""
NONE, ONE = 0, 1


@device
def first_hits(bvh, rays, found):
    """Write where rays o + t d first meet a triangle, t, to `found`, which holds the greatest t that counts, less than
    0 for rays that meet nothing; where there is none it stays. rays: six rows of `RAYS` numbers, o and d."""
    inverses = local_float64()
    for k in range(3 * RAYS):
        inverses[k] = inverse(rays[3 * RAYS + k])
    nodes = local_int32()
    nodes[0] = 0
    waiting = 1
    while waiting > 0:
        waiting -= 1
        node = nodes[waiting]
        entered = rays_in(bvh.boxes[node], pointer(rays), pointer(inverses), pointer(found))
        if entered == NONE:
            continue
        if bvh.counts[node] > 0:
            for k in range(RAYS):
                if (entered >> k) & ONE == NONE:
                    continue
                shear = sheared(rays[3 * RAYS + k], rays[4 * RAYS + k], rays[5 * RAYS + k])
                for i in range(bvh.child[node], bvh.child[node] + bvh.counts[node]):
                    t, _, _ = meet(bvh.corners, i, rays[k], rays[RAYS + k], rays[2 * RAYS + k], shear)
                    if 0.0 <= t < found[k]:
                        found[k] = t
            continue
        first, second = node + 1, bvh.child[node]
        one, other = bvh.boxes[first], bvh.boxes[second]
        ahead = 0.0  # how much later along the first ray the middle of the first box comes
        for k in range(3):
            ahead += ((one[k] + one[3 + k]) - (other[k] + other[3 + k])) * rays[(3 + k) * RAYS]
        if ahead > 0.0:
            first, second = second, first
        nodes[waiting], nodes[waiting + 1] = second, first
        waiting += 2


@inlined
def rays_in(box, rays, inverses, found):
    """Return bits of the rays that enter a box before what they have met: `box_entry` of vectors."""
    entered = NONE
    for k in range(0, RAYS, lane_count(rays)):
        ox, oy, oz = load(rays, k), load(rays, RAYS + k), load(rays, 2 * RAYS + k)
        ix, iy, iz = load(inverses, k), load(inverses, RAYS + k), load(inverses, 2 * RAYS + k)
        x0, x1 = (box[0] - ox) * ix, (box[3] - ox) * ix
        y0, y1 = (box[1] - oy) * iy, (box[4] - oy) * iy
        z0, z1 = (box[2] - oz) * iz, (box[5] - oz) * iz
        enter = max(max(min(x0, x1), min(y0, y1)), max(min(z0, z1), 0.0))
        leave = min(min(max(x0, x1), max(y0, y1)), max(z0, z1)) * WIDER
        entered |= movemask(enter <= min(leave, load(found, k))) << k
    return entered
