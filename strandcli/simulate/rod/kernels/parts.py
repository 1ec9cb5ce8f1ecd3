"""The fallback of a rod's step: the same step in 2, 4 or 8 parts by Euler's method.

A strand goes by the best of these, whole or in parts; the strands beside it in the vector keep theirs. One that finds
no lengths in any of these takes 8 parts without forces of solids, by the rest shapes that each begins with: then the
last sweep alone turns its edges out.
"""

from __future__ import annotations

from ....constants import W
from ....jit import device, inlined
from ....jit.indices import NO
from ....simd import any_lane, broadcast, load, load3, store, store3, where
from ....simd.vectors import add_scaled, scaled
from ...contact.kernels import find
from ...contact.kernels.search import Contact
from . import begin, finish, newton, rest_shape
from .arrays import AXES, PACK, ROW, Needs

LOST = 2e-3
"""Error of |e|² from which on iterations have found no lengths, in proportion beyond `newton.FINE` segments."""
GRAVE = 0.1
"""The same of curled strands for the last attempt: rest shapes that do not follow let them gain energy."""
DEEP = 0.05
"""Depth in solids, in segments, from which on a step is taken again in parts."""
RIGHT = 0.95
"""Least change of an edge, before it is brought to unit length, that turns it by a right angle, rounded down."""
TURNED = 2.0
"""Badness of a step in which an edge has turned by more than a right angle."""
MOST_PARTS, LAST = 8, 4
"""Parts at the most, and the last attempt: after a whole step and 2, 4 and 8 parts another one in 8, by rest
shapes of their begin without forces of solids."""
SAVED = 24
"""Numbers of a segment's state that are saved: five vectors, and from these places on the rest."""
POSITION, FORCE, TENSION, SHARE, TWIST = 15, 18, 21, 22, 23


@device
def badness(s, at, state, worst, depth, path):
    """Return how bad a step is, above 1 where it is to be taken again: by the ``worst`` error of |e|², the ``depth`` in
    solids, and edges that have turned by more than a right angle. No step that long follows these, and a limp strand
    that stands upright would turn back at once. ``path``: how far edges have changed, at the most."""
    least = LOST * max(1.0, at.segments / newton.FINE)
    bad = max(worst * (1.0 / least), depth * (1.0 / DEEP))
    if any_lane(path > RIGHT):
        for j in range(at.segments):
            x, y, z = load3(state.edges, at.edge + j * AXES, PACK)
            u, v, w = load3(s.edge, 3 * j, 1)
            bad = where(x * u + y * v + z * w < 0.0, max(bad, TURNED), bad)
    return bad


@device
def attempt(s, at, state, material, drive, step, needs, met, how):
    """Take the step, whole or in several parts by Euler's method from where it began. Parts are taken in the frame of
    the root at the step's end; solids are as at that end. ``how``: in how many parts, whether solids press and rest
    shapes follow in the iterations, the pack of which finishing prefetches the state, and the badness of the best step
    so far: parts end once all lanes are as bad. Returns the greatest badness and error of the parts. Where a whole step
    is bad it leaves in the scratch what it began with."""
    contact, (root, shift) = met
    parts, pressed, next_pack, least = how
    found = Needs(
        needs.curled and pressed, needs.solids and pressed, needs.segments, needs.deforming, needs.pinned, needs.pushed,
        needs.lasting,
    )  # fmt: skip
    whole = parts == 1
    bad = worst = broadcast(s.pivot, 0.0)
    still = bad, bad, bad
    frame, moved, aimed = still, shift, still
    if not whole:
        frame, moved, aimed = scaled(1.0 / step.duration, shift), still, shift
        add_velocity(at, state, scaled(-1.0, frame))
    c = begin.coefficients_of(at, state, material, drive, step, needs, parts, frame)
    for i in range(parts):
        begin.begin(s, at, state, needs, c, moved)
        if needs.pinned:
            begin.aim_tip(s, at, drive, c, parts, aimed)
        own = with_shift(contact, i == 0, shift if i == 0 else still)
        if needs.curled and not pressed:
            rest_shape.begin(s, at, state, material, step, c)
        error, depth, near, path = newton.iterate(s, at, state, material, step, found, c, own, root)
        worst = max(worst, error)
        bad = max(bad, badness(s, at, state, error, depth, path))
        if not (whole or any_lane(bad < least)):
            break
        if needs.solids and not pressed:
            find.let_go(s, at.segments)
            near = True
        if whole and any_lane(bad > 1.0):
            copy(s.begun, at, state, needs, bad >= 0.0, NO, NO)
        finish.finish(s, at, next_pack, state, material.bends, step, needs, c, (own, near), moved)
        if not whole:
            add_to_means(s, at, state, needs, (i, parts))
    if not whole:
        add_velocity(at, state, frame)
    return bad, worst


