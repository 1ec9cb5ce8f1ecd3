"""`smooth_union` and `sphere_tracing` of `Solids`; compiled to nothing where the type tells that none blends."""

from __future__ import annotations

from numba.extending import overload

from . import smooth_union, sphere_tracing


def may_blend(solids):
    """Whether solids of this type may blend."""
    return getattr(solids.instance_class, "blended", True)


def blends(solids, m):
    """Return whether solid number m is part of the smooth union."""


@overload(blends)
def _blends(solids, m):
    if not may_blend(solids):
        return lambda solids, m: False
    return lambda solids, m: smooth_union.blends(solids.spheres, solids.capsules, m)


def meet(solids, ox, oy, oz, dx, dy, dz):
    """Return `smooth_union.meet`; inf where nothing blends."""


@overload(meet)
def _meet(solids, ox, oy, oz, dx, dy, dz):
    if not may_blend(solids):
        return lambda solids, ox, oy, oz, dx, dy, dz: smooth_union.INF
    return lambda solids, ox, oy, oz, dx, dy, dz: smooth_union.meet(
        solids.spheres, solids.capsules, ox, oy, oz, dx, dy, dz
    )


def normal(solids, x, y, z):
    """Return `smooth_union.normal`; up where nothing blends."""


@overload(normal)
def _normal(solids, x, y, z):
    if not may_blend(solids):
        return lambda solids, x, y, z: (smooth_union.ZERO, smooth_union.ONE, smooth_union.ZERO)
    return lambda solids, x, y, z: smooth_union.normal(solids.spheres, solids.capsules, x, y, z)


def meet_all(work, n, solids):
    """Run `sphere_tracing.meet`; nothing where nothing blends."""


@overload(meet_all)
def _meet_all(work, n, solids):
    if not may_blend(solids):
        return lambda work, n, solids: None
    return lambda work, n, solids: sphere_tracing.meet(work, n, solids.spheres, solids.capsules)
