"""Steps that are too long for what solids do to a strand, made anew in parts by Euler's method.

In a step as long as a short strand's fall, or as the period of a stiff one, the strand that forces of contact are to be
found for is the one that would be without any: far inside the solid, and straight. From there rounds may find a shape
that is bent otherwise, at each step another, or none; from where the strand is, in a part of the step, they find the
nearest. So where rounds come to no end, lanes go back to where they began and take the step in parts. All of them are
made about the root as it is at the end of the step, and with solids as they are then: in the first, particles have been
carried by both, and their velocities are those relative to the root.
"""

from __future__ import annotations

from ...constants import W
from ...jit import device, inlined
from ...simd import broadcast, load, load3, store, store3, where
from . import rod_contact, rod_descent, rod_newton, rod_pinned, rod_start, rod_sweep
from .records import CHANGED, DRAG, LASTING, VELOCITY_STEP, Contact, Scheme
from .rod_scratch import ADDED_VELOCITY, AXES, IMPACT, MOVED_SHARE, PACK, ROOT_SHIFT
from .rod_sweep import ROW
from .rod_tension import KEPT, kept

PARTS = 8
"""Parts of a step."""
EDGES, PLACE, SPEED, PULL, BEFORE, AHEAD, WAY, PUSH = 0, 3, 6, 9, 10, 13, 16, 19
"""Vectors of `kept`."""
assert PUSH + 3 == KEPT


@inlined
def able(scheme, numbers):
    """Whether steps may be made in parts: of straight strands. The rule contact asks how strands answer in a whole
    step."""
    return not scheme.curled and numbers[LASTING] == 0.0


@device
def keep(s, at, state, scheme):
    """Keep what the strands begin the step with, and where tips are to be at its end."""
    for j in range(at.segments):
        o, row = kept(at.segments, j), at.edge + j * AXES
        copy3(s, o + EDGES, state.edges, row, PACK)
        copy3(s, o + PLACE, state.positions, at.position + (j + 2) * ROW, W)
        copy3(s, o + SPEED, state.velocity, row, PACK)
        store(s, o + PULL, load(state.tension, at.tension + j * PACK))
    x, y, z = rod_pinned.goal(s, at, state, scheme)
    store3(s, kept(at.segments, 0) + WAY, 1, x, y, z)


@inlined
def copy3(s, o, rows, place, stride):
    """Copy three coordinates to place o of the scratch."""
    x, y, z = load3(rows, place, stride)
    store3(s, o, 1, x, y, z)


@device
def make(s, at, next_pack, state, material, forcing, scheme, contact, iterations, lost):
    """Make the step anew in the lanes that are ``lost``, after `keep` and a sweep of the step as a whole."""
    pinned, goal = rod_pinned.pinned(material.mass, at.segments), load3(s, kept(at.segments, 0) + WAY, 1)
    begin_anew(s, at, state, lost)
    touching, residual = load(state.touching, at.strand), load(state.residuals, at.strand)
    part, rate = scheme.duration / PARTS, 1.0 / scheme.duration
    root = load3(s, ROOT_SHIFT, 1)
    root = rate * root[0], rate * root[1], rate * root[2]
    store3(s, ROOT_SHIFT, 1, 0.0, 0.0, 0.0)
    own = Scheme(scheme.share, True, True, scheme.crowded, part, scheme.curled)
    set_coefficients(s, at, material, forcing, own, root)
    add_velocity(state, at, root, -1.0)
    most = broadcast(s, 0.0)
    for count in range(PARTS):
        if pinned:
            rod_pinned.lead(s, at, state, goal, 1.0 / (PARTS - count))
        met = Contact(
            contact.solids, True, contact.segments, part, contact.friction, contact.rounding, count == 0
        )  # fmt: skip
        rod_start.fill_scratch(s, at, state, material, forcing, own)
        store(s, IMPACT, 0.0)
        worst = rod_newton.iterate(s, at, state, material, forcing, own, iterations, False)
        worst, _, _, _ = rod_contact.find(s, at, state, material, forcing, own, met, iterations, worst)
        worst = rod_descent.mend(s, at, state, material, forcing, own, iterations, worst)
        most = max(most, worst)
        rod_sweep.sweep(s, at, next_pack, state, material, forcing.numbers, own, met)
    add_velocity(state, at, root, 1.0)
    end(s, at, state, lost)
    store(state.touching, at.strand, where(lost, broadcast(s, CHANGED), touching))
    store(state.residuals, at.strand, where(lost, rod_contact.residual_of(most), residual))


