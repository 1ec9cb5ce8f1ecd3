"""What contact with solids keeps of one particle of a rod, and its updates.

See `contact_forces` for what forces are.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from ...jit import inlined
from ...simd import any_lane, broadcast, load, load3, store, store3, where
from .contact_cone import by_one, by_two, pressing_of
from .rod_scratch import (
    ACCELERATION_SCALE,
    CONTACT_CHANGE,
    CONTACT_FORCE,
    FIRST_SEGMENT,
    INERTIAL,
    LOAD,
    MOBILITY,
    PACK,
    SEGMENT,
)
from .rod_tension import force_change, lasting_share, particle_gain
from .vectors import add_scaled, dot, scaled, select

NORMAL = LOAD
"""(3) In a round: the normal of the solid that a particle is in, zero where it is in none."""
LEAST_MOBILITY = 1e-6
"""Lower bound of a particle's mobility as a share of its own."""
NOWHERE = -1
"""Place of what is not there."""
UNKNOWN = -1.0
"""Lasting share of a particle that nothing has pressed so far."""


class Spot(NamedTuple):
    """Places of what contact keeps of a particle: in the scratch, but for ``row``."""

    scratch: Any
    """Of its segment."""
    row: Any
    """In the arrays of forces."""
    wanted: Any
    """(3) By how much contact should move it, metres."""
    lasting: Any
    """As `rod_tension.lasting_share`."""
    change: Any
    """As `rod_tension.force_change`."""
    other: Any
    """Normal of a second solid (3), zero where there is none, and by how much that should move the particle (3);
    `NOWHERE` where second ones are not looked for."""


@inlined
def spot_of(n, j, row, other=NOWHERE):
    """The spot of the particle after segment j of n."""
    return Spot(FIRST_SEGMENT + j * SEGMENT, row, particle_gain(n, j), lasting_share(n, j), force_change(n, j), other)


@inlined
def size_of(vector):
    """The sum of the absolute coordinates."""
    return abs(vector[0]) + abs(vector[1]) + abs(vector[2])


@inlined
def begin_spot(s, spot, push, pressed):
    """Set which share of the force lasts at the begin of a step: all, where there is one."""
    share = broadcast(s, UNKNOWN)
    if pressed:
        share = where(size_of(load3(push, spot.row, PACK)) > 0.0, 1.0, share)
    store(s, spot.lasting, share)


@inlined
def update_spot(s, spot, push, mass, factors, along, sums):
    """Update the force by what is wanted, as `contact_forces.update` says, and return that function's ``sums`` with
    what it is, what it changes, and its work. ``factors``: displacement by an acceleration, metres; that of what is
    wanted; friction; -1 in lanes that take a change back, else 1."""
    reach, gain, friction, sign = factors
    total, changed, work = sums
    past = load3(push, spot.row, PACK)
    acted = size_of(past) > 0.0
    last = scaled(along.kept, load3(s, spot.change, 1))
    if any_lane(acted):
        mobility = load(s, spot.scratch + MOBILITY)
        mobility = where(acted & (mobility > 0.0), min(max(mobility, LEAST_MOBILITY), 1.0), 1.0)
        f = reach * mobility
        normal, wanted = load3(s, spot.scratch + NORMAL, 1), load3(s, spot.wanted, 1)
        given = by_one(scaled(f, past), normal, scaled(gain, wanted), friction)
        if spot.other != NOWHERE:
            other, there = load3(s, spot.other, 1), load3(s, spot.other + 3, 1)
            if any_lane(dot(other, other) > 0.0):
                given = by_two(scaled(f, past), normal, scaled(gain, wanted), other, scaled(gain, there), friction)
        now = scaled(where(acted, 1.0 / f, 0.0), given.force)
        change = add_scaled(now, -1.0, past)
        change = select(along.going, scaled(along.move, last), change)
        pressing = pressing_of(given, change)
        work += mass * dot(pressing, given.wanted)
        keep_change(s, spot, select(along.going, last, pressing), given.normal)
        now = add_scaled(past, 1.0, change)
        store3(push, spot.row, PACK, now[0], now[1], now[2])
        x, v, w = add_scaled(load3(s, spot.scratch + INERTIAL, 1), load(s, ACCELERATION_SCALE), change)
        store3(s, spot.scratch + INERTIAL, 1, x, v, w)
        total += f * size_of(now)
        changed += f * size_of(change)
        store(s, CONTACT_CHANGE, load(s, CONTACT_CHANGE) + sign * size_of(change))
    else:
        none = broadcast(s, 0.0)
        keep_change(s, spot, select(along.going, last, (none, none, none)), (none, none, none))
    return total, changed, work


@inlined
def keep_change(s, spot, change, normal):
    """Keep the change of pressure, and the normal, for `contact_response`."""
    store3(s, spot.change, 1, change[0], change[1], change[2])
    store3(s, spot.change + 3, 1, normal[0], normal[1], normal[2])


@inlined
def lengthen_spot(s, spot, push, more):
    """Take the last change of pressure ``more`` times besides. Pressures do not become negative."""
    past, last = load3(push, spot.row, PACK), load3(s, spot.change, 1)
    normal = load3(s, spot.change + 3, 1)
    now = add_scaled(past, more, last)
    now = add_scaled(now, max(-dot(now, normal), 0.0), normal)
    change = add_scaled(now, -1.0, past)
    store3(push, spot.row, PACK, now[0], now[1], now[2])
    x, y, z = add_scaled(load3(s, spot.scratch + INERTIAL, 1), load(s, ACCELERATION_SCALE), change)
    store3(s, spot.scratch + INERTIAL, 1, x, y, z)
    store(s, CONTACT_CHANGE, load(s, CONTACT_CHANGE) + abs(dot(change, normal)))
    x, y, z = last[0] + change[0], last[1] + change[1], last[2] + change[2]
    store3(s, spot.change, 1, x, y, z)


@inlined
def released(s, spot, push):
    """Whether the particle is free that solids pressed."""
    free = ~(size_of(load3(push, spot.row, PACK)) > 0.0)
    return free & (load(s, spot.lasting) >= 0.0)


@inlined
def keep_spot(s, spot, push):
    """Leave of the force what lasts."""
    share = load(s, spot.lasting)
    force = load3(push, spot.row, PACK)
    if any_lane(share < 1.0):
        force = scaled(max(share, 0.0), force)
        store3(push, spot.row, PACK, force[0], force[1], force[2])
    store(s, CONTACT_FORCE, load(s, CONTACT_FORCE) + size_of(force))
