"""Silhouette of strands at their ends, on the screen.

A strand is a tube without caps. If it is slanted to the view, the visible half of the rim at its end is displaced along
the axis: the visible side of a strand that points toward the eye ends before its axis does, of one that points away
after it.
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
    FORWARD_X,
    FORWARD_Y,
    FORWARD_Z,
    NEAR_PLANE,
    PERSPECTIVE,
)
from ...view.kernels.project import OFF_SCREEN, to_view

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
TINY = np.float32(1e-12)
MEAN = np.float32(math.pi / 4)
"""Mean of √(1 − h²) over the width, h ∈ [−1, 1]."""
STEEPEST = np.float32(4.0)
"""Greatest tangent of the slant, reached by strands that point almost at the eye."""
STRANDS = 256
"""Strands a task."""


@parallel
def move_ends(first, world, view, width, taper, scale, lost, screen):
    """Move both ends of polylines on the screen along their axes, by the mean displacement of the visible rim over the
    width: (π / 4) r tan ψ in the world, ψ the slant, but at most half a segment.

    first, world, view: as in `project.points`; screen (V, 3): from it, changed; width: metres at the root; taper: share
    by which it is smaller at the tip; scale (S,): factor of each strand's width, or None; lost (V,): share by which it
    is smaller at each vertex, or None: as the taper has it.
    """
    strands = first.shape[0] - 1
    for task in prange((strands + STRANDS - 1) // STRANDS):
        for s in range(np.int64(task) * STRANDS, min((np.int64(task) + 1) * STRANDS, strands)):
            root = first[s]
            tip = first[s + 1] - 1
            if tip <= root:
                continue
            radius = MEAN * HALF * width * (ONE if scale is None else scale[s])
            wide = radius if lost is None else radius * (ONE - lost[root])
            move_end(world, root, root, root + 1, view, wide, screen)
            move_end(world, tip, tip - 1, tip, view, radius * (ONE - (taper if lost is None else lost[tip])), screen)


@device
def move_end(world, v, low, high, view, reach, screen):
    """Move vertex v, one end of the segment from vertex `low` to `high`; reach: displacement for a slant of 45°,
    metres."""
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
    tangent = min(max(dot / aside, -STEEPEST), STEEPEST) if aside > ZERO else ZERO  # the segment may have no length
    by = -min(max(reach * tangent / size, -HALF), HALF)
    right, up, depth = to_view(world[v, 0] + by * tx, world[v, 1] + by * ty, world[v, 2] + by * tz, view)
    if screen[v, 2] <= ZERO or depth < view[NEAR_PLANE]:
        return
    per = view[FOCAL] / depth if view[PERSPECTIVE] > ZERO else view[FOCAL]
    right = view[AXIS_X] + per * right
    down = view[AXIS_Y] - per * up
    if abs(right) >= OFF_SCREEN or abs(down) >= OFF_SCREEN:
        return
    screen[v, 0] = right
    screen[v, 1] = down
    screen[v, 2] = (
        ONE / depth if view[PERSPECTIVE] > ZERO else max(ONE - (depth - view[NEAR_PLANE]) / view[DEPTH_RANGE], TINY)
    )
