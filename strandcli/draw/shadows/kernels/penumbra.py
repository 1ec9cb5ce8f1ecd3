"""Shadows of solids in lights that have a size: how much of a round light stands free of them.

A light is a disc of angular radius α about the direction to its middle. The angle from there to the edge of a solid, as
seen from a point, is negative inside; of all solids the least one counts, as if its edge were straight where it cuts
the disc:

    1 − (acos x − x √(1 − x²)) / π,  x = sin(angle) / sin α.

Exact for planes; else for edges that are straight over the light's width. Where several solids cut a light from
different sides, too much of it is left.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ....jit import device, function, inlined
from ....solids.kernels import other
from ...common.kernels.approximations import asin
from ...common.kernels.light_columns import KIND, LIGHT_SIZE
from ...solids.kernels import rays

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
TINY = np.float32(1e-20)
SHARP = np.float32(1e-6)
"""Sine of the radius of a light without a size among others."""
CLEAR = np.float32(2.0)
"""More than any sine: not in the way at all."""
SURELY = np.float32(1.0001)
INV_PI = np.float32(1 / math.pi)
CLOSER = np.float32((math.sqrt(5.0) - 1.0) / 2.0)
STEPS = np.int64(32)
"""Of a search along the way to the light."""
ALONG = np.int64(16)
"""Along an axis."""


class LightRay(NamedTuple):
    """The way from a point to a light's middle; numbers are float32."""

    x: Any
    """The point (x, y, z), metres."""
    y: Any
    z: Any
    lx: Any
    """The unit direction (lx, ly, lz) to the light's middle."""
    ly: Any
    lz: Any
    reach: Any
    """Metres to the light's middle."""


class Axis(NamedTuple):
    """A capsule's axis; numbers are float32."""

    x: Any
    """The vector (x, y, z) from its first end to the other, metres."""
    y: Any
    z: Any
    square: Any
    """The vector's squared length, metres²."""


@device
def past(solids, ray, skin, lights, i, sized):
    """Share of light number i that solids leave along a `LightRay`: `rays.lit`, or `lit` where any light has a size."""
    if sized is None:
        return rays.lit(solids, ray.x, ray.y, ray.z, ray.lx, ray.ly, ray.lz, ray.reach, skin)
    return lit(solids, ray, skin, lights[i, LIGHT_SIZE], lights[i, KIND])


@function
def lit(solids, ray, skin, size, point):
    """Share of a round light, 0 to 1, that a point sees past all `strandcli.solids.Solids`.

    ray: `LightRay`; skin: metres, as in `rays.lit`; size: sine of the light's angular radius, or where ``point`` is 1
    its radius in metres.
    """
    x, y, z, lx, ly, lz, reach = ray
    radius = seen_from(size, point, reach)
    x += skin * lx
    y += skin * ly
    z += skin * lz
    least = radius
    for m in range(solids.spheres.shape[0]):
        r = solids.spheres[m, 3] - skin
        cx = solids.spheres[m, 0] - x
        cy = solids.spheres[m, 1] - y
        cz = solids.spheres[m, 2] - z
        least = min(least, ball(r, cx, cy, cz, lx, ly, lz, reach))
    for m in range(solids.capsules.shape[0]):
        if least > -radius:
            lifted = LightRay(x, y, z, lx, ly, lz, reach)
            least = min(least, capsule(solids.capsules, m, lifted, skin, radius))
    for m in range(solids.planes.shape[0]):
        over = solids.planes[m, 0] * x + solids.planes[m, 1] * y + solids.planes[m, 2] * z - solids.planes[m, 3]
        up = solids.planes[m, 0] * lx + solids.planes[m, 1] * ly + solids.planes[m, 2] * lz
        if over >= ZERO:
            least = min(least, over / reach + up)
    for m in range(solids.boxes.shape[0]):
        if least > -radius:
            lifted = LightRay(x, y, z, lx, ly, lz, reach)
            least = min(least, box(solids.boxes, m, lifted, skin, radius))
    least = min(least, other.lowest_sine(solids, x, y, z, lx, ly, lz, reach, skin))
    return share(least, radius)


@inlined
def seen_from(size, point, reach):
    """Sine of a light's angular radius, from a point at that distance."""
    return max(min(size / reach, ONE) if point > ZERO else size, SHARP)


@inlined
def share(least, radius):
    """Share of a light that is left, from the sines of the least angle from its middle to an edge and of its radius."""
    side = max(least / radius, -ONE)
    return HALF + (side * math.sqrt(max(ONE - side * side, ZERO)) + asin(side)) * INV_PI


@inlined
def ball(r, cx, cy, cz, lx, ly, lz, reach):
    """Sine of the angle from the light's middle to the edge of a ball whose centre is at c from the point."""
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
    """Whether a light is surely seen past a whole ball: its centre is further off the light's middle line, t along
    it, than what the cone about the light, of sine ``radius``, and the ball itself reach."""
    t = cx * lx + cy * ly + cz * lz
    ex = cx - t * lx
    ey = cy - t * ly
    ez = cz - t * lz
    return beside(r, ex * ex + ey * ey + ez * ez, t, radius)


@inlined
def beside(r, off, t, radius):
    """Whether a light is surely seen past a ball, as `aside`; off: squared distance of the centre off the line."""
    reach = r + t * radius
    return (reach < ZERO) | (off * (ONE - radius * radius) > SURELY * reach * reach)


