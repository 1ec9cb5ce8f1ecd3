"""All solids together: how many there are, how deep points are in them, and a point moved out of them."""

from __future__ import annotations

from ...jit import device
from ...simd import broadcast, pointer
from . import box, built_in, capsule, custom, plane, sphere
from .built_in import device_if_built_in

OUTSIDE = -1e20
"""Metres: less than any depth."""


@device
def outside(x, y, z, clear, solids):
    """Return a point, moved out of one of the `Solids` after the other along its normal, to `clear` metres from its
    surface. A later solid may move it into an earlier one."""
    x, y, z = outside_built_in(solids, x, y, z, clear)
    return custom.outside(solids, x, y, z, clear)


@device_if_built_in(lambda solids, x, y, z, clear: (x, y, z))
def outside_built_in(solids, x, y, z, clear):
    """Return `outside` of solids of the four shapes."""
    for s in range(solids.spheres.shape[0]):
        x, y, z = sphere.outside(solids.spheres, s, x, y, z, clear)
    for s in range(solids.capsules.shape[0]):
        x, y, z = capsule.outside(solids.capsules, s, x, y, z, clear)
    for s in range(solids.planes.shape[0]):
        x, y, z = plane.outside(solids.planes, s, x, y, z, clear)
    for s in range(solids.boxes.shape[0]):
        x, y, z = box.outside(solids.boxes, s, x, y, z, clear)
    return x, y, z


@device
def count(solids):
    """Return the number of `Solids`."""
    return built_in.count(solids) + custom.count(solids)


@device
def any_depth(solids, x, y, z):
    """Return the greatest depth of points in any of the `Solids`, metres; negative outside of all. Vectors of lanes."""
    return custom.deepen(solids, x, y, z, deepest_in_shapes(solids, x, y, z, broadcast(x, OUTSIDE)))


@device_if_built_in(lambda solids, x, y, z, deep: deep)
def deepest_in_shapes(solids, x, y, z, deep):
    """Return the greatest of depths and of those of points in solids of the four shapes, metres; vectors of lanes."""
    rows, size = pointer(solids.spheres), solids.spheres.shape[1]
    for m in range(0, solids.spheres.shape[0] * size, size):
        deep = max(deep, sphere.depth(rows, m, x, y, z))
    rows, size = pointer(solids.capsules), solids.capsules.shape[1]
    for m in range(0, solids.capsules.shape[0] * size, size):
        deep = max(deep, capsule.depth(rows, m, x, y, z))
    rows, size = pointer(solids.planes), solids.planes.shape[1]
    for m in range(0, solids.planes.shape[0] * size, size):
        deep = max(deep, plane.depth(rows, m, x, y, z))
    rows, size = pointer(solids.boxes), solids.boxes.shape[1]
    for m in range(0, solids.boxes.shape[0] * size, size):
        deep = max(deep, box.depth(rows, m, x, y, z)[0])
    return deep
