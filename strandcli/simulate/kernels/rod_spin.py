"""Strands that turn about their root by a radian or more in a step, as short ones with hinged roots may, and straight
ones of which an edge turns by more than a right angle.

BDF2 takes the chord of the turn for the way that a particle goes on, and extrapolates velocities that have turned: it
would keep such a strand turning for ever, against all drag, or throw it to and fro. There it starts anew, with what of
the motion is across the strand at the end of the step. An edge that whips round, as where a limp strand falls over, it
would have fly to and fro, and the strand gain up to .7 m g L: there it starts anew, too.
"""

from __future__ import annotations

from ...jit import device, inlined
from ...simd import any_lane, broadcast, load, load3, sqrt, store, store3, where
from . import rod_start
from .rod_scratch import (
    AXES,
    DEGENERATE,
    DISPLACEMENT,
    EDGE,
    FIRST_SEGMENT,
    IMPACT,
    INERTIAL,
    INVERSE_LENGTH,
    PACK,
    ROOT_SHIFT,
    SEGMENT,
    SPIN_AXIS,
)
from .rod_tension import TINY
from .vectors import add_scaled, dot, scaled, select, sum_of

WHIP = 0.0
"""Cosine of the angle that an edge turns by in a step, from which on BDF2 starts anew."""
BACK = -0.99
"""The same of edges that turn back: no motion of a strand that is resolved does that, but limp ones that stand exactly
upright have no other way to move."""
SPIN = 1.0
"""Chord, over a strand's length, of a turn in a step from which on BDF2 starts anew."""


@inlined
def find(s, at, state, scheme, free):
    """Return whether there are strands that have spun (`find_spins`), and any with edges that have turned back
    (`find_whips`)."""
    spun, back = False, False
    if not scheme.curled:  # what energy these have is kept from growing (`rod_energy`)
        back = find_whips(s, at, state.edges, free)
    if scheme.share > 0:
        spun = find_spins(s, at, state, scheme)
    return spun, back


@device
def find_spins(s, at, state, scheme):
    """Set `SPIN_AXIS`, and `IMPACT` too, in the lanes whose strands have spun; returns whether there are any."""
    n = at.segments
    tip = rod_start.predict(s, at.edge + (n - 1) * AXES, state, scheme)
    way = add_scaled(tip, -1.0, load3(s, FIRST_SEGMENT + (n - 1) * SEGMENT + INERTIAL, 1))
    way = add_scaled(way, -1.0, scaled(load(s, INVERSE_LENGTH), load3(s, ROOT_SHIFT, 1)))
    spun = dot(way, way) > (SPIN * n) ** 2
    if not any_lane(spun):
        return False
    axis = load3(s, FIRST_SEGMENT + EDGE, 1)
    for j in range(1, n):
        axis = sum_of(axis, load3(s, FIRST_SEGMENT + j * SEGMENT + EDGE, 1))
    f = where(spun, 1.0 / sqrt(max(dot(axis, axis), TINY)), 0.0)
    store3(s, SPIN_AXIS, 1, f * axis[0], f * axis[1], f * axis[2])
    store(s, IMPACT, where(spun, broadcast(f, 1.0), load(s, IMPACT)))
    return True


@device
def find_whips(s, at, edges, free):
    """Set `IMPACT` in the lanes where an edge has whipped round. Where nothing drives strands, which are ``free`` then,
    have edges that have turned back stay as they were before the step, and set `DEGENERATE` in their lanes; returns
    whether there are any."""
    cosine, one = least_cosine(s, at, edges), broadcast(s, 1.0)
    store(s, IMPACT, where(cosine < WHIP, one, load(s, IMPACT)))
    back = cosine < BACK
    if not (free and any_lane(back)):
        return False
    store(s, DEGENERATE, where(back, one, 0.0))
    for j in range(at.segments):
        o = FIRST_SEGMENT + j * SEGMENT + EDGE
        e, before = load3(s, o, 1), load3(edges, at.edge + j * AXES, PACK)
        x, y, z = select(dot(e, before) < BACK, before, e)
        store3(s, o, 1, x, y, z)
    return True


@inlined
def least_cosine(s, at, edges):
    """Cosine of the angle that the edge which turns farthest turns by in the step."""
    found = broadcast(s, 1.0)
    for j in range(at.segments):
        found = min(found, dot(load3(s, FIRST_SEGMENT + j * SEGMENT + EDGE, 1), load3(edges, at.edge + j * AXES, PACK)))
    return found


@inlined
def turn(s, o):
    """Leave of the displacement of the particle at place o what is across `SPIN_AXIS`."""
    u, axis = load3(s, o + DISPLACEMENT, 1), load3(s, SPIN_AXIS, 1)
    u = add_scaled(u, -dot(u, axis), axis)
    store3(s, o + DISPLACEMENT, 1, u[0], u[1], u[2])
