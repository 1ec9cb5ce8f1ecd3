"""World to screen, for a camera or a light."""

from __future__ import annotations

import math

import numpy as np

from ...jit import inner, parallel, prange
from .curves import into

ZERO = np.float32(0.0)
ONE = np.float32(1.0)
MOST = np.float32(1e8)
TINY = np.float32(1e-12)


@parallel
def widths(first, screen, view, thickness, taper, scale, aside, least, out):
    """Widths of lines on the screen, pixels: thickness (metres at the root) loses `taper` of itself toward the tip;
    scale (S,): factor of each strand, or None; aside: 1 to have them wider aside of the view's axis, as `wider` says,
    else 0; never under `least`. first, screen, view as in `points`; out (V,) float32."""
    aslant = view[12] * aside
    for s in prange(first.shape[0] - 1):
        begin = first[s]
        end = first[s + 1]
        per = taper / np.float32(max(end - begin - 1, 1))
        for v in range(begin, end):
            wide = thickness * (ONE - per * np.float32(v - begin)) * view[13]
            if scale is not None:
                wide *= scale[s]
            if view[12] > ZERO:
                wide *= screen[v, 2]
            if aslant > ZERO:
                before = v - 1 if v > begin and screen[v - 1, 2] > ZERO else v
                after = v + 1 if v + 1 < end and screen[v + 1, 2] > ZERO else v
                wide *= wider(
                    screen[v, 0] - view[15], screen[v, 1] - view[16],
                    screen[after, 0] - screen[before, 0], screen[after, 1] - screen[before, 1], view[13],
                )  # fmt: skip
            out[v] = max(wide, least)


@inner
def wider(x, y, dx, dy, focal):
    """How many times wider on the screen than in the middle, at the same depth, a thin cylinder is at (x, y) pixels
    from the view's axis whose picture goes along (dx, dy).

    The planes through the eye that touch a cylinder are the one through its axis turned by ± radius / distance. On the
    screen that one is a line, δ pixels from the middle; turned, it moves by √(1 + δ² / focal²) times as much as in the
    middle. A strand that points at the middle is no wider; one across has all of the 1 / cos of its angle from there.
    """
    size = math.sqrt(dx * dx + dy * dy)
    off = (dx * y - dy * x) / (max(size, TINY) * focal)
    return math.sqrt(ONE + off * off)


@parallel
def points(first, world, stride, view, screen):
    """Project polylines.

    first (S + 1,) int64; world (V, 3) metres; stride: of each strand every which vertex, where all have a multiple of
    that and one; view (26,) float32, built by `strandcli.draw.camera.View.pack`: three
    rows of a rigid transform to (right, up, depth); [12] 1 for perspective, 0 for orthographic; [13] pixels a metre (at
    depth 1 for perspective); [14] near; [15], [16] the pixel of the axis; [17], [18] margins; [19] depth
    range of an orthographic view. screen (V, 3): x right and y down in pixels, and a number in (0, 1 / near] that grows
    toward the eye and is linear on the screen; 0 where the point is behind `near`. A vertex behind is moved to the near
    plane where a neighbour is in front of it, so that a piece that crosses is clipped and not lost.
    """
    focal = view[13]
    near = view[14]
    perspective = view[12] > ZERO
    far = ONE / view[19]
    for s in prange(first.shape[0] - 1):
        begin = first[s]
        end = first[s + 1]
        at = (begin - s) // stride + s - 1
        for v in range(begin, end, stride):
            at += 1
            x, y, z = into(world[v, 0], world[v, 1], world[v, 2], view)
            if z < near:
                front, x, y = forward(world, view, v, stride, begin, end, x, y, z)
                if not front:
                    place(screen, at, ZERO, ZERO, ZERO)
                    continue
                z = near
            q = ONE / z if perspective else max(ONE - (z - near) * far, ZERO)
            scale = q if perspective else ONE
            place(screen, at, view[15] + focal * x * scale, view[16] - focal * y * scale, q)


@inner
def forward(world, view, v, stride, begin, end, x, y, z):
    """Whether vertex v, at (x, y, z) behind the near plane, has a neighbour in front of it; and where the piece between
    them crosses that plane."""
    near = view[14]
    for w in (v - stride, v + stride):
        if begin <= w < end:
            x1, y1, z1 = into(world[w, 0], world[w, 1], world[w, 2], view)
            if z1 >= near:
                t = (near - z) / (z1 - z)
                return True, x + t * (x1 - x), y + t * (y1 - y)
    return False, x, y


@inner
def place(screen, v, x, y, q):
    """Set a vertex; one so far off that pixels can no longer be told apart is left out, as is what is not a number."""
    seen = abs(x) < MOST and abs(y) < MOST
    screen[v, 0] = x if seen else ZERO
    screen[v, 1] = y if seen else ZERO
    screen[v, 2] = q if seen else ZERO
