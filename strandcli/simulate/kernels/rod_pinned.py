"""Tips that are pinned, in steps that are made in parts.

A pinned particle goes where its velocity before the step leads it (`simulate.rod_pinned`), which is known of a whole
step alone: parts that began with it would let the tip sink by what gravity adds to each.
"""

from __future__ import annotations

from ...jit import device, inlined
from ...simd import broadcast, load, load3, store, store3
from . import rod_start
from .rod_scratch import ADDED_VELOCITY, AXES, INVERSE_LENGTH, PACK, ROOT_SHIFT, VELOCITY_SCALE

HEAVY = 1e6
"""Factor of a pinned particle's mass."""
LIGHT = 1e3
"""Mass, over the first particle's, from which on the tip is pinned: drag multiplies all by the same."""


@inlined
def pinned(mass, n):
    """Whether tips of strands with n segments are pinned; those of one segment have no way to go."""
    return mass[n - 1] > LIGHT * mass[0]


@device
def goal(s, at, state, scheme):
    """Return where the tip is to be at the end of a whole step that has not begun, from the root as it is then, in
    segments."""
    inverse_length, last = load(s, INVERSE_LENGTH), at.edge + (at.segments - 1) * AXES
    x, y, z = rod_start.predict(s, last, state, scheme)
    u, v, w = load3(s, ROOT_SHIFT, 1)
    x, y, z = x - inverse_length * u, y - inverse_length * v, z - inverse_length * w
    u, v, w = tip(s, at, state)
    return x + u, y + v, z + w


@inlined
def tip(s, at, state):
    """The sum of all edges."""
    x, y, z = broadcast(s, 0.0), broadcast(s, 0.0), broadcast(s, 0.0)
    for j in range(at.segments):
        u, v, w = load3(state.edges, at.edge + j * AXES, PACK)
        x, y, z = x + u, y + v, z + w
    return x, y, z


@device
def lead(s, at, state, goal, share):
    """Give tips the velocity that leads them on by a ``share`` of the way to the goal in one step of Euler's method,
    and neither forces of contact nor strands around: the inverse of `rod_start.predict`."""
    place, rate, last = tip(s, at, state), share / load(s, VELOCITY_SCALE), at.edge + (at.segments - 1) * AXES
    for c in range(3):
        v = rate * (goal[c] - place[c]) - load(s, ADDED_VELOCITY + c)
        store(state.velocity, last + c * PACK, v)
    store3(state.push, last, PACK, broadcast(s, 0.0), broadcast(s, 0.0), broadcast(s, 0.0))
