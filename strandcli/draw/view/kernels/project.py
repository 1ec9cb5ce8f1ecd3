"""Projection of polylines from the world to the screen of a camera or a light, and their widths there."""

from __future__ import annotations

import math

import numpy as np

from ....jit import device, parallel, prange
from ....simd import any_lane, deinterleave, half_width_pointer, lane_count, load, sqrt, store, where
from ...common.kernels import view_columns as at
from ...common.kernels.numbers import INF, ONE, STEPS, ZERO

OFF_SCREEN = np.float32(1e8)
"""Pixels. Points this far off the screen are invisible, because single precision cannot place them."""
TINY = np.float32(1e-12)
STRANDS = 64
"""Strands a task."""
VERTICES = 64
ROW = VERTICES + 16
# Rows of numbers, one a vertex: screen position and depth number, including the vertices before and after a chunk;
# width; place along the strand. Before projection the first three are view coordinates.
X, Y, NUMBER, WIDE, ALONG = (i * ROW for i in range(5))
ROWS = 5


@device
def to_view(x, y, z, view):
    """Return view coordinates of a point, metres: right, up, and depth along the view direction."""
    return (
        view[at.RIGHT_X] * x + view[at.RIGHT_Y] * y + view[at.RIGHT_Z] * z + view[at.RIGHT_SHIFT],
        view[at.UP_X] * x + view[at.UP_Y] * y + view[at.UP_Z] * z + view[at.UP_SHIFT],
        view[at.FORWARD_X] * x + view[at.FORWARD_Y] * y + view[at.FORWARD_Z] * z + view[at.FORWARD_SHIFT],
    )


