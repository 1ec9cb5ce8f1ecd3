"""Where solids touch a strand: gaps, normals, and by how much places have slid on the solids.

Of each segment the place that is deepest in a solid counts: its end, or where whole segments stay out any place of
it. A segment that comes into a solid becomes active; one whose solid pulls it is let go. In the last sweep an edge
whose end is in a solid is turned until it is outside: its end moves on a sphere around where the edge begins, by
Newton's method for a gap of 0. What is left to turn is what the iterations of the step have left, rounding and places
that no length reaches.
"""

from __future__ import annotations

import numpy as np

from ....jit import device, inlined
from ....jit.indices import NO
from ....simd import any_lane, broadcast, load, load3, sqrt, store, store3, where
from ....simd.vectors import add_scaled, dot, scaled, select
from ...rod.kernels.arrays import AXES, PACK, ROW
from . import law, search

ROOT = np.int64(-1)
"""Where the scratch has the contact of the root."""
SETTLED, CREEP = 0.5, 0.3
"""Depth, height and error of slip of what touches, in segments, with which iterations end, over that of |e|²."""
UNITS = 20
"""Least such depth in units of rounding."""
ROUNDING = 1e-6
"""Depth, in segments, that is no more than rounding."""
DEEP = 0.02
"""Depth, in segments, from which on a solid touches a place late in a step."""
SHARP = 0.1
"""Sine between the normals of two solids from which on both count."""
ABLE = 0.5
"""Depth of the beginning of a segment, in segments, up to which its end can be put out."""
ROUNDS = 4
SLACK, COORDINATES = 1e-6, 2e-7
"""Depth, as a share of an edge and of coordinates, that counts as rounding."""
STEEP = 1e-3
"""Least sine between an edge and a normal by which it is turned."""
LITTLE = 0.05
"""By which that sine grows at the most where the last search tells: strands that stand on a floor would not rest."""
KNOWN = 5e-3
"""Depth, in segments, up to which gap and normal of the last search tell where the surface is."""


@device
def begin(s, at, state, material, c, needs):
    """Begin with the forces of the step before, and add them to u*. Returns whether there are any."""
    scale = c.reach * c.inverse_length
    touching = False
    for j in range(at.segments):
        x, y, z = load3(state.force, at.edge + j * AXES, PACK)
        active = abs(x) + abs(y) + abs(z) > 0.0
        zero = broadcast(x, 0.0)
        share = zero + 1.0
        if needs.segments:
            share = where(active, load(state.share, at.number + j * PACK), share)
        store(s.share, j, share)
        store(s.active, j, where(active, 1.0, zero))
        store(s.corner, j, zero)
        store(s.mobility, j, zero + 1 / material.mass[j])
        store(s.compliance, 2 * j + 1, zero)
        store3(s.force, 3 * j, 1, zero, zero, zero)
        if any_lane(active):
            touching = True
            law.add_force(s, j, (scale * x, scale * y, scale * z), material.mass, needs.segments)
    return touching


@device
def let_go(s, n):
    """Have no forces of contact, and nothing known of where solids are."""
    zero = broadcast(s.pivot, 0.0)
    for j in range(n):
        store(s.active, j, zero)
        store(s.gap, j, zero - 1.0)
        store(s.second_gap, j, zero + search.FAR)
        store(s.place, j, zero + 1.0)
        store(s.share, j, zero + 1.0)
        for k in range(3):
            store(s.force, 3 * j + k, zero)
            store(s.normal, 3 * j + k, zero)
            store(s.second_normal, 3 * j + k, zero)


@device
def contacts(s, at, state, material, c, contact, needs, root, step, patience):
    """Set the contacts of all segments by the present edges; ``patience``: whether it is late in the step, and by how
    much more than at first contacts may be off.

    Returns whether solids touch some segment; whether u* has changed, for forces were taken back, or act elsewhere;
    whether some segment is nearer to a solid than its length, or touched by one; the greatest depth of each strand, in
    segments, of places that can be put out; and in which lanes some place is inside of a solid, away from one that
    touches it, or pulled by one, by more than `SETTLED` says, or slips otherwise than its friction by more than
    `CREEP`."""
    n, length = at.segments, c.length
    zero = broadcast(length, 0.0)
    touching, moved, some_near, depth, unsettled = False, False, False, zero, zero < 0.0
    start, before = root, zero
    none = zero, zero, zero
    past = search.Past(state.positions, at.position + 2 * ROW, contact.shift)
    law_of = step.friction, patience[0], patience[1] * max(step.contact_tolerance, UNITS / SETTLED * step.rounding)
    for j in range(n):
        end = add_scaled(start, length, load3(s.edge, 3 * j, 1))
        first = zero + search.LEAST_SHARE
        if j == 0 and needs.segments:
            before = gap_of_root(s, root, past, contact, length)
            first = where(before < 0.0, 1.0, zero + search.NEAR_ROOT)  # no turn of its segment gets a root out
        near = search.nearest(s, j, start, end, past, contact, (needs.segments, length, first))
        active = load(s.active, j) > 0.0
        if near or any_lane(active):
            if j == 0 and not needs.segments:
                before = gap_of_root(s, root, past, contact, length)
            gap = zero + search.FAR
            if near:
                gap = load(s.gap, j)
            else:
                store(s.second_gap, j, gap)
            some_near = True
            unable = ~(before > -ABLE * length)  # to keep the end out
            before = gap
            if any_lane(unable):
                store(s.second_gap, j, where(unable, search.FAR, load(s.second_gap, j)))
            gap = where(unable, search.FAR, gap)
            if any_lane(active | (gap < 0.0)):
                changed, free = update(s, j, gap, c, material.mass, (active, needs.segments), law_of)
                touching, moved = True, moved or free
                unsettled = unsettled | changed
            else:
                store(s.gap, j, c.inverse_length * gap)
            depth = max(depth, -c.inverse_length * gap)
        else:
            store(s.gap, j, search.FAR)
            store(s.second_gap, j, search.FAR)
            before = zero
        start = end
        past = search.Past(state.positions, past.place + ROW, none)
    return touching, moved, some_near, depth, unsettled


