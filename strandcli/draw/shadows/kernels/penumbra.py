"""Soft shadows of solids: the visible share of a light that has a size.

A light is a disc of angular radius α around the direction to its centre. The signed angle from there to the edge of a
solid, as seen from the shaded point, is negative inside of the solid's outline. The least angle of all solids counts,
with an edge that is taken to be straight across the disc:

    visibility = 1 − (acos x − x √(1 − x²)) / π,  x = sin(angle) / sin α.

This is exact for planes, and otherwise where edges are straight over the light's width. Where several solids cover a
light from different sides it overestimates the visibility.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ....jit import device, inlined
from ....solids.shapes import box as box_columns
from ...common.kernels.approximations import asin
from ...common.kernels.numbers import HALF, INV_PI, ONE, ZERO

TINY = np.float32(1e-20)
SHARP = np.float32(1e-6)
"""Sine of the angular radius of a light without a size, in scenes where another light has one."""
CLEAR = np.float32(2.0)
"""Stands for no occlusion; greater than any sine."""
SURELY = np.float32(1.0001)
CLOSER = np.float32((math.sqrt(5.0) - 1.0) / 2.0)
"""Share of the interval that a step of a golden-section search leaves."""
STEPS = np.int64(32)
"""Steps of a search along the ray to the light."""


class LightRay(NamedTuple):
    """The ray from a point to a light's centre; numbers are float32."""

    x: Any
    """The point (x, y, z), metres."""
    y: Any
    z: Any
    lx: Any
    """The unit direction (lx, ly, lz) to the light's centre."""
    ly: Any
    lz: Any
    reach: Any
    """Distance to the light's centre, metres."""


@inlined
def share(least, radius):
    """Return the visible share of a light, from the sine of the least angle from its centre to an edge, and the sine of
    its angular radius."""
    side = max(least / radius, -ONE)
    visible = HALF + (side * math.sqrt(max(ONE - side * side, ZERO)) + asin(side)) * INV_PI
    return visible if side > -ONE else ZERO


@inlined
def ball(r, cx, cy, cz, lx, ly, lz, reach):
    """Return the sine of the angle from the light's centre to the edge of a ball of radius r, whose centre is at c
    relative to the point; `CLEAR` if it is not between the point and the light."""
    t = cx * lx + cy * ly + cz * lz
    cc = cx * cx + cy * cy + cz * cz
    ex = cx - t * lx
    ey = cy - t * ly
    ez = cz - t * lz
    off = math.sqrt(ex * ex + ey * ey + ez * ez)
    tangent = math.sqrt(max(cc - r * r, ZERO))
    ahead = (t > ZERO) | (t * tangent + off * r > ZERO)
    there = ahead & (tangent < reach) & (r > ZERO)
    return (off * tangent - t * r) / max(cc, TINY) if there else CLEAR


@inlined
def aside(r, cx, cy, cz, lx, ly, lz, radius):
    """Return whether a ball certainly leaves the whole light visible: its centre is farther from the ray than the sum
    of its radius and that of the cone around the light, whose sine is ``radius``."""
    t = cx * lx + cy * ly + cz * lz
    ex = cx - t * lx
    ey = cy - t * ly
    ez = cz - t * lz
    reach = r + t * radius
    off = ex * ex + ey * ey + ez * ez
    return (reach < ZERO) | (off * (ONE - radius * radius) > SURELY * reach * reach)


@device
def capsule(r, middle, axis, ray, radius):
    """Return the sine of the angle from the light's centre to the edge of a capsule, a box without width of which all
    within r metres is solid; middle: metres; axis: from end to end, metres; the rest as in `box`."""
    half = HALF * math.sqrt(axis[0] * axis[0] + axis[1] * axis[1] + axis[2] * axis[2])
    per = HALF / max(half, TINY)
    wx, wy, wz = axis[0] * per, axis[1] * per, axis[2] * per
    if half <= TINY:
        wz = ONE
    side = ONE if wz >= ZERO else -ONE  # two unit vectors across the axis (Duff et al. 2017)
    a = -ONE / (side + wz)
    b = wx * wy * a
    ux, uy, uz = ONE + side * wx * wx * a, side * b, -side * wx
    vx, vy, vz = b, side + wy * wy * a, -wy
    x, y, z = ray.x - middle[0], ray.y - middle[1], ray.z - middle[2]
    lx, ly, lz = ray.lx, ray.ly, ray.lz
    o = x * ux + y * uy + z * uz, x * vx + y * vy + z * vz, x * wx + y * wy + z * wz
    d = lx * ux + ly * uy + lz * uz, lx * vx + ly * vy + lz * vz, lx * wx + ly * wy + lz * wz
    return rounded_box(o, d, (ZERO, ZERO, half), r, ray.reach, radius)


