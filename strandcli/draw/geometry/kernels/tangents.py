"""Tangents of strands at their particles, from root to tip."""

from __future__ import annotations

import numpy as np

from ....constants import W
from ....jit import device

ZERO = np.float32(0.0)
ONE = np.float32(1.0)
TINY = np.float32(1e-30)
STRAIGHT = np.float32(0.1)
"""Length below which the source's construction has no tangent, see `printed`."""


@device
def difference(block, lane, i, n):
    """Return the unit tangent at particle i, toward the tip: the central difference p_{i+1} − p_{i−1}; zero at the tip.

    For equal segments it is the direction that the source constructs, but never singular. block (n + 1, 3 W): row i + 1
    is particle i, row 0 stands one segment before the root."""
    if i == n - 1:
        return ZERO, ZERO, ZERO
    high = i + 2 if i > 0 else 1  # the root: from the row before it, the strand's direction
    x = block[high, lane] - block[i, lane]
    y = block[high, W + lane] - block[i, W + lane]
    z = block[high, 2 * W + lane] - block[i, 2 * W + lane]
    size = ONE / np.sqrt(max(x * x + y * y + z * z, TINY))
    return x * size, y * size, z * size


@device
def circle(block, lane, i, n):
    """Return the unit tangent at particle i for segments of different lengths: that of the circle through three
    particles, e₁ / |e₁|² + e₂ / |e₂|² with the segments e₁ before and e₂ after; arguments as in `difference`."""
    if i == 0 or i == n - 1:
        return difference(block, lane, i, n)
    ax = block[i + 1, lane] - block[i, lane]
    ay = block[i + 1, W + lane] - block[i, W + lane]
    az = block[i + 1, 2 * W + lane] - block[i, 2 * W + lane]
    bx = block[i + 2, lane] - block[i + 1, lane]
    by = block[i + 2, W + lane] - block[i + 1, W + lane]
    bz = block[i + 2, 2 * W + lane] - block[i + 1, 2 * W + lane]
    f = bx * bx + by * by + bz * bz
    g = ax * ax + ay * ay + az * az
    x = f * ax + g * bx
    y = f * ay + g * by
    z = f * az + g * bz
    size = ONE / np.sqrt(max(x * x + y * y + z * z, TINY))
    return x * size, y * size, z * size


@device
def printed(block, lane, i, n):
    """Return the unit tangent at particle i as the source prints it, but toward the tip; arguments as in `difference`.

    v = p_i − p_{i−1}, w = p_i − p_{i+1} (printed p_{i−2}), u = v × w, t = u × (v + w); zero if |u| or |v + w| is less
    than `STRAIGHT`, whatever the scale of the scene."""
    if i == 0 or i == n - 1:
        return difference(block, lane, i, n)
    vx = block[i + 1, lane] - block[i, lane]
    vy = block[i + 1, W + lane] - block[i, W + lane]
    vz = block[i + 1, 2 * W + lane] - block[i, 2 * W + lane]
    wx = block[i + 1, lane] - block[i + 2, lane]
    wy = block[i + 1, W + lane] - block[i + 2, W + lane]
    wz = block[i + 1, 2 * W + lane] - block[i + 2, 2 * W + lane]
    ux = vy * wz - vz * wy
    uy = vz * wx - vx * wz
    uz = vx * wy - vy * wx
    sx = vx + wx
    sy = vy + wy
    sz = vz + wz
    # (v + w) × u, the opposite of the source's sign, for a tangent toward the tip
    tx = sy * uz - sz * uy
    ty = sz * ux - sx * uz
    tz = sx * uy - sy * ux
    bent = ux * ux + uy * uy + uz * uz >= STRAIGHT * STRAIGHT and sx * sx + sy * sy + sz * sz >= STRAIGHT * STRAIGHT
    size = ONE / np.sqrt(max(tx * tx + ty * ty + tz * tz, TINY)) if bent else ZERO
    return tx * size, ty * size, tz * size


@device
def tangent(block, lane, i, n, lengths, as_printed):
    """Return the unit tangent at particle i: `printed` if `as_printed`, `circle` if lengths is None, else
    `difference`."""
    if as_printed:
        return printed(block, lane, i, n)
    if lengths is None:
        return circle(block, lane, i, n)
    return difference(block, lane, i, n)
