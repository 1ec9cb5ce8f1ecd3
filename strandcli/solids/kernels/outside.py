"""Moving a point out of all solids."""

from __future__ import annotations

from ...jit import device
from . import box, built_in, capsule, other, plane, sphere
from .built_in import device_if_built_in


@device
def outside(x, y, z, clear, solids):
    """Return a point, moved out of one of the `Solids` after the other along its normal, to `clear` metres from its
    surface. A later solid may move it into an earlier one."""
    x, y, z = outside_built_in(solids, x, y, z, clear)
    return other.outside(solids, x, y, z, clear)


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
    return built_in.count(solids) + other.count(solids)
