"""Collision of whole segments, which may pass through a solid between two particles outside of it
(``segments: true``): passes of the stage "particle" (`rule.Pass`); columns of p in `strandcli.solids.shapes`.

The deepest point of the segment lies at a share t of the way from the parent to the particle. Moving the particle by
depth / t along the surface normal there brings that point out, exactly for a flat surface. If t is small the parent
itself is at the surface; `LEAST_SHARE` bounds the displacement. The segment is then scaled to its length from before:
it is turned, not stretched, so that elasticity, if it follows collision, does not pull its particle from the surface
into another solid. A few sweeps are enough, because later steps continue from the result.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba.extending import register_jitable

from ...constants import W
from ...solids.kernels.capsule import bounding_ball
from ...solids.shapes import box as boxes
from ...solids.shapes import capsule as capsules
from ...solids.shapes import sphere as balls

ZERO = np.float32(0)
HALF = np.float32(0.5)
ONE = np.float32(1)
TWO = np.float32(2)
LEAST_SHARE = np.float32(0.1)
"""Least t by which the depth is divided."""
CENTRED = np.float32(1e-8)
"""Squared share of the radius; nearer to the centre, rounding has destroyed the direction."""
SWEEPS = 2
PARALLEL = np.float32(1e-6)
"""Squared sine of the angle below which two axes count as parallel."""


def sphere(x: Any, parent: Any, grandparent: Any, root: Any, length: Any, p: Any, i: int, n: int) -> None:
    """Turn segments out of balls; p: packed spheres."""
    for s in range(p.shape[0]):
        r = p[s, balls.RADIUS]
        tiny = p[s, balls.LEAST]
        for _ in range(SWEEPS):
            for k in range(W):
                qx = parent[k] - p[s, balls.X]
                qy = parent[W + k] - p[s, balls.Y]
                qz = parent[2 * W + k] - p[s, balls.Z]
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
                out = out / (max(t, LEAST_SHARE) * size) if t > ZERO else ZERO
                nx = ex + cx * out
                ny = ey + cy * out
                nz = ez + cz * out
                keep = math.sqrt((ex * ex + ey * ey + ez * ez) / max(nx * nx + ny * ny + nz * nz, tiny))
                x[k] = parent[k] + nx * keep if out > ZERO else x[k]
                x[W + k] = parent[W + k] + ny * keep if out > ZERO else x[W + k]
                x[2 * W + k] = parent[2 * W + k] + nz * keep if out > ZERO else x[2 * W + k]


@register_jitable(error_model="numpy")  # for plain Python too, in which `health` runs passes
def in_reach(x: Any, parent: Any, p: Any, s: int) -> int:
    """Return the number of lanes whose segment may touch the bounding ball of capsule s, by (a + b)² <= 2 (a² + b²)."""
    mx, my, mz, reach = bounding_ball(p, s)
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
    """Turn segments out of capsules, by the closest points of two segments from a clamped 2 × 2 system (Ericson 2005,
    §5.1.9); p: packed capsules.
    """
    for s in range(p.shape[0]):
        bx = p[s, capsules.AXIS_X]
        by = p[s, capsules.AXIS_Y]
        bz = p[s, capsules.AXIS_Z]
        r = p[s, capsules.RADIUS]
        per = p[s, capsules.PER_SQUARE]
        tiny = p[s, capsules.LEAST]
        bb = bx * bx + by * by + bz * bz
        if in_reach(x, parent, p, s) == 0:
            continue
        for _ in range(SWEEPS):
            for k in range(W):
                ex = x[k] - parent[k]
                ey = x[W + k] - parent[W + k]
                ez = x[2 * W + k] - parent[2 * W + k]
                rx = parent[k] - p[s, capsules.X]
                ry = parent[W + k] - p[s, capsules.Y]
                rz = parent[2 * W + k] - p[s, capsules.Z]
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
                askew = area > PARALLEL * ee * bb
                nx = ey * bz - ez * by if askew else (ez if flat > tiny else ONE)
                ny = ez * bx - ex * bz if askew else ZERO
                nz = ex * by - ey * bx if askew else (-ex if flat > tiny else ZERO)
                cx = nx if centred else cx
                cy = ny if centred else cy
                cz = nz if centred else cz
                size = math.sqrt(max(cx * cx + cy * cy + cz * cz, tiny))
                out = r if centred else max(r - size, ZERO)
                out = out / (max(t, LEAST_SHARE) * size) if t > ZERO else ZERO
                nx = ex + cx * out
                ny = ey + cy * out
                nz = ez + cz * out
                keep = math.sqrt((ex * ex + ey * ey + ez * ez) / max(nx * nx + ny * ny + nz * nz, tiny))
                x[k] = parent[k] + nx * keep if out > ZERO else x[k]
                x[W + k] = parent[W + k] + ny * keep if out > ZERO else x[W + k]
                x[2 * W + k] = parent[2 * W + k] + nz * keep if out > ZERO else x[2 * W + k]


def box(x: Any, parent: Any, grandparent: Any, root: Any, length: Any, p: Any, i: int, n: int) -> None:
    """Turn segments out of boxes: the middle of the part inside leaves by its nearest face; p: packed boxes."""
    for s in range(p.shape[0]):
        tiny = p[s, boxes.LEAST]
        for _ in range(SWEEPS):
            for k in range(W):
                qx = parent[k] - p[s, boxes.X]
                qy = parent[W + k] - p[s, boxes.Y]
                qz = parent[2 * W + k] - p[s, boxes.Z]
                ex = x[k] - parent[k]
                ey = x[W + k] - parent[W + k]
                ez = x[2 * W + k] - parent[2 * W + k]
                qu = p[s, boxes.ROW_X] * qx + p[s, boxes.ROW_Y] * qy + p[s, boxes.ROW_Z] * qz
                qv = p[s, boxes.ROW_X + 1] * qx + p[s, boxes.ROW_Y + 1] * qy + p[s, boxes.ROW_Z + 1] * qz
                qw = p[s, boxes.ROW_X + 2] * qx + p[s, boxes.ROW_Y + 2] * qy + p[s, boxes.ROW_Z + 2] * qz
                eu = p[s, boxes.ROW_X] * ex + p[s, boxes.ROW_Y] * ey + p[s, boxes.ROW_Z] * ez
                ev = p[s, boxes.ROW_X + 1] * ex + p[s, boxes.ROW_Y + 1] * ey + p[s, boxes.ROW_Z + 1] * ez
                ew = p[s, boxes.ROW_X + 2] * ex + p[s, boxes.ROW_Y + 2] * ey + p[s, boxes.ROW_Z + 2] * ez
                au = ONE / (eu if abs(eu) > tiny else tiny)
                av = ONE / (ev if abs(ev) > tiny else tiny)
                aw = ONE / (ew if abs(ew) > tiny else tiny)
                enter = max(-qu * au - abs(au) * p[s, boxes.HALF], -qv * av - abs(av) * p[s, boxes.HALF + 1])
                enter = max(max(enter, -qw * aw - abs(aw) * p[s, boxes.HALF + 2]), ZERO)
                leave = min(-qu * au + abs(au) * p[s, boxes.HALF], -qv * av + abs(av) * p[s, boxes.HALF + 1])
                leave = min(min(leave, -qw * aw + abs(aw) * p[s, boxes.HALF + 2]), ONE)
                t = HALF * (enter + leave)
                u = qu + t * eu
                v = qv + t * ev
                w = qw + t * ew
                du = p[s, boxes.HALF] - abs(u)
                dv = p[s, boxes.HALF + 1] - abs(v)
                dw = p[s, boxes.HALF + 2] - abs(w)
                least = min(du, min(dv, dw))
                inside = max(least, ZERO) / max(t, LEAST_SHARE) if leave > enter else ZERO
                by_u = inside if du <= least else ZERO
                by_v = inside if (dv <= least) and (du > least) else ZERO
                by_w = inside - by_u - by_v
                by_u = by_u if u >= ZERO else -by_u
                by_v = by_v if v >= ZERO else -by_v
                by_w = by_w if w >= ZERO else -by_w
                nx = ex + p[s, boxes.ROW_X] * by_u + p[s, boxes.ROW_X + 1] * by_v + p[s, boxes.ROW_X + 2] * by_w
                ny = ey + p[s, boxes.ROW_Y] * by_u + p[s, boxes.ROW_Y + 1] * by_v + p[s, boxes.ROW_Y + 2] * by_w
                nz = ez + p[s, boxes.ROW_Z] * by_u + p[s, boxes.ROW_Z + 1] * by_v + p[s, boxes.ROW_Z + 2] * by_w
                keep = math.sqrt((ex * ex + ey * ey + ez * ez) / max(nx * nx + ny * ny + nz * nz, tiny))
                x[k] = parent[k] + nx * keep if inside > ZERO else x[k]
                x[W + k] = parent[W + k] + ny * keep if inside > ZERO else x[W + k]
                x[2 * W + k] = parent[2 * W + k] + nz * keep if inside > ZERO else x[2 * W + k]
