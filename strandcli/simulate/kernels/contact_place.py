"""Slots of scratch for the solid that a particle is deepest in: two, written in turns.

A slot tells what is to keep the particle out there: a ball, or a flat face.
"""

from __future__ import annotations

from ...constants import W
from ...jit import inlined
from ...simd import broadcast, load, load3, store, where
from .records import MOTION_SHIFT

CENTRE = 0
"""(3) Centre of the ball, or unit normal of the face, which points out of the solid."""
SIZE = 3
"""Radius of the ball, or the coordinate along the normal that the particle must have."""
CARRIED = 4
"""(3) Where the solid's motion has carried the place that the particle had before the step."""
ROUND = 7
"""1 for a ball, 0 for a face."""
SLOT = 8
"""Vectors of a slot."""


@inlined
def find(s, found, other, nearer, round, place, size, solids, moved, at):
    """Write the slot ``other``: of this solid where ``nearer`` holds, else what the slot ``found`` has. Returns the
    places of both slots, exchanged.

    round: 1.0 or 0.0; place: centre or normal; size: radius or coordinate along the normal; ``solids`` has the solid's
    motion in columns from ``moved`` on; at: positions, and the place in them of the particle before the step.
    """
    # two slots, since processors take long to store some lanes only
    positions, here = at
    x, y, z = load3(positions, here, W)
    store(s, other + CENTRE, where(nearer, place[0], load(s, found + CENTRE)))
    store(s, other + CENTRE + 1, where(nearer, place[1], load(s, found + CENTRE + 1)))
    store(s, other + CENTRE + 2, where(nearer, place[2], load(s, found + CENTRE + 2)))
    store(s, other + SIZE, where(nearer, size, load(s, found + SIZE)))
    for k in range(3):
        row = moved + 3 * k
        there = solids[row] * x + solids[row + 1] * y + solids[row + 2] * z + solids[moved + MOTION_SHIFT + k]
        store(s, other + CARRIED + k, where(nearer, there, load(s, found + CARRIED + k)))
    store(s, other + ROUND, where(nearer, broadcast(x, round), load(s, found + ROUND)))
    return other, found
