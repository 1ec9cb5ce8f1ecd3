"""Rays against strands as cylinders with round ends, every ray against every piece near its bundle."""

from __future__ import annotations

import math

import numpy as np

from ...jit import function, parallel, prange


@function
def apart(ax, ay, az, dx, dy, dz, reach, px, py, pz, ex, ey, ez):
    """Square of the least distance between the ray a + t d, d a unit vector and 0 <= t <= reach, and the piece
    p … p + e (Ericson 2004, §5.1.9)."""
    wx = ax - px
    wy = ay - py
    wz = az - pz
    e = ex * ex + ey * ey + ez * ez
    b = dx * ex + dy * ey + dz * ez
    c = dx * wx + dy * wy + dz * wz
    f = ex * wx + ey * wy + ez * wz
    denominator = e - b * b
    t = min(max((b * f - c * e) / denominator, 0.0), reach) if denominator > 1e-30 else 0.0
    s = (b * t + f) / e if e > 0.0 else 0.0
    if s < 0.0:
        s = 0.0
        t = min(max(-c, 0.0), reach)
    elif s > 1.0:
        s = 1.0
        t = min(max(b - c, 0.0), reach)
    x = wx + t * dx - s * ex
    y = wy + t * dy - s * ey
    z = wz + t * dz - s * ez
    return x * x + y * y + z * z


@parallel
def lit(first, world, width, taper, probes, own, origins, directions, reaches, radius, out):
    """Share of each probe's rays that meet no strand but its own.

    first (S + 1,) int64; world (V, 3) float64; width at the root, of which `taper` is lost to the tip; probes (P, 3);
    own (P,) the strand that each lies on, or −1; origins (P, R, 3), directions (P, R, 3) unit, reaches (P, R) float64:
    rays, which all start within `radius` of their probe; out (P,).
    """
    strands = first.shape[0] - 1
    for p in prange(probes.shape[0]):
        hit = np.zeros(origins.shape[1], np.uint8)
        ax, ay, az = probes[p]
        dx, dy, dz = directions[p, 0]
        for s in range(strands):
            if s == own[p]:
                continue
            per = taper / max(first[s + 1] - first[s] - 1, 1)
            for v in range(first[s], first[s + 1] - 1):
                r = 0.5 * width * (1.0 - per * (v - first[s] + 0.5))
                ex = world[v + 1, 0] - world[v, 0]
                ey = world[v + 1, 1] - world[v, 1]
                ez = world[v + 1, 2] - world[v, 2]
                # can the bundle meet it at all? the piece as a ball, the bundle as a tube about its first ray
                mx = world[v, 0] + 0.5 * ex - ax
                my = world[v, 1] + 0.5 * ey - ay
                mz = world[v, 2] + 0.5 * ez - az
                along = mx * dx + my * dy + mz * dz
                off = mx * mx + my * my + mz * mz - along * along
                room = 2.1 * radius + r + 0.5 * math.sqrt(ex * ex + ey * ey + ez * ez)
                if off > room * room:
                    continue
                for k in range(origins.shape[1]):
                    if hit[k] == 0:
                        square = apart(
                            origins[p, k, 0], origins[p, k, 1], origins[p, k, 2],
                            directions[p, k, 0], directions[p, k, 1], directions[p, k, 2], reaches[p, k],
                            world[v, 0], world[v, 1], world[v, 2], ex, ey, ez,
                        )  # fmt: skip
                        if square < r * r:
                            hit[k] = 1
        out[p] = 1.0 - hit.mean()
