"""Fewer vertices of dense strands: points within a tolerance of the segment between those that are retained go.

A segment begins at the point where the last one ended and reaches as far as all points under it allow: its number of
points is doubled as long as that holds, and then found by halving the interval. Both test every point under the
segment, so the tolerance holds, whatever the strand looks like. Where its width varies from point to point, the
distance between its edge and that of the segment counts as well.
"""

from __future__ import annotations

import math

import numpy as np

from ....constants import W
from ....jit import device, parallel, prange
from ...common.kernels.numbers import ONE, ZERO
from ...common.kernels.view_columns import CORNER_STRETCH, FOCAL, NEAR_PLANE, PERSPECTIVE
from ...view.kernels.project import to_view

TINY = np.float32(1e-30)
UNEVEN = np.float32(0.01)
"""Share of a strand's greatest width by which segments may be wider or narrower than it."""
TOGETHER = 16
"""Strands a task: the numbers of a cache line."""


@parallel
def choose(positions, strands, view, tolerance, fade, radii, rows, sizes, error):
    """Choose the points of strands that are drawn.

    positions (blocks, n + 1, 3 W), metres; view: `view_columns`; tolerance: pixels; fade (strands,): 0 for strands that
    are left out, (0,): none is; radii (strands, n): half of the width at each point, metres, or None; rows (strands, n)
    uint16 out: numbers of the chosen points, ascending; sizes (strands,) int64 out: how many there are; error
    (strands,) float32 out: greatest distance of another one from the segment before which it was left out, pixels at
    the strand's nearest depth.
    """
    n = np.int64(positions.shape[1] - 1)
    for task in prange((strands + TOGETHER - 1) // TOGETHER):
        low = np.int64(task) * TOGETHER
        drawn = fade.shape[0] == 0
        for s in range(low, min(low + TOGETHER, fade.shape[0])):
            drawn = drawn or fade[s] != ZERO
        if not drawn:
            sizes[low : low + TOGETHER] = 0
            error[low : low + TOGETHER] = ZERO
            continue
        points = np.empty((TOGETHER, n, 3), np.float32)
        own = np.empty(n if radii is not None else 0, np.float32)
        block, lane = positions[low // W], low % W
        for i in range(n):
            for c in range(3):
                for k in range(TOGETHER):
                    points[k, i, c] = block[i + 1, c * W + lane + k]
        for k in range(min(TOGETHER, strands - low)):
            s = low + k
            if fade.shape[0] > 0 and fade[s] == ZERO:
                sizes[s] = 0
                error[s] = ZERO
                continue
            scale = pixels_a_metre(points[k], view)
            reach = tolerance / scale
            if radii is not None:
                emphasise(radii[s], reach, own)
            sizes[s], worst = thin(points[k], None if radii is None else own, reach * reach, rows[s])
            error[s] = math.sqrt(worst) * scale


@device
def emphasise(radii, reach, out):
    """Write radii (n,), times what makes `UNEVEN` of the greatest count as much as the tolerance `reach`, metres, where
    that is more: thin strands show their widths by how much they cover."""
    widest = TINY
    for i in range(radii.shape[0]):
        widest = max(widest, radii[i])
    times = max(reach / (UNEVEN * widest), ONE)
    for i in range(radii.shape[0]):
        out[i] = times * radii[i]


@device
def pixels_a_metre(points, view):
    """Return the greatest number of pixels a metre at any of the points (n, 3) of a strand."""
    if view[PERSPECTIVE] == ZERO:
        return view[FOCAL]
    least = np.float32(np.inf)
    for i in range(points.shape[0]):
        _, _, z = to_view(points[i, 0], points[i, 1], points[i, 2], view)
        least = min(least, z)
    return view[FOCAL] * view[CORNER_STRETCH] / max(least, view[NEAR_PLANE])


@device
def thin(points, radii, square, rows):
    """Write the numbers of the points (n, 3) of a strand that stay, with radii (n,) or None; return how many they are,
    and the greatest squared distance of another one. square: greatest squared distance that is allowed, metres²."""
    last = points.shape[0] - 1
    rows[0] = 0
    count = 1
    begin = 0
    worst = ZERO
    while begin < last:
        end = begin + 1  # as far as the segment reaches for sure
        beyond = last + 1  # and where it does not
        off = ZERO
        trial = begin + 2
        while trial < beyond:
            found = farthest(points, radii, begin, trial, square)
            if found <= square:
                end = trial
                off = found
            else:
                beyond = trial
            trial = 2 * end - begin
            if trial >= beyond:
                trial = max((end + beyond) // 2, end + 1)
        worst = max(worst, off)
        rows[count] = end
        count += 1
        begin = end
    return count, worst


@device
def farthest(points, radii, begin, end, square):
    """Return the greatest squared distance of the points between two from the segment between these, or that of the
    first one that is greater than ``square``."""
    ax = points[begin, 0]
    ay = points[begin, 1]
    az = points[begin, 2]
    ex = points[end, 0] - ax
    ey = points[end, 1] - ay
    ez = points[end, 2] - az
    per = ONE / max(ex * ex + ey * ey + ez * ez, TINY)
    most = ZERO
    for i in range(begin + 1, end):
        x = points[i, 0] - ax
        y = points[i, 1] - ay
        z = points[i, 2] - az
        t = min(max((x * ex + y * ey + z * ez) * per, ZERO), ONE)
        x -= t * ex
        y -= t * ey
        z -= t * ez
        away = x * x + y * y + z * z
        if radii is not None:
            off = radii[i] - (radii[begin] + t * (radii[end] - radii[begin]))
            away += off * off
        most = max(most, away)
        if most > square:
            return most
    return most


@parallel
def write(positions, rows, first, world, along, tangents):
    """Write the vertices of strands that `choose` has thinned.

    positions, rows: as there; first (strands + 1,) int64 vertex offsets; world (V, 3) out: metres; along (V,) float32
    out: the number of the point of each vertex, as a share of the last, 0 to 1; tangents (V, 3) out: from the point
    before it to that after it, metres, whether they are vertices or not.
    """
    n = positions.shape[1] - 1
    per = ONE / np.float32(n - 1)
    strands = first.shape[0] - 1
    for task in prange((strands + TOGETHER - 1) // TOGETHER):
        for s in range(np.int64(task) * TOGETHER, min((np.int64(task) + 1) * TOGETHER, strands)):
            block, lane = positions[s // W], s % W
            for v in range(first[s], first[s + 1]):
                i = np.int64(rows[s, v - first[s]])
                before, after = max(i, 1), min(i + 2, n)
                for c in range(3):
                    world[v, c] = block[i + 1, c * W + lane]
                    tangents[v, c] = block[after, c * W + lane] - block[before, c * W + lane]
                along[v] = np.float32(i) * per
