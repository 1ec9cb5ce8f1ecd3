"""Z-buffer of solids that consist of triangles: only pixels that a triangle may cover are asked for their ray.

The rays, their starts and the test of a ray and a triangle are those of `rays.meet`, so that the keys have the same
bits as if every pixel had asked for the nearest of all triangles. Which pixels are asked follows from the edges of
triangles as linear functions on the screen, in homogeneous coordinates, which triangles about the eye need not be
clipped for (Olano & Greer 1997, "Triangle Scan Conversion using 2D Homogeneous Coordinates").
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ....jit import device, inlined, parallel, prange
from ....jit.indices import FIRST, SECOND, THIRD
from ....meshes.kernels.rays import meet, sheared
from ....solids.kernels.distance_field import ray_in_own, through
from ...common.kernels.numbers import HALF, INF, ZERO
from ...common.kernels.view_columns import AXIS_X, AXIS_Y, FOCAL, PERSPECTIVE
from .rays import ray
from .visible import BOTTOM, LEFT, RIGHT, TOP, key_at

BAND = 8
"""Rows of a task."""
CHUNK = 1024
"""Triangles of a task."""
ROUNDING = 64.0 * 2.0**-24
"""Of rays in single precision, as a share of lengths; several times what it is at the most."""
DEPTH, TRIANGLE = np.uint64(32), np.uint64(0xFFFFFFFF)
NONE = np.uint64(np.float32(np.inf).view(np.uint32)) << DEPTH
"""The depth of what is nowhere, above the number of a triangle."""
ABOUT_EYE = 16.0
"""Roundings of depth within which a triangle is taken to reach the eye."""


class Rays(NamedTuple):
    """Rays of a view in the frame of a solid, in double precision, and how far off those in single precision may be.

    A ray is forward + a right + b up from the eye in a perspective view, and forward from eye + a right + b up in an
    orthographic one, a and b in metres at a depth of one metre.
    """

    axes: NDArray[np.float64]
    """(3, 3) right, up and forward."""
    eye: NDArray[np.float64]
    """(3,) metres."""
    off: float
    """Metres by which the places of rays may be off."""
    longest: float
    """Greatest length of a direction."""


class Solid(NamedTuple):
    """A solid as `strandcli.solids.kernels.distance_field` takes it."""

    rows: NDArray[np.float32]
    """(1, columns) of `strandcli.solids.custom`."""


class Spans(NamedTuple):
    """What the pixels of triangles are at the most, triangle by triangle."""

    box: NDArray[np.int32]
    """(T, 4) `LEFT`, `RIGHT`, `TOP`, `BOTTOM`: pixels, right and bottom exclusive; no pixels: right <= left."""
    depth: NDArray[np.float32]
    """(T,) the least depth, metres."""
    turned: NDArray[np.uint8]
    """(T,) 1 for a triangle that is wound clockwise as the view sees it: of a closed mesh, one at the back."""


class Picture(NamedTuple):
    """What triangles are drawn into."""

    keys: NDArray[np.uint64]
    """(height, width) z-buffer."""
    shown: NDArray[np.int32]
    """(height, width) the triangle that is in front, where one is; no rows: not asked for."""


@parallel
def bound(corners, rays, view, frame, spans):
    """Fill the spans of all triangles. corners (T, 3, 3) float64; frame (4,) int64: pixels to draw, as a span."""
    for task in prange((corners.shape[0] + CHUNK - 1) // CHUNK):
        begin = np.int64(task) * CHUNK
        for i in range(begin, min(begin + CHUNK, corners.shape[0])):
            bound_one(corners, i, rays, view, frame, spans)


@device
def bound_one(corners, i, rays, view, frame, spans):
    """Fill the span of triangle i."""
    least_x = least_y = least_z = np.inf
    most_x = most_y = most_z = -np.inf
    for corner in range(3):
        a, b, z = seen(corners, i, corner, rays)
        least_z, most_z = min(least_z, z), max(most_z, z)
        if view[PERSPECTIVE] > ZERO:
            a, b = a / z, b / z
        x, y = view[AXIS_X] + view[FOCAL] * a - 0.5, view[AXIS_Y] - view[FOCAL] * b - 0.5
        least_x, most_x = min(least_x, x), max(most_x, x)
        least_y, most_y = min(least_y, y), max(most_y, y)
    spans.depth[i] = np.float32(least_z - rays.off)
    spans.turned[i] = np.uint8(winding(corners, i, rays, view) > 0.0)
    for side in range(4):
        spans.box[i, side] = frame[side]
    if most_z < -ABOUT_EYE * rays.off:
        spans.box[i, RIGHT] = spans.box[i, LEFT]
    elif view[PERSPECTIVE] == ZERO or least_z > ABOUT_EYE * rays.off:
        room = view[FOCAL] * rays.off
        if view[PERSPECTIVE] > ZERO:
            room = view[FOCAL] * rays.longest * (rays.off / least_z + ROUNDING)
        spans.box[i, LEFT] = math.ceil(clamped(least_x - room, frame[LEFT], frame[RIGHT]))
        spans.box[i, TOP] = math.ceil(clamped(least_y - room, frame[TOP], frame[BOTTOM]))
        spans.box[i, RIGHT] = math.floor(clamped(most_x + room, frame[LEFT] - 1, frame[RIGHT] - 1)) + 1
        spans.box[i, BOTTOM] = math.floor(clamped(most_y + room, frame[TOP] - 1, frame[BOTTOM] - 1)) + 1


@device
def clamped(value, low, high):
    """A number between two bounds, or the nearer one of them."""
    return min(max(value, np.float64(low)), np.float64(high))


@device
def seen(corners, i, corner, rays):
    """A corner of triangle i along right, up and forward from the eye."""
    x, y, z = corners[i, corner, 0] - rays.eye[0], corners[i, corner, 1] - rays.eye[1], corners[i, corner, 2]
    z -= rays.eye[2]
    axes = rays.axes
    return (
        x * axes[0, 0] + y * axes[0, 1] + z * axes[0, 2],
        x * axes[1, 0] + y * axes[1, 1] + z * axes[1, 2],
        x * axes[2, 0] + y * axes[2, 1] + z * axes[2, 2],
    )


@device
def winding(corners, i, rays, view):
    """A number that is negative for a triangle whose normal is towards the eye, and positive for one that is turned
    away."""
    a, b, c = seen(corners, i, FIRST, rays), seen(corners, i, SECOND, rays), seen(corners, i, THIRD, rays)
    nx, ny, nz = cross(minus(b, a), minus(c, a))
    # right, up and forward are left-handed
    if view[PERSPECTIVE] > ZERO:
        return -(nx * a[0] + ny * a[1] + nz * a[2])
    return -nz


@device
def minus(a, b):
    """The difference of two vectors."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


