"""Roots that are free: a strand's first particle moves by the step's equations as all others do.

In Bellman's recursion (`rod`) the root is one particle more: what the strand beyond costs it, ½ a y² + p·y, and its own
mass and load are least at y = −(p + …) / (a + m). For the Kalman filter (`rod_tension`) it is the process's first
state, of the variance 1 / (a + m). When lengths are made exact the strand is shifted so that no momentum comes from it.
Compiled only where roots are free.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from ...jit import device, inlined
from ...simd import broadcast, load, load3, sqrt, store, store3
from .records import ROOT_MASS
from .rod_scratch import (
    AXES,
    EDGE,
    FIRST_SEGMENT,
    INERTIAL,
    INVERSE_PIVOT,
    LOAD,
    PACK,
    REST_BEND,
    SEGMENT,
    TENSION,
)
from .rod_tension import TINY

ROOT = FIRST_SEGMENT - SEGMENT
"""Place of the root among segments: its inertial residual and load lie as a segment's do, 1 / (a + m) as a pivot."""
MASS = TENSION
SHIFT = REST_BEND
"""(3) In the last sweep: by how much the strand is shifted, in segments."""


class Body(NamedTuple):
    """What `rod_start.predict` and the end of a step read and write of a root, as of a particle in `State`."""

    velocity: Any
    before: Any
    ahead: Any
    moved: Any
    push: Any
    crowd: Any


@inlined
def body_of(state):
    """The root's motion."""
    return Body(
        state.root_velocity, state.root_before, state.root_ahead, state.root_moved, state.root_push, state.root_crowd,
    )  # fmt: skip


@inlined
def row_of(at):
    """The place of a root in (P, 1, 3 S)."""
    return at.strand // PACK * AXES + at.strand % PACK


@device
def begin(s, forcing, free):
    """Set the root's mass and its free displacement ``free``, and no direction but the first edge's."""
    store(s, ROOT + MASS, broadcast(s, forcing.numbers[ROOT_MASS]))
    store3(s, ROOT + INERTIAL, 1, free[0], free[1], free[2])
    x, y, z = load3(s, FIRST_SEGMENT + EDGE, 1)
    store3(s, ROOT + EDGE, 1, x, y, z)


@device
def set_pivot(s, a):
    """Set 1 / (a + m)."""
    store(s, ROOT + INVERSE_PIVOT, 1.0 / max(a + load(s, ROOT + MASS), TINY))


@device
def set_load(s, p, force):
    """Set what loads alone change of the root, from p of V and the first edge's force."""
    x, y, z = load3(s, ROOT + INERTIAL, 1)
    m, i = load(s, ROOT + MASS), load(s, ROOT + INVERSE_PIVOT)
    store3(
        s, ROOT + LOAD, 1,
        i * (p[0] - m * x - force[0]), i * (p[1] - m * y - force[1]), i * (p[2] - m * z - force[2]),
    )  # fmt: skip


@inlined
def change(s):
    """The root's whole change."""
    x, y, z = load3(s, ROOT + LOAD, 1)
    return -x, -y, -z


@device
def move(s, step):
    """Take the root's change from what is left of its free displacement; return the whole change."""
    x, y, z = load3(s, ROOT + LOAD, 1)
    u, v, w = load3(s, ROOT + INERTIAL, 1)
    store3(s, ROOT + INERTIAL, 1, u + step * x, v + step * y, w + step * z)
    return -x, -y, -z


@device
def energy(s):
    """Twice the root's energy."""
    x, y, z = load3(s, ROOT + INERTIAL, 1)
    return load(s, ROOT + MASS) * (x * x + y * y + z * z)


@device
def find_shift(s, n, mass):
    """Set `SHIFT`: the mean, by mass, of what making edges exact moves the particles by."""
    x = broadcast(s, 0.0)
    y, z = x, x
    dx, dy, dz = x, x, x
    total = load(s, ROOT + MASS)
    for j in range(n):
        ex, ey, ez = load3(s, FIRST_SEGMENT + j * SEGMENT + EDGE, 1)
        ex, ey, ez = ex - dx, ey - dy, ez - dz
        q = max(ex * ex + ey * ey + ez * ez, TINY)
        size = sqrt(q)
        f = (1.0 - q) / (q + size)
        dx, dy, dz = f * ex, f * ey, f * ez
        x, y, z = x + mass[j] * dx, y + mass[j] * dy, z + mass[j] * dz
        total += mass[j]
    f = 1.0 / total
    store3(s, ROOT + SHIFT, 1, f * x, f * y, f * z)
