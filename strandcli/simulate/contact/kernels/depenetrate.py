"""The last of contact in a step: an edge whose end is in a solid is turned until it is outside.

Lengths stay exact: the end moves on a sphere around where the edge begins, by Newton's method for a gap of 0. What is
left to turn is what the iterations of the step have left, rounding and places that no length reaches.
"""

from __future__ import annotations

from ....jit import device, inlined
from ....simd import any_lane, broadcast, load, load3, sqrt, store3, where
from ...rod.kernels.vectors import add_scaled, dot, scaled, select
from . import search

ROUNDS = 4
SLACK, COORDINATES = 1e-6, 2e-7
"""Depth, as a share of an edge and of coordinates, that counts as rounding."""
STEEP = 1e-3
"""Least sine between an edge and a normal by which it is turned."""
LITTLE = 0.05
"""By which that sine grows at the most where the last search tells: strands that stand on a floor would not rest."""


KNOWN = 5e-3
"""Depth, in segments, up to which gap and normal of the last search tell where the surface is."""


@inlined
def turn_out(s, j, start, correction, c, contact, past, whole):
    """Turn edge j, which begins at ``start``, until its end is outside of all solids, by the gap and the normal that
    the last search has left and the ``correction`` of its end since then, in segments; those that are deeper by
    search. Add the turn to the correction and return that. Overwrites the gap and the normal of segment j."""
    d = begun = load3(s.edge, 3 * j, 1)
    gap = load(s.gap, j) + dot(load3(s.normal, 3 * j, 1), correction)
    second = c.inverse_length * load(s.second_gap, j) + dot(load3(s.second_normal, 3 * j, 1), correction)
    inside = (gap < 0.0) & (gap > -KNOWN)
    unknown = (gap < -KNOWN) | (second < 0.0)
    if whole:  # the last search may tell of another place of the segment
        elsewhere = (load(s.place, j) < 1.0) & (gap < 1.0)
        inside, unknown = inside & ~elsewhere, unknown | elsewhere
    if any_lane(inside):
        d = turned(s, j, d, gap, inside, LITTLE)
    if any_lane(unknown):
        d = search_out(s, j, start, d, c, contact, past, unknown)
    store3(s.edge, 3 * j, 1, d[0], d[1], d[2])
    return correction[0] + d[0] - begun[0], correction[1] + d[1] - begun[1], correction[2] + d[2] - begun[2]


@inlined
def turned(s, j, d, gap, inside, most):
    """The unit edge d, turned in some lanes by which its end leaves a solid with a ``gap`` below 0, in segments, its
    sine to the normal growing by no more than ``most``."""
    n = load3(s.normal, 3 * j, 1)
    along = dot(n, d)
    across = add_scaled(d, -along, n)
    size = sqrt(max(dot(across, across), STEEP * STEEP))
    along = min(along - gap, 1.0)
    sine = sqrt(max(1.0 - along * along, 0.0))
    least = size + most
    along = where(
        sine > least, where(along < 0.0, broadcast(along, -1.0), 1.0) * sqrt(max(1.0 - least * least, 0.0)), along
    )
    x = add_scaled(scaled(min(sine, least) / size, across), along, n)
    return select(inside, scaled(1.0 / sqrt(dot(x, x)), x), d)


@device
def search_out(s, j, start, d, c, contact, past, lanes):
    """The same of some lanes by search for the solids that the end is in, one after the other."""
    length = c.length
    zero = broadcast(length, 0.0)
    slack = SLACK * length + COORDINATES * (abs(start[0]) + abs(start[1]) + abs(start[2]))
    for _ in range(ROUNDS):
        end = add_scaled(start, length, d)
        if not search.nearest(s, j, start, end, past, contact, (False, zero, zero)):
            break
        inside = lanes & (load(s.gap, j) < -slack)
        if not any_lane(inside):
            break
        d = turned(s, j, d, c.inverse_length * load(s.gap, j), inside, 1.0)
    return d
