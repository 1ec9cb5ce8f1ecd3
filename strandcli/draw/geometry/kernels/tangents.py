"""Tangents of strands at their particles, from root to tip: of neighbouring strands at once.

`rows` is a `simd.pointer` to positions (blocks, n + 1, 3 W), and o the place in it of a block's first row and the first
strand: row i + 1 is particle i, row 0 stands one segment before the root.
"""

from __future__ import annotations

import numpy as np

from ....constants import VECTOR, W
from ....jit import device
from ....simd import broadcast, load3, pointer, sqrt, store3, where
from ...common.kernels.numbers import ONE, ZERO

TINY = np.float32(1e-30)
STRAIGHT = np.float32(0.1)
"""Length below which the source's construction has no tangent, see `printed`."""
LANES = VECTOR // 4
"""Strands at once. Blocks hold a multiple of it."""
STEP = 3 * W
"""Numbers of a row."""


@device
def between(rows, o, i, j):
    """Return row j minus row i."""
    ax, ay, az = load3(rows, o + i * STEP, W)
    bx, by, bz = load3(rows, o + j * STEP, W)
    return bx - ax, by - ay, bz - az


@device
def unit(x, y, z):
    """Return a vector of length one; of (0, 0, 0) itself."""
    size = ONE / sqrt(max(x * x + y * y + z * z, TINY))
    return x * size, y * size, z * size


@device
def difference(rows, o, i, n):
    """Return the unit tangent at particle i, toward the tip: the central difference p_{i+1} − p_{i−1}; zero at the tip.

    For equal segments it is the direction that the source constructs, but never singular."""
    if i == n - 1:
        none = broadcast(rows, ZERO)
        return none, none, none
    # the root: from the row before it, the strand's direction
    x, y, z = between(rows, o, i, i + 2 if i > 0 else 1)
    return unit(x, y, z)


@device
def circle(rows, o, i, n):
    """Return the unit tangent at particle i for segments of different lengths: that of the circle through three
    particles, e₁ / |e₁|² + e₂ / |e₂|² with the segments e₁ before and e₂ after; arguments as in `difference`."""
    if i == 0 or i == n - 1:
        return difference(rows, o, i, n)
    ax, ay, az = between(rows, o, i, i + 1)
    bx, by, bz = between(rows, o, i + 1, i + 2)
    f = bx * bx + by * by + bz * bz
    g = ax * ax + ay * ay + az * az
    return unit(f * ax + g * bx, f * ay + g * by, f * az + g * bz)


@device
def printed(rows, o, i, n):
    """Return the unit tangent at particle i as the source prints it, but toward the tip; arguments as in `difference`.

    v = p_i − p_{i−1}, w = p_i − p_{i+1} (printed p_{i−2}), u = v × w, t = u × (v + w); zero if |u| or |v + w| is less
    than `STRAIGHT`, whatever the scale of the scene."""
    if i == 0 or i == n - 1:
        return difference(rows, o, i, n)
    vx, vy, vz = between(rows, o, i, i + 1)
    wx, wy, wz = between(rows, o, i + 2, i + 1)
    ux = vy * wz - vz * wy
    uy = vz * wx - vx * wz
    uz = vx * wy - vy * wx
    sx = vx + wx
    sy = vy + wy
    sz = vz + wz
    # (v + w) × u, the opposite of the source's sign, for a tangent toward the tip
    tx, ty, tz = unit(sy * uz - sz * uy, sz * ux - sx * uz, sx * uy - sy * ux)
    least = STRAIGHT * STRAIGHT
    bent = (ux * ux + uy * uy + uz * uz >= least) & (sx * sx + sy * sy + sz * sz >= least)
    return where(bent, tx, ZERO), where(bent, ty, ZERO), where(bent, tz, ZERO)


@device
def tangent(rows, o, i, n, lengths, as_printed):
    """Return the unit tangent at particle i: `printed` if `as_printed`, `circle` if lengths is None, else
    `difference`."""
    if as_printed:
        return printed(rows, o, i, n)
    if lengths is None:
        return circle(rows, o, i, n)
    return difference(rows, o, i, n)


@device
def find_tangents(positions, s, lengths, as_printed, out):
    """Write the tangents at all particles of the strands s … s + `LANES` − 1 to out (n, 3, `LANES`): at the root by
    `difference`; other arguments as in `curves.flatten`."""
    rows, found = pointer(positions), pointer(out)
    n = positions.shape[1] - 1
    o = first_place(positions, s)
    x, y, z = difference(rows, o, 0, n)
    store3(found, 0, LANES, x, y, z)
    for i in range(1, n):
        x, y, z = tangent(rows, o, i, n, lengths, as_printed)
        store3(found, 3 * LANES * i, LANES, x, y, z)


@device
def first_place(positions, s):
    """Return the place of strand s in the first row of its block."""
    return s // W * positions.shape[1] * STEP + s % W
