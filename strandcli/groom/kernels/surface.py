"""Points of a surface that is made of pieces of triangles, one behind the other on a line; and combed parts of tied
strands, outside of the mesh that they grow on, and moved with the emitter."""

from __future__ import annotations

import numpy as np

from ...constants import W
from ...jit import device, parallel, prange
from ...jit.indices import first_above
from ...meshes.kernels.distance import distance_and_gradient

HALVINGS = 30
"""Of a piece, whose halves are 2⁻³⁰ of it in the end."""


@parallel
def place(line, ends, corners, weights, edges, pieces, shares):
    """Write the points at places on a line to pieces (n,) int32 and shares (n, 3), barycentric coordinates in them.

    line (n,): in [0, 1); ends (P,): where each piece ends on the line, ascending up to 1, as long as its measure;
    corners (P, 3, 3): places of its corners; weights (P, 3): density there, linear between; edges: scratch (n, 9).
    """
    for i in prange(line.shape[0]):
        k = np.int64(i)
        one(line[k], ends, corners, weights, edges[k], pieces, shares, k)


@device
def one(at, ends, corners, weights, own, pieces, shares, i):
    """`place` of point i. The piece is halved across its longest edge again and again, on the side where the rest of
    the place lies: halves have the same area, and their measures are as their mean densities."""
    last = ends.shape[0] - 1
    piece = min(first_above(ends, at), last)
    begin = ends[piece - 1] if piece > 0 else 0.0
    size = ends[piece] - begin
    rest = min(max((at - begin) / size, 0.0), 1.0) if size > 0.0 else 0.5
    for k in range(9):
        own[k] = 0.0
    own[0] = own[4] = own[8] = 1.0
    for _ in range(HALVINGS):
        a = longest(corners[piece], own)
        b = (a + 1) % 3
        c = (a + 2) % 3
        of_a = density(weights[piece], own, a)
        of_b = density(weights[piece], own, b)
        of_c = density(weights[piece], own, c)
        whole = of_a + of_b + of_c
        share = 0.5
        if whole > 0.0:  # corners a, middle and c, over the whole, which is twice a half
            share = (1.5 * of_a + 0.5 * of_b + of_c) / (2.0 * whole)
        replaced = b
        if rest < share:
            rest /= share
        else:
            replaced = a
            rest = min((rest - share) / max(1.0 - share, 1e-300), 1.0)
        for k in range(3):
            own[3 * replaced + k] = 0.5 * (own[3 * a + k] + own[3 * b + k])
    pieces[i] = piece
    for k in range(3):
        shares[i, k] = (own[k] + own[3 + k] + own[6 + k]) / 3.0


@device
def density(weights, own, corner):
    """The density at a corner of a part."""
    k = 3 * corner
    return weights[0] * own[k] + weights[1] * own[k + 1] + weights[2] * own[k + 2]


@device
def longest(corners, own):
    """The corner at which the longest edge of a part begins, which goes to the next one."""
    best = -1.0
    found = 0
    for a in range(3):
        b = (a + 1) % 3
        square = 0.0
        for axis in range(3):
            d = 0.0
            for k in range(3):
                d += (own[3 * a + k] - own[3 * b + k]) * corners[k, axis]
            square += d * d
        if square > best:
            best = square
            found = a
    return found


STEPS = 128
"""Steps of sphere tracing at most; one is enough where the normal is perpendicular to the surface."""
ENOUGH = 1e-7
"""Depth below a surface that counts as outside, metres."""


@parallel
def lift_off_mesh(points, normals, grid, clear, out):
    """Write to out (N,) how far points (N, 3) must move along unit normals (N, 3) to be ``clear`` metres outside of a
    mesh, of which grid is the `meshes.kernels.distance.DistanceGrid`."""
    for i in prange(points.shape[0]):
        up = 0.0
        for _ in range(STEPS):
            away, _, _, _ = distance_and_gradient(
                grid, points[i, 0] + up * normals[i, 0], points[i, 1] + up * normals[i, 1],
                points[i, 2] + up * normals[i, 2],
            )  # fmt: skip
            if away >= clear - ENOUGH:
                break
            up += clear - away
        out[i] = up


@parallel
def join(combed, hanging, rotation, shift, out):
    """Write strands from root to tip to out: the combed part, moved with the emitter, then the hanging part.

    combed (blocks, 1 + P, 3 W) float32 in the emitter's frame: the row before the root, then the points to the tie;
    hanging (blocks, n + 1, 3 W) metres: row 1 is at the tie, row 0 is not used; rotation (9,) by rows
    and shift (3,) float32: the emitter's pose; out (blocks, 1 + P + n, 3 W).
    """
    rows = combed.shape[1]
    for block in prange(out.shape[0]):
        for row in range(rows):
            for c in range(3):
                a = rotation[3 * c]
                b = rotation[3 * c + 1]
                d = rotation[3 * c + 2]
                e = shift[c]
                for k in range(W):
                    x = combed[block, row, k]
                    y = combed[block, row, W + k]
                    z = combed[block, row, 2 * W + k]
                    out[block, row, c * W + k] = (a * x + b * y) + d * z + e
        for row in range(1, hanging.shape[1]):
            for k in range(3 * W):
                out[block, rows + row - 1, k] = hanging[block, row, k]
