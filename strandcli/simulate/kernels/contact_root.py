"""Contact of free roots with solids: as of other particles, but no edge ends at them, so that nothing is rotated.

Compiled only where roots are free.
"""

from __future__ import annotations

from ...constants import W
from ...jit import device, inlined
from ...simd import any_lane, broadcast, load, load3, store, store3, where
from . import rod_loose, rod_start
from .contact import CLEAR, slack_of
from .contact_circle import TINY
from .contact_forces import DEEP, FAINT, HOVER, ROW, direction_of, resting_depth
from .contact_place import CARRIED, normal_at
from .contact_shapes import edges_of, nearest
from .contact_spots import NORMAL, NOWHERE, Spot, begin_spot, keep_spot, released, size_of, update_spot
from .rod_loose import MASS, ROOT
from .rod_scratch import CORRECTION, IMPACT, INERTIAL, INVERSE_LENGTH, INVERSE_PIVOT, MOBILITY, PACK, REACH
from .rod_tension import GAIN, of_root
from .vectors import add_scaled, dot, scaled, select

ROUNDS = 3
"""Moves out of overlapping solids."""


@inlined
def spot_of_root(n, row):
    """The spot of the root of a strand with n segments."""
    place = of_root(n)
    return Spot(ROOT, row, place, place + GAIN, place + GAIN + 1, NOWHERE)


@device
def begin(s, at, state, pressed):
    """As `contact_forces.begin`."""
    begin_spot(s, spot_of_root(at.segments, rod_loose.row_of(at)), state.root_push, pressed)


@device
def search(s, at, length, state, scheme, contact):
    """As `contact_forces.search` of the root; ``scheme``: with forces of contact. Returns where it is, too."""
    body, spot = rod_loose.body_of(state), spot_of_root(at.segments, rod_loose.row_of(at))
    begun = load3(state.positions, at.position + ROW, W)
    way = add_scaled(rod_start.predict(s, spot.row, body, scheme), -1.0, load3(s, ROOT + INERTIAL, 1))
    way = add_scaled(way, -1.0, load3(s, ROOT + rod_loose.SHIFT, 1))
    q = add_scaled(begun, length, way)
    held = load(s, REACH) * size_of(load3(body.push, spot.row, PACK))
    within = max(where(held > 0.0, at.segments * length, CLEAR * length), held)
    zero = broadcast(s, 0.0)
    none = zero, zero, zero
    edges = edges_of(s, ROOT, none, length, contact.segments, False)
    depth, found = nearest(s, q, edges, (state.positions, at.position + ROW, True), within, contact.solids)
    close = depth > -within
    inside = close & ((depth > slack_of(length, begun, contact)) | (held > 0.0))
    acted = any_lane(inside | (held > 0.0))
    if acted:
        n = normal_at(s, found, q, depth)
        slid = add_scaled(q, -1.0, load3(s, found + CARRIED, 1))
        wanted = add_scaled(scaled(depth + dot(slid, n), n), -1.0, slid)
        n, wanted = select(inside, n, none), select(inside, wanted, none)
        store3(s, ROOT + NORMAL, 1, n[0], n[1], n[2])
        store3(s, spot.wanted, 1, wanted[0], wanted[1], wanted[2])
        lasting = load(s, spot.lasting)
        new = inside & (lasting < 0.0)
        since = load3(body.velocity, spot.row, PACK), begun
        rest = resting_depth(load3(s, found + CARRIED, 1), since, n, depth, contact.duration)
        store(s, spot.lasting, where(new, rest / max(depth, TINY), lasting))
        store(s, IMPACT, where(new, 1.0, load(s, IMPACT)))
        push = load3(body.push, spot.row, PACK)
        push = select(inside & ~(size_of(push) > 0.0), scaled(FAINT, n), push)
        store3(body.push, spot.row, PACK, push[0], push[1], push[2])
    far = (held > DEEP * length) & ~inside
    deep = (inside & ((depth > DEEP * length) | (depth < -HOVER * length))) | far
    return q, acted, any_lane(close | (held > 0.0)), deep


@device
def update(s, at, state, contact, gain, along, load_of_root):
    """As `contact_forces.update` of the root; returns what that takes of it. ``load_of_root``: as
    `rod.begin_mobility` returns it."""
    spot, mass = spot_of_root(at.segments, rod_loose.row_of(at)), load(s, ROOT + MASS)
    acted = size_of(load3(state.root_push, spot.row, PACK)) > 0.0
    zero = broadcast(s, 0.0)
    y = load(s, ROOT + INVERSE_PIVOT) * (where(acted, mass, 0.0) - load_of_root)
    store(s, ROOT + MOBILITY, y)
    factors = load(s, REACH), gain, contact.friction, direction_of(s, along)
    return y, update_spot(s, spot, state.root_push, mass, factors, along, (zero, zero, zero))


@device
def mark_released(s, at, state):
    """As `contact_forces.mark_released`."""
    gone = released(s, spot_of_root(at.segments, rod_loose.row_of(at)), state.root_push)
    store(s, IMPACT, where(gone, 1.0, load(s, IMPACT)))


@device
def keep_out(s, at, place, length, state, contact):
    """Move the root from its ``place`` out of all solids, the deepest first, and leave of its force what lasts; return
    by how much, in segments, which `CORRECTION` has then."""
    zero = broadcast(s, 0.0)
    begun, end = load3(state.positions, at.position + ROW, W), place
    slack = slack_of(length, begun, contact)
    edges = edges_of(s, ROOT, (zero, zero, zero), length, False, False)
    for _ in range(ROUNDS):
        depth, found = nearest(s, end, edges, (state.positions, at.position + ROW), -slack, contact.solids)
        inside = depth > slack
        if not any_lane(inside):
            break
        end = add_scaled(end, where(inside, depth, 0.0), normal_at(s, found, end, depth))
    way = scaled(load(s, INVERSE_LENGTH), add_scaled(end, -1.0, place))
    store3(s, CORRECTION, 1, way[0], way[1], way[2])
    keep_spot(s, spot_of_root(at.segments, rod_loose.row_of(at)), state.root_push)
    return way


@inlined
def pushed(s, n):
    """Mass of the root times the displacement by which the last change of pressure would move it if it were free, over
    `rod_scratch.ACCELERATION_SCALE`."""
    return scaled(load(s, ROOT + MASS), load3(s, of_root(n) + GAIN + 1, 1))


@inlined
def wanted(s, n):
    """By how much contact should move the root, metres."""
    return load3(s, of_root(n), 1)