@inlined
def set_coefficients(s, at, material, forcing, scheme, root):
    """Set the coefficients of a part, about a ``root`` of that velocity."""
    numbers, part = forcing.numbers, broadcast(s, scheme.duration)
    drag = 1.0 + numbers[DRAG] * part
    mass = 1.0 + numbers[DRAG] * numbers[VELOCITY_STEP]  # that `Material.mass` has been multiplied by
    store(s, MOVED_SHARE, 0.0)
    if scheme.crowded:
        rod_start.set_steps_of_crowd(s, part, 0.0, scheme)
    rod_start.store_coefficients(s, at, material, forcing, part, part, drag, part * part * (mass / drag))
    for c in range(3):
        store(s, ADDED_VELOCITY + c, load(s, ADDED_VELOCITY + c) - numbers[DRAG] * part * root[c])


@device
def add_velocity(state, at, velocity, factor):
    """Add ``factor`` times a velocity to those of all particles of the strands, and to those that BDF2 goes on with."""
    for j in range(at.segments):
        for c in range(3):
            p = at.edge + j * AXES + c * PACK
            store(state.velocity, p, load(state.velocity, p) + factor * velocity[c])


@device
def begin_anew(s, at, state, lost):
    """Have the ``lost`` lanes begin the step anew, without forces of contact, and keep what the others end it with."""
    for j in range(at.segments):
        o, row = kept(at.segments, j), at.edge + j * AXES
        exchange(s, o + EDGES, state.edges, row, PACK, 3, lost)
        exchange(s, o + PLACE, state.positions, at.position + (j + 2) * ROW, W, 3, lost)
        exchange(s, o + SPEED, state.velocity, row, PACK, 3, lost)
        exchange(s, o + PULL, state.tension, at.tension + j * PACK, 1, 1, lost)
        copy3(s, o + PUSH, state.push, row, PACK)
        for c in range(3):
            p = row + c * PACK
            store(state.push, p, where(lost, 0.0, load(state.push, p)))
        copy3(s, o + BEFORE, state.before, row, PACK)
        copy3(s, o + AHEAD, state.ahead, row, PACK)
        copy3(s, o + WAY, state.moved, row, PACK)


@device
def end(s, at, state, lost):
    """Have all lanes but the ``lost`` ones end the step as they have before."""
    for j in range(at.segments):
        o, row = kept(at.segments, j), at.edge + j * AXES
        exchange(s, o + EDGES, state.edges, row, PACK, 3, ~lost)
        exchange(s, o + PLACE, state.positions, at.position + (j + 2) * ROW, W, 3, ~lost)
        exchange(s, o + SPEED, state.velocity, row, PACK, 3, ~lost)
        exchange(s, o + PULL, state.tension, at.tension + j * PACK, 1, 1, ~lost)
        exchange(s, o + PUSH, state.push, row, PACK, 3, ~lost)
        exchange(s, o + BEFORE, state.before, row, PACK, 3, ~lost)
        exchange(s, o + AHEAD, state.ahead, row, PACK, 3, ~lost)
        exchange(s, o + WAY, state.moved, row, PACK, 3, ~lost)


@inlined
def exchange(s, o, rows, place, stride, count, lanes):
    """Exchange so many coordinates with those at place o of the scratch, in some lanes; in others, copy them there."""
    for c in range(count):
        now, past = load(rows, place + c * stride), load(s, o + c)
        store(rows, place + c * stride, where(lanes, past, now))
        store(s, o + c, now)
