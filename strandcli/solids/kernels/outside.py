"""Moving a point out of all solids."""

from __future__ import annotations

from ...jit import device
from . import box, capsule, other, plane, sphere


@device
def outside(x, y, z, clear, solids):
    """Return a point, moved out of one of the `Solids` after the other along its normal, to `clear` metres from its
    surface. A later solid may move it into an earlier one."""
    for s in range(solids.spheres.shape[0]):
        x, y, z = sphere.outside(solids.spheres, s, x, y, z, clear)
    for s in range(solids.capsules.shape[0]):
        x, y, z = capsule.outside(solids.capsules, s, x, y, z, clear)
    for s in range(solids.planes.shape[0]):
        x, y, z = plane.outside(solids.planes, s, x, y, z, clear)
    for s in range(solids.boxes.shape[0]):
        x, y, z = box.outside(solids.boxes, s, x, y, z, clear)
    return other.outside(solids, x, y, z, clear)


@device
def count(solids):
    """Return the number of `Solids`."""
    shipped = solids.spheres.shape[0] + solids.capsules.shape[0] + solids.planes.shape[0] + solids.boxes.shape[0]
    return shipped + other.count(solids)
