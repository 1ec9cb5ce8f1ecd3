"""Slots of scratch for the solid that a particle is deepest in: two, written in turns.

A slot describes the shape that the particle is kept out of: a ball, or the half-space below a face.
"""

from __future__ import annotations

from ...constants import W
from ...jit import inlined
from ...simd import any_lane, broadcast, load, load3, sqrt, store, where
from .records import MOTION_SHIFT
from .vectors import add_scaled, dot

CENTRE = 0
"""(3) Centre of the ball, or outward unit normal of the face."""
SIZE = 3
"""Radius of the ball, or the face's coordinate along the normal."""
CARRIED = 4
"""(3) The particle's position before the step, moved with the solid."""
ROUND = 7
"""1 for a ball, 0 for a face."""
SLOT = 8
"""Number of vectors in a slot."""
TINY = 1e-20
STEEP = 0.01
"""Least sine, squared, of the angle between an edge and a surface by which its sliding is found."""
CARRIES = 2
"""Members of ``at`` beyond which a slot is to have `CARRIED`."""


@inlined
def is_nearer(s, known, depth, most, place, size):
    """Whether a particle is deeper than ``most`` in a shape, which is not the one in the slot ``known``; that may be
    None. place, size: as of `write_slot`."""
    if known is None:
        return depth > most
    away = abs(place[0] - load(s, known + CENTRE)) + abs(place[1] - load(s, known + CENTRE + 1))
    away += abs(place[2] - load(s, known + CENTRE + 2)) + abs(size - load(s, known + SIZE))
    return (depth > most) & (away > 0.0)  # computed by the same code: those of one solid have the same bits


@inlined
def write_slot(s, found, other, nearer, round, place, size, solids, moved, at):
    """Write this solid, in lanes where ``nearer`` is set, or the content of slot ``found`` to slot ``other``; return
    the indices of both slots, exchanged.

    round: 1.0 or 0.0; place: centre or normal; size: radius or coordinate along the normal; solids: the solid's motion
    begins at column ``moved``; at: positions, and the index in them of the particle before the step. `CARRIED` is
    written where ``at`` has a third member; `contact_others.carry` then adds the drift of surfaces.
    """
    # two slots, because masked stores are slow
    store(s, other + CENTRE, where(nearer, place[0], load(s, found + CENTRE)))
    store(s, other + CENTRE + 1, where(nearer, place[1], load(s, found + CENTRE + 1)))
    store(s, other + CENTRE + 2, where(nearer, place[2], load(s, found + CENTRE + 2)))
    store(s, other + SIZE, where(nearer, size, load(s, found + SIZE)))
    store(s, other + ROUND, where(nearer, broadcast(size, round), load(s, found + ROUND)))
    if len(at) > CARRIES:
        x, y, z = load3(at[0], at[1], W)
        for k in range(3):
            row = moved + 3 * k
            there = solids[row] * x + solids[row + 1] * y + solids[row + 2] * z + solids[moved + MOTION_SHIFT + k]
            store(s, other + CARRIED + k, where(nearer, there, load(s, found + CARRIED + k)))
    return other, found


@inlined
def normal_at(s, found, end, depth):
    """Return the unit normal of the solid in slot ``found`` at a particle ``depth`` below its surface."""
    round = load(s, found + ROUND) > 0.0
    centre = load3(s, found + CENTRE, 1)
    x, y, z = end[0] - centre[0], end[1] - centre[1], end[2] - centre[2]
    away = load(s, found + SIZE) - depth
    deep = round & (depth > away)
    if any_lane(deep):  # near the centre, the radius less the depth cancels
        away = where(deep, sqrt(x * x + y * y + z * z), away)
    away = 1.0 / max(away, TINY)
    return (
        where(round, away * x, centre[0]), where(round, away * y, centre[1]), where(round, away * z, centre[2]),
    )  # fmt: skip


@inlined
def carried_to(s, found, segment, state, contact):
    """Where the solid in slot ``found`` carries a particle in this step."""
    carried = load3(s, found + CARRIED, 1)
    if not contact.moved:
        carried = load3(state.positions, segment.position, W)
    return carried


@inlined
def slide(carried, end, d, n, depth):
    """Return the vector by which a particle slides on a solid in this step: from its position ``carried`` by that to
    the point where the edge, rotated, ends at the surface."""
    f = dot(d, n)
    turned = f * (depth / max(1.0 - f * f, STEEP))
    return add_scaled((end[0] - carried[0], end[1] - carried[1], end[2] - carried[2]), -turned, d)
