"""How near lights are to the edges of solids by signed distances, for a batch of points, many at once.

Most rays have left a solid or are dark after a few steps, and the others, which go along a surface, take many. So all
take a few, and those that are not done are listed and go on side by side.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ....constants import W
from ....jit import device, inlined
from ....simd import lane_count, load, load3, pointer, store, where
from ....solids.kernels import other
from ...common.kernels import batch as row
from ...common.kernels.numbers import ONE, ZERO

FEW, ALL = np.int64(6), np.int64(1 << 40)
"""Steps that all rays take at the most, and listed ones."""


class Rays(NamedTuple):
    """Rows of rays: numbers of the first of three or of the only one."""

    point: np.int64
    way: np.int64
    """Unit vector to the light's centre."""
    reach: np.int64
    """Distance to it, metres."""
    radius: np.int64
    """Sine of the light's angular radius."""
    least: np.int64
    """Sine of the least angle to an edge so far."""
    place: np.int64
    """How far the ray has come, metres."""


OWN = Rays(
    np.int64(row.X),
    np.int64(row.LX),
    np.int64(row.REACH),
    np.int64(row.RADIUS),
    np.int64(row.LEAST),
    np.int64(row.AT_NEAR),
)
LISTED = Rays(
    np.int64(row.WX), np.int64(row.DX), np.int64(row.END), np.int64(row.NEAR), np.int64(row.HIGH), np.int64(row.FAR)
)


@device
def by_distances(work, n, solids, lift, skin):
    """Reduce the rows `LEAST` to the sines of the angles between lights and solids that have distances of vectors, as
    seen from points moved by `lift` metres toward the lights. Rows of `batch`: positions, lights, `RADIUS`."""
    for m in range(other.count(solids)):
        for k in range(n):
            work[row.AT_NEAR + k] = ZERO
        go(work, n, OWN, solids, m, (lift, skin), FEW)
        count = np.int64(0)
        for k in range(n):
            work[row.LIST + count] = np.float32(k)
            count += np.int64(work[row.ASKED + k])
        if count > 0:
            for j in range(count):
                k = np.int64(work[row.LIST + j])
                row.set_vector(work, row.WX, j, row.vector_at(work, row.X, k))
                row.set_vector(work, row.DX, j, row.vector_at(work, row.LX, k))
                work[row.END + j], work[row.NEAR + j] = work[row.REACH + k], work[row.RADIUS + k]
                work[row.HIGH + j], work[row.FAR + j] = work[row.LEAST + k], work[row.AT_NEAR + k]
            go(work, count, LISTED, solids, m, (lift, skin), ALL)
            for j in range(count):
                work[row.LEAST + np.int64(work[row.LIST + j])] = work[row.HIGH + j]


@device
def go(work, n, at, solids, m, lift_and_skin, most):
    """Let n rays go on through solid number m, in so many steps at the most; `ASKED` is 1 where they are not done. at:
    `Rays`; lift_and_skin: of `by_distances`."""
    rows = pointer(work)
    lanes = lane_count(rows)
    for k in range(n, -(-n // (2 * lanes)) * 2 * lanes):  # nothing to look for
        work[at.least + k] = ZERO
        work[at.radius + k] = ZERO
    for k in range(0, n, 2 * lanes):
        some = begun(rows, k, at, solids, m, lift_and_skin)
        if k + lanes >= n:
            t, least = other.walk_alone(solids, m, some, most)
            keep(rows, k, at, t, least, some)
            break
        others = begun(rows, k + lanes, at, solids, m, lift_and_skin)
        s, s_least, t, t_least = other.walk(solids, m, some, others, most)
        keep(rows, k, at, s, s_least, some)
        keep(rows, k + lanes, at, t, t_least, others)


@inlined
def begun(rows, k, at, solids, m, lift_and_skin):
    """Return what `other.walk` takes of a vector of rays."""
    lift, skin = lift_and_skin
    lx, ly, lz = way = load3(rows, at.way + k, W)
    x, y, z = load3(rows, at.point + k, W)
    light = load(rows, at.reach + k), load(rows, at.radius + k), skin
    along, t, end = other.begin_walk(solids, m, (x + lx * lift, y + ly * lift, z + lz * lift), way, light)
    return along, max(t, load(rows, at.place + k)), end, load(rows, at.least + k), light


@inlined
def keep(rows, k, at, t, least, ray):
    """Store where a vector of rays has come to, and whether there is more to look for."""
    _, _, end, _, light = ray
    store(rows, at.least + k, least)
    store(rows, at.place + k, t)
    store(rows, row.ASKED + k, where((t < end) & (least > -light[1]), ONE, ZERO * t))
