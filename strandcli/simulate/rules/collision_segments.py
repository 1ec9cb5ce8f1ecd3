"""Catching a segment that passes through a solid between two particles outside of it (``segments: true``).

The deepest point of the segment lies at a share t of the way from the parent to the particle. Moving the particle by
depth / t along the surface normal there brings that point out, exactly for a flat surface. Where t is small the parent
itself is at the surface, and the push is bounded by `REACH`. The segment then gets the length back that it had: it has
been turned, not stretched, so that elasticity, where it comes after collision, does not pull its particle from the
surface into another solid. The sweeps repeat: a few times is enough because later steps go on from there.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba.extending import register_jitable

from ...constants import W

ZERO = np.float32(0)
HALF = np.float32(0.5)
ONE = np.float32(1)
TWO = np.float32(2)
REACH = np.float32(0.1)
CENTRED = np.float32(1e-8)  # squared share of the radius: nearer to the middle, rounding has taken the direction
SWEEPS = 2
ALONG = np.float32(1e-6)  # squared sine of the angle under which two axes are parallel


def sphere(x: Any, parent: Any, grandparent: Any, root: Any, length: Any, p: Any, i: int, n: int) -> None:
    """p (m, 5): centre, radius, tiny."""
    for s in range(p.shape[0]):
        r = p[s, 3]
        tiny = p[s, 4]
        for _ in range(SWEEPS):
            for k in range(W):
                qx = parent[k] - p[s, 0]
                qy = parent[W + k] - p[s, 1]
                qz = parent[2 * W + k] - p[s, 2]
                ex = x[k] - parent[k]
                ey = x[W + k] - parent[W + k]
                ez = x[2 * W + k] - parent[2 * W + k]
                t = -(qx * ex + qy * ey + qz * ez) / max(ex * ex + ey * ey + ez * ez, tiny)
                t = min(max(t, ZERO), ONE)
                cx = qx + t * ex
                cy = qy + t * ey
                cz = qz + t * ez
                square = cx * cx + cy * cy + cz * cz
                # a segment through the centre leaves sideways: along x × y of its direction, or along x
                flat = ex * ex + ez * ez
                centred = square <= CENTRED * r * r
                cx = (ez if flat > tiny else ONE) if centred else cx
                cy = ZERO if centred else cy
                cz = (-ex if flat > tiny else ZERO) if centred else cz
                size = math.sqrt(max(cx * cx + cy * cy + cz * cz, tiny))
                out = r if centred else max(r - size, ZERO)
                out = out / (max(t, REACH) * size) if t > ZERO else ZERO
                nx = ex + cx * out
                ny = ey + cy * out
                nz = ez + cz * out
                keep = math.sqrt((ex * ex + ey * ey + ez * ez) / max(nx * nx + ny * ny + nz * nz, tiny))
                x[k] = parent[k] + nx * keep if out > ZERO else x[k]
                x[W + k] = parent[W + k] + ny * keep if out > ZERO else x[W + k]
                x[2 * W + k] = parent[2 * W + k] + nz * keep if out > ZERO else x[2 * W + k]


@register_jitable(error_model="numpy")  # rules are run as plain Python, too, where `blame` looks for a culprit
def in_reach(x: Any, parent: Any, p: Any, s: int) -> int:
    """Number of lanes whose segment may touch the ball about capsule s, by (a + b)² <= 2 (a² + b²)."""
    bx = p[s, 3]
    by = p[s, 4]
    bz = p[s, 5]
    mx = p[s, 0] + HALF * bx
    my = p[s, 1] + HALF * by
    mz = p[s, 2] + HALF * bz
    reach = HALF * math.sqrt(bx * bx + by * by + bz * bz) + p[s, 6]
    reach *= reach
    near = 0
    for k in range(W):
        dx = x[k] - mx
        dy = x[W + k] - my
        dz = x[2 * W + k] - mz
        ex = x[k] - parent[k]
        ey = x[W + k] - parent[W + k]
        ez = x[2 * W + k] - parent[2 * W + k]
        square = ex * ex + ey * ey + ez * ez
        near += 1 if dx * dx + dy * dy + dz * dz <= TWO * (reach + square) else 0
    return near


def capsule(x: Any, parent: Any, grandparent: Any, root: Any, length: Any, p: Any, i: int, n: int) -> None:
    """p (m, 9): first end, vector to the other end, radius, 1 / its squared length, tiny.

    Closest points of two segments by the clamped 2 × 2 system (Ericson 2005, §5.1.9).
    """
    for s in range(p.shape[0]):
        bx = p[s, 3]
        by = p[s, 4]
        bz = p[s, 5]
        r = p[s, 6]
        per = p[s, 7]
        tiny = p[s, 8]
        bb = bx * bx + by * by + bz * bz
        if in_reach(x, parent, p, s) == 0:
            continue
        for _ in range(SWEEPS):
            for k in range(W):
                ex = x[k] - parent[k]
                ey = x[W + k] - parent[W + k]
                ez = x[2 * W + k] - parent[2 * W + k]
                rx = parent[k] - p[s, 0]
                ry = parent[W + k] - p[s, 1]
                rz = parent[2 * W + k] - p[s, 2]
                ee = max(ex * ex + ey * ey + ez * ez, tiny)
                eb = ex * bx + ey * by + ez * bz
                er = ex * rx + ey * ry + ez * rz
                br = bx * rx + by * ry + bz * rz
                area = ee * bb - eb * eb
                t = (eb * br - er * bb) / area if area > tiny else ZERO
                t = min(max(t, ZERO), ONE)
                u = min(max((br + t * eb) * per, ZERO), ONE)
                t = min(max((u * eb - er) / ee, ZERO), ONE)
                cx = rx + t * ex - u * bx
                cy = ry + t * ey - u * by
                cz = rz + t * ez - u * bz
                square = cx * cx + cy * cy + cz * cz
                centred = square <= CENTRED * r * r
                # crossing axes part along the normal of both, parallel ones sideways as from a sphere
                flat = ex * ex + ez * ez
                askew = area > ALONG * ee * bb
                nx = ey * bz - ez * by if askew else (ez if flat > tiny else ONE)
                ny = ez * bx - ex * bz if askew else ZERO
                nz = ex * by - ey * bx if askew else (-ex if flat > tiny else ZERO)
                cx = nx if centred else cx
                cy = ny if centred else cy
                cz = nz if centred else cz
                size = math.sqrt(max(cx * cx + cy * cy + cz * cz, tiny))
                out = r if centred else max(r - size, ZERO)
                out = out / (max(t, REACH) * size) if t > ZERO else ZERO
                nx = ex + cx * out
                ny = ey + cy * out
                nz = ez + cz * out
                keep = math.sqrt((ex * ex + ey * ey + ez * ez) / max(nx * nx + ny * ny + nz * nz, tiny))
                x[k] = parent[k] + nx * keep if out > ZERO else x[k]
                x[W + k] = parent[W + k] + ny * keep if out > ZERO else x[W + k]
                x[2 * W + k] = parent[2 * W + k] + nz * keep if out > ZERO else x[2 * W + k]


def box(x: Any, parent: Any, grandparent: Any, root: Any, length: Any, p: Any, i: int, n: int) -> None:
    """p (m, 16): centre, rotation by rows, half extents, tiny. The middle of the part inside leaves by its nearest
    face."""
    for s in range(p.shape[0]):
        tiny = p[s, 15]
        for _ in range(SWEEPS):
            for k in range(W):
                qx = parent[k] - p[s, 0]
                qy = parent[W + k] - p[s, 1]
                qz = parent[2 * W + k] - p[s, 2]
                ex = x[k] - parent[k]
                ey = x[W + k] - parent[W + k]
                ez = x[2 * W + k] - parent[2 * W + k]
                qu = p[s, 3] * qx + p[s, 6] * qy + p[s, 9] * qz
                qv = p[s, 4] * qx + p[s, 7] * qy + p[s, 10] * qz
                qw = p[s, 5] * qx + p[s, 8] * qy + p[s, 11] * qz
                eu = p[s, 3] * ex + p[s, 6] * ey + p[s, 9] * ez
                ev = p[s, 4] * ex + p[s, 7] * ey + p[s, 10] * ez
                ew = p[s, 5] * ex + p[s, 8] * ey + p[s, 11] * ez
                au = ONE / (eu if abs(eu) > tiny else tiny)
                av = ONE / (ev if abs(ev) > tiny else tiny)
                aw = ONE / (ew if abs(ew) > tiny else tiny)
                enter = max(-qu * au - abs(au) * p[s, 12], -qv * av - abs(av) * p[s, 13])
                enter = max(max(enter, -qw * aw - abs(aw) * p[s, 14]), ZERO)
                leave = min(-qu * au + abs(au) * p[s, 12], -qv * av + abs(av) * p[s, 13])
                leave = min(min(leave, -qw * aw + abs(aw) * p[s, 14]), ONE)
                t = HALF * (enter + leave)
                u = qu + t * eu
                v = qv + t * ev
                w = qw + t * ew
                du = p[s, 12] - abs(u)
                dv = p[s, 13] - abs(v)
                dw = p[s, 14] - abs(w)
                least = min(du, min(dv, dw))
                inside = max(least, ZERO) / max(t, REACH) if leave > enter else ZERO
                by_u = inside if du <= least else ZERO
                by_v = inside if (dv <= least) and (du > least) else ZERO
                by_w = inside - by_u - by_v
                by_u = by_u if u >= ZERO else -by_u
                by_v = by_v if v >= ZERO else -by_v
                by_w = by_w if w >= ZERO else -by_w
                nx = ex + p[s, 3] * by_u + p[s, 4] * by_v + p[s, 5] * by_w
                ny = ey + p[s, 6] * by_u + p[s, 7] * by_v + p[s, 8] * by_w
                nz = ez + p[s, 9] * by_u + p[s, 10] * by_v + p[s, 11] * by_w
                keep = math.sqrt((ex * ex + ey * ey + ez * ez) / max(nx * nx + ny * ny + nz * nz, tiny))
                x[k] = parent[k] + nx * keep if inside > ZERO else x[k]
                x[W + k] = parent[W + k] + ny * keep if inside > ZERO else x[W + k]
                x[2 * W + k] = parent[2 * W + k] + nz * keep if inside > ZERO else x[2 * W + k]