@device
def capsule(p, m, ray, skin, radius):
    """Sine of the angle from the light's middle to the edge of row m of the capsules p: the least `ball` on the axis,
    along which there is one minimum, since a capsule is convex.

    ray: `LightRay`; skin: metres; radius: sine of the light's own; angles beyond that may be found too large.
    """
    x, y, z, lx, ly, lz, reach = ray
    bx = p[m, 3]
    by = p[m, 4]
    bz = p[m, 5]
    r = p[m, 6] - skin
    wx = p[m, 0] - x
    wy = p[m, 1] - y
    wz = p[m, 2] - z
    bb = bx * bx + by * by + bz * bz
    around = r + HALF * math.sqrt(bb)
    if r <= ZERO or aside(around, wx + HALF * bx, wy + HALF * by, wz + HALF * bz, lx, ly, lz, radius):
        return CLEAR
    free, s = nearest(r, wx, wy, wz, Axis(bx, by, bz, bb), lx, ly, lz, radius)
    if free:
        return CLEAR
    least = ball(r, wx + s * bx, wy + s * by, wz + s * bz, lx, ly, lz, reach)
    if least <= -radius:  # the whole light is hidden already
        return least
    return min(least, lowest_on_axis((r, wx, wy, wz, bx, by, bz, lx, ly, lz, reach), ZERO, ONE, ALONG))


@inlined
def nearest(r, wx, wy, wz, axis, lx, ly, lz, radius):
    """Whether a light is surely seen past a whole capsule, and the place in [0, 1] on its axis nearest to the way to
    the light.

    r: metres; w: from the point to the first end of the `Axis`; radius: sine of the light's own.
    """
    bx, by, bz, bb = axis
    bw = -(bx * wx + by * wy + bz * wz)
    bl = bx * lx + by * ly + bz * lz
    lw = lx * wx + ly * wy + lz * wz
    askew = bb - bl * bl
    crosses = askew > SHARP * bb
    s = min(max((bw + bl * lw) / askew, ZERO), ONE) if crosses else ZERO
    t = lw + s * bl
    ex = wx + s * bx - t * lx
    ey = wy + s * by - t * ly
    ez = wz + s * bz - t * lz
    free = beside(r, ex * ex + ey * ey + ez * ez, lw + max(bl, ZERO), radius)
    t = max((bl * bw + bb * lw) / askew, ZERO) if crosses else ZERO
    return free, min(max((bw + t * bl) / max(bb, TINY), ZERO), ONE)


@device
def box(p, m, ray, skin, radius):
    """Sine of the angle from the light's middle to the edge of row m of the boxes p: the least of the box's distance
    over the distance travelled, which has one minimum on the way to the light because a box is convex.

    ray: `LightRay`; skin: metres; radius: sine of the light's own; angles beyond that may be found too large.
    """
    x, y, z, lx, ly, lz, reach = ray
    cx = x - p[m, 0]
    cy = y - p[m, 1]
    cz = z - p[m, 2]
    ox = p[m, 3] * cx + p[m, 6] * cy + p[m, 9] * cz
    oy = p[m, 4] * cx + p[m, 7] * cy + p[m, 10] * cz
    oz = p[m, 5] * cx + p[m, 8] * cy + p[m, 11] * cz
    dx = p[m, 3] * lx + p[m, 6] * ly + p[m, 9] * lz
    dy = p[m, 4] * lx + p[m, 7] * ly + p[m, 10] * lz
    dz = p[m, 5] * lx + p[m, 8] * ly + p[m, 11] * lz
    hx = p[m, 12] - skin
    hy = p[m, 13] - skin
    hz = p[m, 14] - skin
    around = math.sqrt(hx * hx + hy * hy + hz * hz)
    if min(hx, min(hy, hz)) <= ZERO or aside(around, -ox, -oy, -oz, dx, dy, dz, radius):
        return CLEAR
    high = min(around - (ox * dx + oy * dy + oz * dz), reach)
    if high <= ZERO:
        return CLEAR
    return lowest_on_way((ox, oy, oz, dx, dy, dz, hx, hy, hz), high * SHARP, high, STEPS)


@device
def away(x, y, z, hx, hy, hz):
    """Distance of a point from a box of half extents h about the origin, negative inside."""
    ax = abs(x) - hx
    ay = abs(y) - hy
    az = abs(z) - hz
    ox = max(ax, ZERO)
    oy = max(ay, ZERO)
    oz = max(az, ZERO)
    return math.sqrt(ox * ox + oy * oy + oz * oz) + min(max(ax, max(ay, az)), ZERO)


@device
def on_axis(s, at):
    """`ball` of the ball at the place s of a capsule's axis, from w along b."""
    r, wx, wy, wz, bx, by, bz, lx, ly, lz, reach = at
    return ball(r, wx + s * bx, wy + s * by, wz + s * bz, lx, ly, lz, reach)


@device
def on_way(t, at):
    """A box's distance, at the distance t from o along d, over t."""
    ox, oy, oz, dx, dy, dz, hx, hy, hz = at
    return away(ox + t * dx, oy + t * dy, oz + t * dz, hx, hy, hz) / t


def search(of: Any) -> Any:
    """A kernel's search for the least value of a function of (t, at): (at, low, high, steps) to that value, where
    between low and high there is one minimum. By golden sections."""

    @device
    def lowest(at, low, high, steps):
        near = high - CLOSER * (high - low)
        far = low + CLOSER * (high - low)
        at_near = of(near, at)
        at_far = of(far, at)
        for _ in range(steps):
            if at_near < at_far:
                high = far
                far = near
                at_far = at_near
                near = high - CLOSER * (high - low)
                at_near = of(near, at)
            else:
                low = near
                near = far
                at_near = at_far
                far = low + CLOSER * (high - low)
                at_far = of(far, at)
        return min(at_near, at_far)

    return lowest


lowest_on_axis = search(on_axis)
lowest_on_way = search(on_way)
