"""A point out of the solids that it is in: one after the other, each along its own normal."""

from __future__ import annotations

from ...jit import device
from . import box, capsule, other, plane, sphere


@device
def outside(x, y, z, clear, solids):
    """The point, `clear` metres off the surface of every one of the `Solids` that it was in or nearer to."""
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
    """How many `Solids` there are."""
    shipped = solids.spheres.shape[0] + solids.capsules.shape[0] + solids.planes.shape[0] + solids.boxes.shape[0]
    return shipped + other.count(solids)
