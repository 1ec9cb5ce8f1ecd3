"""What scratch holds of the solid that a particle is deepest in: two places of 8 vectors, used in turns."""

from __future__ import annotations

from ...constants import W
from ...jit import inlined
from ...simd import broadcast, load, load3, store, where


@inlined
def find(s, found, other, nearer, round, place, size, solids, moved, at):
    """Write down a solid where a mask holds, and elsewhere what was found before; return both places, exchanged.

    place, size: as `contact_shapes.nearest` tells of them; the solid's motion is in columns from ``moved`` on; at:
    where the particle was, positions and a place in them.
    """
    # to the other place, for to write some lanes only takes processors long
    positions, here = at
    x, y, z = load3(positions, here, W)
    store(s, other, where(nearer, place[0], load(s, found)))
    store(s, other + 1, where(nearer, place[1], load(s, found + 1)))
    store(s, other + 2, where(nearer, place[2], load(s, found + 2)))
    store(s, other + 3, where(nearer, size, load(s, found + 3)))
    for k in range(3):
        row = moved + 3 * k
        there = solids[row] * x + solids[row + 1] * y + solids[row + 2] * z + solids[moved + 9 + k]
        store(s, other + 4 + k, where(nearer, there, load(s, found + 4 + k)))
    store(s, other + 7, where(nearer, broadcast(x, round), load(s, found + 7)))
    return other, found