@device
def add_velocity(at, state, velocity):
    """Add a velocity to that of all particles."""
    for j in range(at.segments):
        row = at.edge + j * AXES
        x, y, z = add_scaled(load3(state.velocity, row, PACK), 1.0, velocity)
        store3(state.velocity, row, PACK, x, y, z)


@inlined
def with_shift(contact, moved, shift):
    """A `Contact` of a step, or a part of it, in which the root moves by a ``shift``."""
    return Contact(contact.spheres, contact.capsules, contact.planes, contact.boxes, contact.custom, moved, shift)


@device
def add_to_means(s, at, state, needs, part):
    """Add the tensions and forces of a part to their means; have the next step begin with these after the last part:
    those of a part alone would throw strands in a whole step. ``part``: its number, and how many there are."""
    i, parts = part
    share = 1.0 / parts
    for j in range(at.segments):
        number, row = at.number + j * PACK, at.edge + j * AXES
        t = share * load(state.tension, number)
        force = t * 0.0, t * 0.0, t * 0.0
        if needs.solids:
            force = scaled(share, load3(state.force, row, PACK))
        if i > 0:
            t += load(s.mean, 4 * j + 3)
            force = add_scaled(force, 1.0, load3(s.mean, 4 * j, 1))
        store3(s.mean, 4 * j, 1, force[0], force[1], force[2])
        store(s.mean, 4 * j + 3, t)
        if i == parts - 1:
            store(state.tension, number, t)
            if needs.solids:
                store3(state.force, row, PACK, force[0], force[1], force[2])


@device
def copy(saved, at, state, needs, lanes, twist, back):
    """Copy the state of some lanes, with the ``twist`` or without, to where it is ``saved``; or all ``back``."""
    vectors = state.edges, state.velocity, state.before, state.ahead, state.moved
    for j in range(at.segments):
        row, number, o = at.edge + j * AXES, at.number + j * PACK, SAVED * j
        for k in range(len(vectors)):
            copy3(saved, o + 3 * k, vectors[k], row, PACK, lanes, back)
        copy3(saved, o + POSITION, state.positions, at.position + (j + 2) * ROW, W, lanes, back)
        copy1(saved, o + TENSION, state.tension, number, lanes, back)
        if needs.solids:
            copy3(saved, o + FORCE, state.force, row, PACK, lanes, back)
        if needs.segments:
            copy1(saved, o + SHARE, state.share, number, lanes, back)
        if needs.curled and twist:
            copy1(saved, o + TWIST, state.twist, number, lanes, back)


@inlined
def copy3(saved, o, rows, place, stride, lanes, back):
    """`copy1` of three coordinates."""
    for k in range(3):
        copy1(saved, o + k, rows, place + k * stride, lanes, back)


@inlined
def copy1(saved, o, rows, place, lanes, back):
    """Save a number of some lanes, or restore it in all."""
    if back:
        store(rows, place, load(saved, o))
    else:
        store(saved, o, where(lanes, load(rows, place), load(saved, o)))
