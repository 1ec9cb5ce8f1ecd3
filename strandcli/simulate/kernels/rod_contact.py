"""The rounds of a rod's step in which forces of contact with solids are found, and what follows for its end."""

from __future__ import annotations

from ...constants import W
from ...jit import device, inlined
from ...simd import any_lane, broadcast, load, load3, sqrt, where
from . import contact_corner, contact_forces, contact_response, rod, rod_newton, rod_pinned
from .contact_shapes import edges_of, nearest
from .records import Contact, Scheme
from .rod_scratch import FIRST_SEGMENT, INVERSE_LENGTH, REACH

ROUNDS, PLAIN, MOST_ROUNDS = 4, 10, 32
"""Rounds in which forces of contact are found, at most; the same where particles are deep in solids after these, or
above them though pressed; and the same where they are so still, as of strands that stand on their tips: these are asked
how they respond (`contact_response`). What rounds leave is carried on to the next step."""
CALM = 8
"""Rounds at the end of which pressures are lengthened no more, so that iterations come to an end."""
LIVELY, HALF = 2, 0.5
"""Rounds after which forces change by half of what depths ask for, where whole segments are kept out: one that is in a
solid is so for both of its particles, and forces might come and go from round to round."""
WHOLE_ROUNDS = 24
"""As `MOST_ROUNDS`, where whole segments are kept out."""


@inlined
def pressed_by(scheme, pressed):
    """A `Scheme` with ``pressed``."""
    return Scheme(scheme.share, pressed, scheme.mixed, scheme.crowded, scheme.duration, scheme.curled)


@inlined
def nearby(contact, near):
    """A `Contact` whose solids are there where they are ``near``."""
    return Contact(
        contact.solids, near, contact.segments, contact.duration, contact.friction, contact.rounding, contact.moved
    )


@inlined
def residual_of(worst):
    """| |e| − 1 | from | |e|² − 1 |, where that is up to 1 as of an edge that is too short: the greater of both."""
    return worst / (1.0 + sqrt(1.0 + where(worst > 1.0, worst, -worst)))


@device
def find(s, at, state, material, forcing, scheme, contact, iterations, worst):
    """Find the forces of contact of a step after its iterations, and go on with these. Returns the greatest
    | |e|² − 1 | of each lane, which was ``worst``, whether solids press some strand, whether some are near, and in
    which lanes rounds have come to no end and led the strand astray."""
    length, pressed, mass = load(material.lengths, at.strand), scheme.pressed, material.mass
    contact_forces.begin(s, at, state.push, pressed)
    contact_response.begin(s)
    lost = worst < 0.0
    rounds, pinned = WHOLE_ROUNDS if contact.segments else MOST_ROUNDS, rod_pinned.pinned(mass, at.segments)
    for count in range(rounds):
        acted, near, deep, astray = contact_forces.search(s, at, length, state, contact)
        pressed = pressed or acted
        # where pressures have been lengthened friction has to follow, so rounds go on
        asked = count > PLAIN and not contact.segments
        if not acted or (count >= ROUNDS and not any_lane(deep) and not asked):
            break
        rod.begin_mobility(s, at.segments, at.edge, mass, state.push)
        gain = HALF if contact.segments and count >= LIVELY else 1.0
        along = contact_response.nowhere(s)
        if asked:
            along = contact_response.bracket(s, at.segments, mass, worst)
        if not contact_forces.update(s, at, length, state, contact, mass, gain, along):
            break
        if PLAIN <= count < MOST_ROUNDS - CALM and not contact.segments:
            contact_response.lengthen(s, at, state, mass, along)
        worst = rod_newton.iterate(s, at, state, material, forcing, pressed_by(scheme, True), iterations, True)
        if count == rounds - 1:
            lost = unfound(s, at, state, contact, (deep, astray), pinned)
    if pressed:
        contact_forces.mark_released(s, at, state.push)
        if pinned:
            sprung = contact_forces.sprung(s, at, length, state)
            if any_lane(sprung):
                lost = lost | (sprung & ends_outside(s, at, length, state, contact))
    return worst, pressed, near or pressed, lost  # those that solids have just left are to be marked, too


@inlined
def unfound(s, at, state, contact, found, pinned):
    """In which lanes the last round has left forces that are not found: of what `contact_forces.search` has ``found``,
    those that are deep in solids or above them where tips are ``pinned`` or solids hold the strand between them, and
    in others those that are astray, where not whole segments are kept out."""
    deep, astray = found
    lost = load(s, REACH) < 0.0
    if not contact.segments:
        lost = lost | astray
    if pinned:
        return lost | (deep & ends_outside(s, at, 1.0 / load(s, INVERSE_LENGTH), state, contact))
    if contact_corner.several(contact.solids):
        lost = lost | (deep & contact_corner.between(s, at, state))
    return lost


@device
def ends_outside(s, at, length, state, contact):
    """In which lanes neither the root nor the tip begins the step in a solid: strands that lead into one have no end
    of rounds, and no part of a step would have."""
    zero = broadcast(s, 0.0)
    edges = edges_of(s, FIRST_SEGMENT, (zero, zero, zero), length, False, False)
    most = zero
    for row in range(1, at.segments + 2, at.segments):
        place = at.position + row * contact_forces.ROW
        depth, _ = nearest(s, load3(state.positions, place, W), edges, (state.positions, place), zero, contact.solids)
        most = max(most, depth)
    return most < contact_forces.DEEP * length