@device
def box(p, m, ray, skin, radius):
    """Return the sine of the angle from the light's centre to the edge of row m of the boxes p.

    ray: `LightRay`; skin: metres; radius: sine of the light's angular radius. Angles greater than that radius may be
    overestimated.
    """
    x, y, z, lx, ly, lz, reach = ray
    cx, cy, cz = x - p[m, box_columns.X], y - p[m, box_columns.Y], z - p[m, box_columns.Z]
    ox = p[m, box_columns.ROW_X] * cx + p[m, box_columns.ROW_Y] * cy + p[m, box_columns.ROW_Z] * cz
    oy = p[m, box_columns.ROW_X + 1] * cx + p[m, box_columns.ROW_Y + 1] * cy + p[m, box_columns.ROW_Z + 1] * cz
    oz = p[m, box_columns.ROW_X + 2] * cx + p[m, box_columns.ROW_Y + 2] * cy + p[m, box_columns.ROW_Z + 2] * cz
    dx = p[m, box_columns.ROW_X] * lx + p[m, box_columns.ROW_Y] * ly + p[m, box_columns.ROW_Z] * lz
    dy = p[m, box_columns.ROW_X + 1] * lx + p[m, box_columns.ROW_Y + 1] * ly + p[m, box_columns.ROW_Z + 1] * lz
    dz = p[m, box_columns.ROW_X + 2] * lx + p[m, box_columns.ROW_Y + 2] * ly + p[m, box_columns.ROW_Z + 2] * lz
    hx = p[m, box_columns.HALF] - skin
    hy = p[m, box_columns.HALF + 1] - skin
    hz = p[m, box_columns.HALF + 2] - skin
    if min(hx, min(hy, hz)) <= ZERO:
        return CLEAR
    return rounded_box((ox, oy, oz), (dx, dy, dz), (hx, hy, hz), ZERO, reach, radius)


@device
def rounded_box(o, d, h, r, reach, radius):
    """Return the sine of the angle to the edge of a box of half extents h about the origin, all within r metres of
    which is solid: the least quotient of its distance and the distance along the ray from o along d, which has a single
    minimum because it is convex."""
    around = math.sqrt(h[0] * h[0] + h[1] * h[1] + h[2] * h[2]) + r
    if aside(around, -o[0], -o[1], -o[2], d[0], d[1], d[2], radius):
        return CLEAR
    high = min(around - (o[0] * d[0] + o[1] * d[1] + o[2] * d[2]), reach)
    if high <= ZERO:
        return CLEAR
    return lowest_on_ray((*o, *d, *h, r), high)


@device
def on_ray(t, at):
    """Return the distance of a box, less r, from the point at distance t from o along d, divided by t."""
    ox, oy, oz, dx, dy, dz, hx, hy, hz, r = at
    ax, ay, az = abs(ox + t * dx) - hx, abs(oy + t * dy) - hy, abs(oz + t * dz) - hz
    ox, oy, oz = max(ax, ZERO), max(ay, ZERO), max(az, ZERO)
    return (math.sqrt(ox * ox + oy * oy + oz * oz) + min(max(ax, max(ay, az)), ZERO) - r) / t


@device
def lowest_on_ray(at, high):
    """Return the least `on_ray` up to a distance t, by golden-section search: there is a single minimum."""
    low = high * SHARP
    near, far = high - CLOSER * (high - low), low + CLOSER * (high - low)
    at_near, at_far = on_ray(near, at), on_ray(far, at)
    for _ in range(STEPS):
        if at_near < at_far:
            high = far
            far = near
            at_far = at_near
            near = high - CLOSER * (high - low)
            at_near = on_ray(near, at)
        else:
            low = near
            near = far
            at_near = at_far
            far = low + CLOSER * (high - low)
            at_far = on_ray(far, at)
    return min(at_near, at_far)
