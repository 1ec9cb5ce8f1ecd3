"""Rays that lie close together, such as those of one pixel, against triangles: they go through the tree together.

A ray by itself waits at each node for the result of its test, and for the processor's guess which child comes first.
Here a node's box is tested against vectors of rays. Whatever the order of nodes, a ray is tested against the triangles
of each leaf whose box it enters before its first hit, so hits are those of `rays.first_hit`, to the bit.
"""

from __future__ import annotations

from ...jit import device, inlined
from ...simd import lane_count, load, movemask, pointer
from ...simd.local import local_float64, local_int32
from .rays import WIDER, inverse, meet, sheared

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
            test_leaf(bvh, node, entered, rays, found)
            continue
        first, second = node + 1, bvh.child[node]
        if is_behind(bvh.boxes[first], bvh.boxes[second], rays):
            first, second = second, first
        nodes[waiting], nodes[waiting + 1] = second, first
        waiting += 2


@inlined
def rays_in(box, rays, inverses, found):
    """Return bits of the rays that enter a box before what they have met: `rays.box_entry` of vectors."""
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


@device
def test_leaf(bvh, node, entered, rays, found):
    """Test the rays of a mask against the triangles of a leaf."""
    for k in range(RAYS):
        if (entered >> k) & ONE == NONE:
            continue
        ox, oy, oz = rays[k], rays[RAYS + k], rays[2 * RAYS + k]
        shear = sheared(rays[3 * RAYS + k], rays[4 * RAYS + k], rays[5 * RAYS + k])
        for i in range(bvh.child[node], bvh.child[node] + bvh.counts[node]):
            t, _, _ = meet(bvh.corners, i, ox, oy, oz, shear)
            if 0.0 <= t < found[k]:
                found[k] = t


@device
def is_behind(one, other, rays):
    """Return whether the middle of a box comes after that of another along the first ray."""
    dx, dy, dz = rays[3 * RAYS], rays[4 * RAYS], rays[5 * RAYS]
    x = (one[0] + one[3]) - (other[0] + other[3])
    y = (one[1] + one[4]) - (other[1] + other[4])
    z = (one[2] + one[5]) - (other[2] + other[5])
    return x * dx + y * dy + z * dz > 0.0
