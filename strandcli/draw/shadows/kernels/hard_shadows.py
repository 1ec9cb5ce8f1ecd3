"""Hard shadows of solids at a batch of points: `rays.visibility`, vectorised over points where solids are spheres and
planes."""

from __future__ import annotations

from ....jit import device
from ....solids.kernels import plane, sphere
from ....solids.kernels.built_in import device_if_built_in
from ....solids.kernels.outside import count
from ...common.kernels.batch import ARRIVES, LX, REACH, X, vector_at
from ...common.kernels.numbers import ZERO
from ...solids.kernels import rays


@device
def hard_shadows(work, n, solids, skin):
    """Set the rows `ARRIVES` of the first n points of a batch to 0 where a solid occludes the light.

    Rows of `batch`; solids: `strandcli.solids.Solids`; skin: as in `rays.visibility`.
    """
    past_spheres(solids, work, n, skin)
    past_planes(solids, work, n, skin)
    if count(solids) > solids.spheres.shape[0] + solids.planes.shape[0]:
        for k in range(n):
            if work[ARRIVES + k] > ZERO:
                x, y, z = vector_at(work, X, k)
                lx, ly, lz = vector_at(work, LX, k)
                work[ARRIVES + k] *= rays.visibility_past_others(solids, x, y, z, lx, ly, lz, work[REACH + k], skin)


@device_if_built_in(lambda solids, work, n, skin: None)
def past_spheres(solids, work, n, skin):
    """Set the rows `ARRIVES` to 0 where a sphere occludes the light."""
    for s in range(solids.spheres.shape[0]):
        for k in range(n):
            x, y, z = vector_at(work, X, k)
            lx, ly, lz = vector_at(work, LX, k)
            work[ARRIVES + k] *= sphere.visibility(solids.spheres, s, x, y, z, lx, ly, lz, work[REACH + k], skin)


@device_if_built_in(lambda solids, work, n, skin: None)
def past_planes(solids, work, n, skin):
    """Set the rows `ARRIVES` to 0 where a plane occludes the light."""
    for s in range(solids.planes.shape[0]):
        for k in range(n):
            x, y, z = vector_at(work, X, k)
            lx, ly, lz = vector_at(work, LX, k)
            t = plane.meet(solids.planes, s, x + skin * lx, y + skin * ly, z + skin * lz, lx, ly, lz)
            hides = (skin < t) & (t < work[REACH + k])
            work[ARRIVES + k] = ZERO if hides else work[ARRIVES + k]
