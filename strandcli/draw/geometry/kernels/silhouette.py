"""Where the side of a strand that is seen ends.

A strand is a tube without caps. Aslant to a view, the rim of its end lies aside of the end of its middle: of a strand
that points at the eye, the side that is seen ends before its middle does; of one that points away, after it.
"""

from __future__ import annotations

import math

import numpy as np

from ....jit import device, parallel, prange
from ...common.kernels.view_columns import (
    AXIS_X,
    AXIS_Y,
    DEPTH_RANGE,
    EYE_X,
    EYE_Y,
    EYE_Z,
    FOCAL,
    FORWARD_SHIFT,
    FORWARD_X,
    FORWARD_Y,
    FORWARD_Z,
    NEAR_PLANE,
    PERSPECTIVE,
    RIGHT_SHIFT,
    RIGHT_X,
    RIGHT_Y,
    RIGHT_Z,
    UP_SHIFT,
    UP_X,
    UP_Y,
    UP_Z,
)
from ...view.kernels.project import MOST

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
TINY = np.float32(1e-12)
MEAN = np.float32(math.pi / 4)
"""Of √(1 − h²) over the width."""
STEEPEST = np.float32(4.0)
"""Tangent of the greatest slant that counts: strands that point at the eye are seen end on."""
STRANDS = 256
"""Strands a task."""


@parallel
def rims(first, world, view, width, taper, scale, screen):
    """Move both ends of polylines on the screen along them, as far as the mean over the width of the rims that are
    seen lies from their middles: by (π / 4) r tan ψ in the world, ψ the slant, but by half a piece at most.

    first, world, view as in `project.points`, which screen (V, 3) is of; width: metres at the root, of which `taper` is
    lost to the tip; scale (S,): factor of each strand's, or None.
    """
    strands = first.shape[0] - 1
    for task in prange((strands + STRANDS - 1) // STRANDS):
        for s in range(np.int64(task) * STRANDS, min((np.int64(task) + 1) * STRANDS, strands)):
            root = first[s]
            tip = first[s + 1] - 1
            if tip <= root:
                continue
            radius = MEAN * HALF * width * (ONE if scale is None else scale[s])
            rim(world, root, root, root + 1, view, radius, screen)
            rim(world, tip, tip - 1, tip, view, radius * (ONE - taper), screen)


@device
def rim(world, v, low, high, view, reach, screen):
    """Move vertex v, one of those at the ends of the piece from vertex `low` to `high`."""
    tx = world[high, 0] - world[low, 0]
    ty = world[high, 1] - world[low, 1]
    tz = world[high, 2] - world[low, 2]
    straight = view[PERSPECTIVE] - ONE
    ex = view[PERSPECTIVE] * (view[EYE_X] - world[v, 0]) + straight * view[FORWARD_X]
    ey = view[PERSPECTIVE] * (view[EYE_Y] - world[v, 1]) + straight * view[FORWARD_Y]
    ez = view[PERSPECTIVE] * (view[EYE_Z] - world[v, 2]) + straight * view[FORWARD_Z]
    size = tx * tx + ty * ty + tz * tz
    dot = tx * ex + ty * ey + tz * ez
    aside = math.sqrt(max(size * (ex * ex + ey * ey + ez * ez) - dot * dot, TINY * size))
    size = math.sqrt(max(size, TINY))
    tangent = min(max(dot / aside, -STEEPEST), STEEPEST) if aside > ZERO else ZERO  # an end piece may have no length
    by = -min(max(reach * tangent / size, -HALF), HALF)
    x = world[v, 0] + by * tx
    y = world[v, 1] + by * ty
    z = world[v, 2] + by * tz
    depth = view[FORWARD_X] * x + view[FORWARD_Y] * y + view[FORWARD_Z] * z + view[FORWARD_SHIFT]
    if screen[v, 2] <= ZERO or depth < view[NEAR_PLANE]:
        return
    per = view[FOCAL] / depth if view[PERSPECTIVE] > ZERO else view[FOCAL]
    right = view[AXIS_X] + per * (view[RIGHT_X] * x + view[RIGHT_Y] * y + view[RIGHT_Z] * z + view[RIGHT_SHIFT])
    down = view[AXIS_Y] - per * (view[UP_X] * x + view[UP_Y] * y + view[UP_Z] * z + view[UP_SHIFT])
    if abs(right) >= MOST or abs(down) >= MOST:
        return
    screen[v, 0] = right
    screen[v, 1] = down
    screen[v, 2] = (
        ONE / depth if view[PERSPECTIVE] > ZERO else max(ONE - (depth - view[NEAR_PLANE]) / view[DEPTH_RANGE], TINY)
    )