@device
def cross(a, b):
    """The cross product of two vectors."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@device
def size(a):
    """The length of a vector."""
    return math.sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2])


@device
def edge(corners, i, k, sign, rays, view):
    """Edge k of triangle i as a linear function of the screen that is not negative within: its value on the view's
    axis, with room for rounding, and its growth along a and b of `Rays`. sign: -1 where inside is negative."""
    p, q = seen(corners, i, k, rays), seen(corners, i, (k + 1) % 3, rays)
    n, along = cross(p, q), minus(q, p)
    room = rays.longest * (rays.off * size(along) + ROUNDING * size(n))
    if view[PERSPECTIVE] > ZERO:
        return sign * n[2] + room, sign * n[0], sign * n[1]
    # of the same planes, when the eye moves by a right + b up
    return sign * n[2] + room, -sign * along[1], sign * along[0]


@parallel
def draw(corners, listed, begin, solid, rays, view, frame, spans, identity, picture):
    """Draw triangles into a `Picture`.

    listed (n,): triangles of each band of rows, those of band b from begin[b] on; solid: `Solid`; identity: the low
    part of its keys.
    """
    for band in prange(begin.shape[0] - 1):
        b = np.int64(band)
        low = frame[TOP] + b * BAND
        high = min(low + BAND, frame[BOTTOM])
        nearest = np.full((BAND, frame[RIGHT] - frame[LEFT]), NONE, np.uint64)
        for at in range(begin[b], begin[b + 1]):
            draw_one(corners, np.int64(listed[at]), solid, rays, view, frame, spans, low, high, nearest)
        for y in range(low, high):
            finish_row(nearest[y - low], y, frame[LEFT], view, identity, picture)


@device
def finish_row(nearest, y, left, view, identity, picture):
    """Take what is nearest in a row, from a column on, into a `Picture`."""
    for x in range(nearest.shape[0]):
        key = key_at(depth_of(nearest[x]), view, identity)
        if key < picture.keys[y, left + x]:
            picture.keys[y, left + x] = key
            if picture.shown.shape[0] > 0:
                picture.shown[y, left + x] = np.int32(nearest[x] & TRIANGLE)


@inlined
def depth_of(nearest):
    """Return a depth, metres, that stands above the number of a triangle."""
    return np.uint32(nearest >> DEPTH).view(np.float32)


@device
def draw_one(corners, i, solid, rays, view, frame, spans, low, high, nearest):
    """Take triangle i into the rows from low on, below high: nearest (`BAND`, width) uint64, depths above triangles."""
    sign = -1.0 if spans.turned[i] > 0 else 1.0
    first, second, third = (
        edge(corners, i, FIRST, sign, rays, view), edge(corners, i, SECOND, sign, rays, view),
        edge(corners, i, THIRD, sign, rays, view),
    )  # fmt: skip
    for y in range(max(low, np.int64(spans.box[i, TOP])), min(high, np.int64(spans.box[i, BOTTOM]))):
        b = (view[AXIS_Y] - y - 0.5) / view[FOCAL]
        left, right = np.float64(spans.box[i, LEFT]), spans.box[i, RIGHT] - 1.0
        left, right = cut(left, right, first, b, view)
        left, right = cut(left, right, second, b, view)
        left, right = cut(left, right, third, b, view)
        for x in range(math.ceil(left), math.floor(right) + 1):
            at = x - frame[LEFT]
            if spans.depth[i] < depth_of(nearest[y - low, at]):
                depth = depth_at(corners, i, solid, view, frame, at, y)
                own = (np.uint64(np.float32(depth).view(np.uint32)) << DEPTH) | np.uint64(i)
                nearest[y - low, at] = min(nearest[y - low, at], own)


@device
def cut(left, right, line, b, view):
    """What is left of the pixels left <= x <= right of a row where an edge's function is not negative."""
    value = line[0] + line[2] * b
    if line[1] == 0.0:
        return left, (right if value >= 0.0 else left - 1.0)
    x = view[AXIS_X] - 0.5 - view[FOCAL] * (value / line[1])
    return (max(left, x), right) if line[1] > 0.0 else (left, min(right, x))


@device
def depth_at(corners, i, solid, view, frame, at, y):
    """Where the ray of a pixel meets triangle i, as `rays.meet`; at: columns from the frame's left."""
    begin = np.float32(frame[LEFT]) + HALF - view[AXIS_X]
    up = (view[AXIS_Y] - np.float32(y) - HALF) / view[FOCAL]
    ox, oy, oz, dx, dy, dz = ray(view, (begin + np.float32(at)) / view[FOCAL], up)
    start, end = through(solid, FIRST, ox, oy, oz, dx, dy, dz)
    if end < start:
        return INF
    px, py, pz, ux, uy, uz = ray_in_own(
        solid, FIRST, ox + start * dx, oy + start * dy, oz + start * dz, dx, dy, dz
    )  # fmt: skip
    t, _, _ = meet(corners, i, px, py, pz, sheared(ux, uy, uz))
    return start + np.float32(t) if t >= 0.0 else INF