@device
def gap_of_root(s, root, past, contact, length):
    """The gap of the root, metres."""
    zero = broadcast(length, 0.0)
    if search.nearest(s, ROOT, root, root, past, contact, (NO, length, length)):
        return load(s.gap, ROOT)
    return zero


@inlined
def update(s, j, found, c, mass, lanes, law_of):
    """Set the contact of segment j to what was found. ``lanes``: which are active, and whether places may be elsewhere
    than at the end; ``law_of``: coefficient of friction, whether it is late, and the error of |e|² with which
    iterations end. Returns in which lanes it is not settled, and whether u* changes: forces of solids that would pull
    or are out of reach are taken back, the rest act at another place."""
    active, whole = lanes
    coefficient, late, tolerance = law_of
    settled = min(SETTLED * tolerance, DEEP)
    gap, second = c.inverse_length * found, c.inverse_length * load(s.second_gap, j)
    force = load3(s.force, 3 * j, 1)
    n, other = load3(s.normal, 3 * j, 1), load3(s.second_normal, 3 * j, 1)
    one, corner, pressed, corner_gap = across_of(n), broadcast(gap, 0.0) > 0.0, dot(force, n), gap
    if any_lane((second < 1.0) & (active | (gap < 0.0))):
        one, corner, pressed, corner_gap = corner_of(s, j, n, other, one, (gap, second), force)
    away = active & ((pressed < 0.0) | (gap > 1.0))
    # a corner that the first solid lets go is the second's
    swapped = away & corner
    n = select(swapped, other, n)
    gap = where(swapped, second, gap)
    away, corner = away & ~swapped, corner & ~away & (active | (gap < -ROUNDING))
    # what comes and goes without end stays away where it is not deep
    entering = ~active & (gap < (-DEEP if late else -ROUNDING))
    now = (active & ~away) | entering
    off = (active & ~away & (abs(gap) > settled)) | (entering & (gap < -settled)) | (now & (second < -settled))
    off = off | (away & (pressed * load(s.mobility, j) < -settled))
    free = any_lane(away)
    if free:
        none = broadcast(gap, 0.0)
        law.add_force(s, j, select(away, (-force[0], -force[1], -force[2]), (none, none, none)), mass, whole)
    store3(s.normal, 3 * j, 1, n[0], n[1], n[2])
    store(s.corner, j, where(corner, 1.0, broadcast(gap, 0.0)))
    if any_lane(swapped):
        one = select(swapped, across_of(n), one)
    store3(s.across, 3 * j, 1, one[0], one[1], one[2])
    store(s.gap, j, gap)
    if whole and move_force(s, j, mass):
        free = True
    store(s.active, j, where(now, 1.0, broadcast(gap, 0.0)))
    slip = scaled(c.inverse_length, load3(s.slip, 3 * j, 1))
    error = law.set_wanted(s, j, (n, one, gap, corner, corner_gap), slip, coefficient, late)
    return off | (now & (error > CREEP * tolerance)), free


@inlined
def move_force(s, j, mass):
    """Have the force act where the solid is nearest now. Returns whether it has moved in some lane."""
    share = load(s.place, j)
    away = any_lane(load(s.share, j) != share)
    if away:
        force = load3(s.force, 3 * j, 1)
        law.add_force(s, j, scaled(-1.0, force), mass, True)
        store(s.share, j, share)
        law.add_force(s, j, force, mass, True)
    return away


@inlined
def across_of(n):
    """A unit vector across a normal (Duff et al. 2017)."""
    sign = where(n[2] < 0.0, broadcast(n[2], -1.0), 1.0)
    a = 1.0 / (sign + n[2])
    return 1.0 - sign * n[0] * n[0] * a, -sign * (n[0] * n[1] * a), -sign * n[0]


@device
def corner_of(s, j, n, other, one, gaps, force):
    """Where a second solid touches the place of segment j, too: it has come into that, or presses it still. Returns the
    unit vector across the normal n, in these lanes in the plane of it and the ``other`` normal; these lanes; what the
    first solid presses with; and how far the second one is along that vector."""
    gap, second = gaps
    cosine = dot(n, other)
    x = add_scaled(other, -cosine, n)
    sine = sqrt(dot(x, x))
    rate = 1.0 / max(sine, SHARP)
    x = scaled(rate, x)
    pulled = rate * dot(force, x)  # by the second solid
    corner = (sine > SHARP) & ((second < -ROUNDING) | ((load(s.corner, j) > 0.0) & (pulled >= 0.0) & (second < 1.0)))
    pressed = dot(force, n) - where(corner, cosine * pulled, 0.0)
    return select(corner, x, one), corner, pressed, rate * (second - cosine * gap)


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
        if not search.nearest(s, j, start, end, past, contact, (NO, zero, zero)):
            break
        inside = lanes & (load(s.gap, j) < -slack)
        if not any_lane(inside):
            break
        d = turned(s, j, d, c.inverse_length * load(s.gap, j), inside, 1.0)
    return d
