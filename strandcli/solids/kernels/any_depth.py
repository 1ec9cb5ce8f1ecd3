"""Depth of points in all solids together."""

from __future__ import annotations

from ...jit import device
from ...simd import broadcast, pointer
from . import box, capsule, other, plane, sphere

OUTSIDE = -1e20
"""Metres: less than any depth."""


@device
def any_depth(solids, x, y, z):
    """Return the greatest depth of points in any of the `Solids`, metres; negative outside of all. Vectors of lanes."""
    spheres, capsules, planes, boxes = solids.spheres, solids.capsules, solids.planes, solids.boxes
    balls, pills, flats, cubes = pointer(spheres), pointer(capsules), pointer(planes), pointer(boxes)
    most = broadcast(x, OUTSIDE)
    for m in range(0, spheres.size, spheres.shape[1]):
        most = max(most, sphere.depth(balls, m, x, y, z))
    for m in range(0, capsules.size, capsules.shape[1]):
        most = max(most, capsule.depth(pills, m, x, y, z))
    for m in range(0, planes.size, planes.shape[1]):
        most = max(most, plane.depth(flats, m, x, y, z))
    for m in range(0, boxes.size, boxes.shape[1]):
        most = max(most, box.depth(cubes, m, x, y, z)[0])
    return other.deepen(solids, x, y, z, most)