@parallel
def widths(first, screen, view, thickness, taper, scale, least, along, out):
    """Write the widths of strands on the screen to out (V,) float32, pixels, at least `least`.

    thickness: metres at the root; taper: share by which it is smaller at the tip; scale (S,): factor of each strand's
    width, or None; along (V,): how far along its strand each vertex stands, 0 to 1, or None: evenly; first, screen,
    view: as in `points`.
    """
    strands = first.shape[0] - 1
    for task in prange((strands + STRANDS - 1) // STRANDS):
        work = np.empty(ROWS * ROW, np.float32)
        for s in range(np.int64(task) * STRANDS, min((np.int64(task) + 1) * STRANDS, strands)):
            begin = first[s]
            end = first[s + 1]
            per = taper / np.float32(max(end - begin - 1, 1))
            for v in range(begin, end, VERTICES):
                count = min(end - v, VERTICES)
                load_with_neighbours(screen, begin, end, v, count, work)
                if along is not None:
                    for k in range(np.uint64(count)):
                        work[np.uint64(ALONG) + k] = along[np.uint64(v) + k]
                widen(
                    work, count, v - begin, view, thickness, per if along is None else taper,
                    None if scale is None else scale[s], least, along,
                )  # fmt: skip
                for k in range(np.uint64(count)):
                    out[np.uint64(v) + k] = work[np.uint64(WIDE) + k]


@device
def load_with_neighbours(screen, begin, end, v, count, work):
    """Load `count` vertices from number v on, and the ones before and after them; a neighbour beyond the strand's end
    gets the depth number 0."""
    low = max(v - 1, begin)
    deinterleave(half_width_pointer(screen), 3 * low, min(v + count, end - 1) + 1 - low, work, X + low + 1 - v, ROW)
    if v == begin:
        work[NUMBER] = ZERO
    if v + count == end:
        work[NUMBER + count + 1] = ZERO


@device
def widen(work, count, past, view, thickness, per, scale, least, along):
    """Store the widths of `count` vertices in the row `WIDE`; past: number of the first one within its strand; per:
    taper a vertex, or from root to tip where the row `ALONG` tells how far along they stand; along: None if that row is
    not there; else as in `widths`."""
    rows = half_width_pointer(work)
    steps = load(half_width_pointer(STEPS), 0)
    for k in range(0, count, lane_count(rows)):
        x, y, q = load(rows, X + 1 + k), load(rows, Y + 1 + k), load(rows, NUMBER + 1 + k)
        place = steps + np.float32(past + k) if along is None else load(rows, ALONG + k)
        wide = thickness * (ONE - per * place) * view[at.FOCAL]
        if scale is not None:
            wide *= scale
        if view[at.PERSPECTIVE] > ZERO:
            wide *= q
            before = load(rows, NUMBER + k) > ZERO
            after = load(rows, NUMBER + 2 + k) > ZERO
            dx = where(after, load(rows, X + 2 + k), x) - where(before, load(rows, X + k), x)
            dy = where(after, load(rows, Y + 2 + k), y) - where(before, load(rows, Y + k), y)
            x -= view[at.AXIS_X]
            y -= view[at.AXIS_Y]
            off = (dx * y - dy * x) / (max(sqrt(dx * dx + dy * dy), TINY) * view[at.FOCAL])
            wide *= sqrt(ONE + off * off)
        store(rows, WIDE + k, max(wide, least))


@device
def perspective_widening(x, y, dx, dy, focal):
    """Return how many times wider a thin cylinder appears at (x, y) pixels from the view's axis than at the centre, at
    the same depth; (dx, dy): its direction on the screen.

    The planes through the eye that are tangent to a cylinder are the plane through its axis, rotated by ± radius /
    distance. On the screen that plane is a line, δ pixels from the centre; the rotation moves it by √(1 + δ² / focal²)
    times as much as a line through the centre. A strand that points at the centre is not widened; one perpendicular to
    that is widened by 1 / cos of its angle from the axis.
    """
    size = math.sqrt(dx * dx + dy * dy)
    off = (dx * y - dy * x) / (max(size, TINY) * focal)
    return math.sqrt(ONE + off * off)


@parallel
def points(first, world, view, screen):
    """Project polylines.

    first (S + 1,) int64; world (V, 3) metres; view: `view_columns`; screen (V, 3): x right and y down in pixels, and
    the depth number, which grows toward the eye, is linear on the screen and 0 for a point that is not seen. For a
    perspective view it is 1 / depth, in (0, 1 / near]; for an orthographic one 1 at the near plane and 0 at the far
    one. A vertex behind the near plane is moved onto it if a neighbour is in front, so that the segment between them is
    clipped.
    """
    strands = first.shape[0] - 1
    for task in prange((strands + STRANDS - 1) // STRANDS):
        work = np.empty(ROWS * ROW, np.float32)
        s, last = np.int64(task) * STRANDS, min((np.int64(task) + 1) * STRANDS, strands)
        for low in range(first[s], first[last], VERTICES):
            count = min(first[last] - low, VERTICES)
            deinterleave(half_width_pointer(world), 3 * low, count, work, X, ROW)
            if transform(work, count, view):
                clip(first, s, world, low, count, view, work)
            to_screen(work, count, view)
            for k in range(np.uint64(count)):
                v = np.uint64(low) + k
                screen[v, 0] = work[np.uint64(X) + k]
                screen[v, 1] = work[np.uint64(Y) + k]
                screen[v, 2] = work[np.uint64(NUMBER) + k]


@device
def transform(work, count, view):
    """Transform vertices from world to view coordinates; return whether any lies behind the near plane."""
    rows = half_width_pointer(work)
    steps = load(half_width_pointer(STEPS), 0)
    behind = False
    for k in range(0, count, lane_count(rows)):
        x, y, z = to_view(load(rows, X + k), load(rows, Y + k), load(rows, NUMBER + k), view)
        store(rows, X + k, x)
        store(rows, Y + k, y)
        store(rows, NUMBER + k, z)
        behind |= any_lane((z < view[at.NEAR_PLANE]) & (steps < np.float32(count - k)))
    return behind


@device
def clip(first, s, world, low, count, view, work):
    """Move those of `count` vertices from number `low` on, which is of strand s, onto the near plane that lie behind it
    and have a neighbour in front, and make the rest behind it invisible."""
    for k in range(count):
        while low + k >= first[s + 1]:
            s += 1
        x, y, z = work[X + k], work[Y + k], work[NUMBER + k]
        if z < view[at.NEAR_PLANE]:
            front, x, y = cross_near_plane(world, view, low + k, first[s], first[s + 1], x, y, z)
            work[X + k] = x
            work[Y + k] = y
            work[NUMBER + k] = view[at.NEAR_PLANE] if front else -INF


@device
def to_screen(work, count, view):
    """Project vertices from view coordinates to the screen. Vertices too far off the screen for single precision, and
    NaN, become invisible."""
    rows = half_width_pointer(work)
    focal = view[at.FOCAL]
    far = ONE / view[at.DEPTH_RANGE]
    for k in range(0, count, lane_count(rows)):
        x, y, z = load(rows, X + k), load(rows, Y + k), load(rows, NUMBER + k)
        if view[at.PERSPECTIVE] > ZERO:
            q = ONE / z
            x = view[at.AXIS_X] + focal * x * q
            y = view[at.AXIS_Y] - focal * y * q
        else:
            q = max(ONE - (z - view[at.NEAR_PLANE]) * far, ZERO)
            x = view[at.AXIS_X] + focal * x
            y = view[at.AXIS_Y] - focal * y
        seen = (z >= view[at.NEAR_PLANE]) & (abs(x) < OFF_SCREEN) & (abs(y) < OFF_SCREEN)
        store(rows, X + k, where(seen, x, ZERO))
        store(rows, Y + k, where(seen, y, ZERO))
        store(rows, NUMBER + k, where(seen, q, ZERO))


@device
def cross_near_plane(world, view, v, begin, end, x, y, z):
    """Return whether vertex v, at (x, y, z) behind the near plane, has a neighbour in front of it, and where the
    segment between them crosses the plane."""
    near = view[at.NEAR_PLANE]
    for w in (v - 1, v + 1):
        if begin <= w < end:
            x1, y1, z1 = to_view(world[w, 0], world[w, 1], world[w, 2], view)
            if z1 >= near:
                t = (near - z) / (z1 - z)
                return True, x + t * (x1 - x), y + t * (y1 - y)
    return False, x, y
