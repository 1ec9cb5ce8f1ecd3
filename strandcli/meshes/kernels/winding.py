"""Which way round triangles are wound, and generalised winding numbers: how often a mesh goes around a point, also
where it has holes.

Jacobson, Kavan & Sorkine-Hornung 2013, "Robust inside-outside segmentation using generalized winding numbers"; far
parts of the mesh as dipoles, as by Barill et al. 2018, "Fast winding numbers for soups and clouds".
"""

from __future__ import annotations

import math

import numpy as np

from ...jit import device, function
from ...simd.local import local_int32

NX, NY, NZ, CX, CY, CZ, RADIUS_2, AREA = range(8)
"""Columns of moments: the sum of area vectors, the centre of area, the squared radius about it times `FAR` squared,
the area."""
FAR = 2.0
"""Radii from which a part of the mesh counts as a dipole."""
PER_TURN = 1.0 / (4.0 * math.pi)


@function
def moments(bvh):
    """Write the moments of all nodes of a tree, from the last to the first."""
    for node in range(bvh.boxes.shape[0] - 1, -1, -1):
        one = bvh.moments[node]
        for k in range(AREA + 1):
            one[k] = 0.0
        if bvh.counts[node] > 0:
            for i in range(bvh.child[node], bvh.child[node] + bvh.counts[node]):
                add_triangle(one, bvh.corners[i])
        else:
            for k in range(2):
                other = bvh.moments[bvh.child[node] if k else node + 1]
                normal, centre = (other[NX], other[NY], other[NZ]), (other[CX], other[CY], other[CZ])
                add_moments(one, normal, centre, other[AREA])
        box, far = bvh.boxes[node], 0.0
        for k in range(3):
            far += max(one[CX + k] - box[k], box[3 + k] - one[CX + k]) ** 2
        one[RADIUS_2] = far * FAR * FAR


@device
def add_triangle(one, corners):
    """Add a triangle's area vector and its centre of area to moments."""
    ux, uy, uz = corners[1, 0] - corners[0, 0], corners[1, 1] - corners[0, 1], corners[1, 2] - corners[0, 2]
    vx, vy, vz = corners[2, 0] - corners[0, 0], corners[2, 1] - corners[0, 1], corners[2, 2] - corners[0, 2]
    nx, ny, nz = 0.5 * (uy * vz - uz * vy), 0.5 * (uz * vx - ux * vz), 0.5 * (ux * vy - uy * vx)
    centre = (
        (corners[0, 0] + corners[1, 0] + corners[2, 0]) / 3.0, (corners[0, 1] + corners[1, 1] + corners[2, 1]) / 3.0,
        (corners[0, 2] + corners[1, 2] + corners[2, 2]) / 3.0,
    )  # fmt: skip
    add_moments(one, (nx, ny, nz), centre, math.sqrt(nx * nx + ny * ny + nz * nz))


@device
def add_moments(one, normal, centre, area):
    """Add a sum of area vectors, a centre of area and an area to moments."""
    whole = one[AREA] + area
    share = area / whole if whole > 0.0 else 1.0
    for k in range(3):
        one[NX + k] += normal[k]
        one[CX + k] += share * (centre[k] - one[CX + k])
    one[AREA] = whole


@device
def solid_angle(corners, i, x, y, z):
    """Signed solid angle under which triangle i is seen (van Oosterom & Strackee 1983), positive from behind."""
    ax, ay, az = corners[i, 0, 0] - x, corners[i, 0, 1] - y, corners[i, 0, 2] - z
    bx, by, bz = corners[i, 1, 0] - x, corners[i, 1, 1] - y, corners[i, 1, 2] - z
    cx, cy, cz = corners[i, 2, 0] - x, corners[i, 2, 1] - y, corners[i, 2, 2] - z
    a = math.sqrt(ax * ax + ay * ay + az * az)
    b = math.sqrt(bx * bx + by * by + bz * bz)
    c = math.sqrt(cx * cx + cy * cy + cz * cz)
    volume = ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx)
    across = a * b * c + (ax * bx + ay * by + az * bz) * c
    across += (bx * cx + by * cy + bz * cz) * a + (cx * ax + cy * ay + cz * az) * b
    return 2.0 * math.atan2(volume, across)


@device
def winding(bvh, x, y, z):
    """The winding number of a mesh about a point: 1 within a closed mesh that is wound outward, 0 outside of it, .5 in
    the middle of a hole. Far parts are approximated, which is off by some hundredths."""
    x, y, z = np.float64(x), np.float64(y), np.float64(z)
    nodes = local_int32()
    nodes[0] = 0
    waiting = 1
    total = 0.0
    while waiting > 0:
        waiting -= 1
        node = nodes[waiting]
        one = bvh.moments[node]
        rx, ry, rz = one[CX] - x, one[CY] - y, one[CZ] - z
        r_2 = rx * rx + ry * ry + rz * rz
        if r_2 > one[RADIUS_2]:
            total += (one[NX] * rx + one[NY] * ry + one[NZ] * rz) / (r_2 * math.sqrt(r_2))
        elif bvh.counts[node] > 0:
            for i in range(bvh.child[node], bvh.child[node] + bvh.counts[node]):
                total += solid_angle(bvh.corners, i, x, y, z)
        else:
            nodes[waiting] = bvh.child[node]
            nodes[waiting + 1] = node + 1
            waiting += 2
    return total * PER_TURN


@function
def orient(neighbours, opposed, part, turned, queue):
    """The number of parts of a mesh. Triangles are gone through from neighbour to neighbour, and turned where that
    makes them agree.

    neighbours: (T, 3) int32, the triangle across each edge, negative of none; opposed: (T, 3), whether it is wound the
    opposite way;
    part: (T,) int32, of -1, becomes the number of its part; turned: (T,), becomes whether it has to be turned;
    queue: (T,) int32 scratch.
    """
    parts = 0
    for seed in range(part.shape[0]):
        if part[seed] >= 0:
            continue
        part[seed] = parts
        turned[seed] = False
        queue[0] = seed
        begin, end = 0, 1
        while begin < end:
            t = queue[begin]
            begin += 1
            for k in range(3):
                other = neighbours[t, k]
                if other >= 0 and part[other] < 0:
                    part[other] = parts
                    turned[other] = turned[t] != opposed[t, k]
                    queue[end] = other
                    end += 1
        parts += 1
    return parts
