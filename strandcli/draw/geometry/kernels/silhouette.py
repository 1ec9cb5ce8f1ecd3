"""Where the side of a strand that is seen ends.

A strand is a tube without caps. Aslant to a view, the rim of its end lies aside of the end of its middle: of a strand
that points at the eye, the side that is seen ends before its middle does; of one that points away, after it.
"""

from __future__ import annotations

import math

import numpy as np

from ....jit import device, parallel, prange
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
    straight = view[12] - ONE
    ex = view[12] * (view[20] - world[v, 0]) + straight * view[8]
    ey = view[12] * (view[21] - world[v, 1]) + straight * view[9]
    ez = view[12] * (view[22] - world[v, 2]) + straight * view[10]
    size = tx * tx + ty * ty + tz * tz
    dot = tx * ex + ty * ey + tz * ez
    aside = math.sqrt(max(size * (ex * ex + ey * ey + ez * ez) - dot * dot, TINY * size))
    size = math.sqrt(max(size, TINY))
    tangent = min(max(dot / aside, -STEEPEST), STEEPEST)
    by = -min(max(reach * tangent / size, -HALF), HALF)
    x = world[v, 0] + by * tx
    y = world[v, 1] + by * ty
    z = world[v, 2] + by * tz
    depth = view[8] * x + view[9] * y + view[10] * z + view[11]
    if screen[v, 2] <= ZERO or depth < view[14]:
        return
    per = view[13] / depth if view[12] > ZERO else view[13]
    right = view[15] + per * (view[0] * x + view[1] * y + view[2] * z + view[3])
    down = view[16] - per * (view[4] * x + view[5] * y + view[6] * z + view[7])
    if abs(right) >= MOST or abs(down) >= MOST:
        return
    screen[v, 0] = right
    screen[v, 1] = down
    screen[v, 2] = ONE / depth if view[12] > ZERO else max(ONE - (depth - view[14]) / view[19], TINY)
