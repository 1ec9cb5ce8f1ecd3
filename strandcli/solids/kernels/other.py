"""Solids of other packages in kernels that take `Solids` of either type.

Where these hold no solids of other packages the functions are compiled to nothing; where they do, to those of
`distance_field` with the distance that the type has.
"""

from __future__ import annotations

import numpy as np
from numba.extending import overload

from ..shapes.other import REACH
from . import distance_field as field


def distance_of(solids):
    """The compiled distance of a type of `Solids`; None where there are no solids of other packages."""
    return getattr(getattr(solids, "instance_class", None), "distance", None)


def count(solids):
    """How many of the `Solids` are of other packages."""


@overload(count)
def _count(solids):
    if distance_of(solids) is None:
        return lambda solids: 0
    return lambda solids: solids.others.shape[0]


def meet(solids, m, ox, oy, oz, dx, dy, dz):
    """`distance_field.trace` of number m of these."""


@overload(meet)
def _meet(solids, m, ox, oy, oz, dx, dy, dz):
    distance = distance_of(solids)
    if distance is None:
        return lambda solids, m, ox, oy, oz, dx, dy, dz: field.INF
    return lambda solids, m, ox, oy, oz, dx, dy, dz: field.trace(distance, solids.others, m, ox, oy, oz, dx, dy, dz)


def normal(solids, m, x, y, z):
    """Unit outward normal of number m of these at a point of its surface."""


@overload(normal)
def _normal(solids, m, x, y, z):
    distance = distance_of(solids)
    if distance is None:
        return lambda solids, m, x, y, z: (field.ZERO, field.ONE, field.ZERO)

    def found(solids, m, x, y, z):
        nx, ny, nz = field.gradient(distance, solids.others, m, field.FINE * solids.others[m, REACH], x, y, z)
        return np.float32(nx), np.float32(ny), np.float32(nz)

    return found


def lit(solids, x, y, z, lx, ly, lz, reach, skin):
    """1 where none of these stands between a point, moved by `skin` along the unit vector l, and a light; else 0."""


@overload(lit)
def _lit(solids, x, y, z, lx, ly, lz, reach, skin):
    distance = distance_of(solids)
    if distance is None:
        return lambda solids, x, y, z, lx, ly, lz, reach, skin: field.ONE
    return lambda solids, x, y, z, lx, ly, lz, reach, skin: field.lit_past_all(
        distance, solids.others, x, y, z, (lx, ly, lz), reach, skin
    )


def lowest_sine(solids, x, y, z, lx, ly, lz, reach, skin):
    """`distance_field.least_sine` of all of these; `CLEAR` where there are none."""


@overload(lowest_sine)
def _lowest_sine(solids, x, y, z, lx, ly, lz, reach, skin):
    distance = distance_of(solids)
    if distance is None:
        return lambda solids, x, y, z, lx, ly, lz, reach, skin: field.CLEAR
    return lambda solids, x, y, z, lx, ly, lz, reach, skin: field.least_sine_of_all(
        distance, solids.others, x, y, z, (lx, ly, lz), reach, skin
    )


def outside(solids, x, y, z, clear):
    """A point, moved to `clear` metres off the surfaces of these."""


@overload(outside)
def _outside(solids, x, y, z, clear):
    distance = distance_of(solids)
    if distance is None:
        return lambda solids, x, y, z, clear: (x, y, z)
    return lambda solids, x, y, z, clear: field.put_outside_all(distance, solids.others, x, y, z, clear)


def deepest(solids, positions, b):
    """Greatest depth of a block's particles in these and of its segments, metres."""


@overload(deepest)
def _deepest(solids, positions, b):
    distance = distance_of(solids)
    if distance is None:
        return lambda solids, positions, b: (field.ZERO, field.ZERO)
    return lambda solids, positions, b: field.deepest_of_all(distance, solids.others, positions, b)
