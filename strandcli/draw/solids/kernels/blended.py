"""`smooth_union` and `sphere_tracing` of `Solids`; compiled to nothing where the type tells that none blends."""

from __future__ import annotations

from typing import Any

from ....jit.pruned import device_where
from . import smooth_union, sphere_tracing


def may_blend(solids: Any) -> bool:
    """Whether solids of this type may blend."""
    return bool(getattr(solids.instance_class, "blended", True))


@device_where(may_blend, lambda solids, m: False)
def blends(solids, m):
    """Return whether solid number m is part of the smooth union."""
    return smooth_union.blends(solids.spheres, solids.capsules, m)


@device_where(may_blend, lambda solids, ox, oy, oz, dx, dy, dz: smooth_union.INF)
def meet(solids, ox, oy, oz, dx, dy, dz):
    """Return `smooth_union.meet`; inf where nothing blends."""
    return smooth_union.meet(solids.spheres, solids.capsules, ox, oy, oz, dx, dy, dz)


@device_where(may_blend, lambda solids, x, y, z: (smooth_union.ZERO, smooth_union.ONE, smooth_union.ZERO))
def normal(solids, x, y, z):
    """Return `smooth_union.normal`; up where nothing blends."""
    return smooth_union.normal(solids.spheres, solids.capsules, x, y, z)


@device_where(may_blend, lambda solids, work, n: None)
def meet_all(solids, work, n):
    """Run `sphere_tracing.meet`; nothing where nothing blends."""
    sphere_tracing.meet(work, n, solids.spheres, solids.capsules)
