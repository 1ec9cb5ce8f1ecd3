"""Which strands that solids press take the next step by Euler's method, told at the end of a step.

BDF2 goes on with what motion has been, forces of contact included. That is right where these last, as those of a strand
that swings from a pole that it hangs over, which by Euler's method would lose half of its swing a cycle. It is wrong
where they have just changed: the strand would spring off, or never come to rest.
"""

from __future__ import annotations

from ...jit import inlined
from ...simd import broadcast, load, load3, sqrt, store, where
from .records import STEADY
from .rod_scratch import (
    CONTACT_CHANGE,
    CONTACT_FORCE,
    DISPLACEMENT,
    FIRST_SEGMENT,
    IMPACT,
    INVERSE_LENGTH,
    ROOT_SHIFT,
    SEGMENT,
)

CHANGE = 0.25
"""Share of the forces of contact on a strand that they change by in a step, from which on the next one is Euler's."""
SLIGHT, SLIGHT_OF_CURLS = 0.03, 0.07
"""Share of the tip's way from the root in a step that such a change makes by itself, were it on all particles alike,
from which on it is, too: strands that hardly move come to rest."""
CALM = 0.2
"""What `State.touching` of curled strands falls by in a step without such a change, from 1: one that springs off a
solid goes by Euler's method for some more steps, or it would bounce for ever."""


@inlined
def begin(s):
    """Begin the sums of a strand's contacts in the last sweep of a step."""
    store(s, IMPACT, 0.0)
    store(s, CONTACT_FORCE, 0.0)
    store(s, CONTACT_CHANGE, 0.0)


@inlined
def keep(s, at, touching, duration, curled, among):
    """Set `State.touching` by how the forces of contact have changed in a step of ``duration`` seconds: 1 where that is
    much, else 0, of ``curled`` strands `CALM` less than before, but at least `STEADY` where there are forces. 1 at any
    force ``among`` strands that press each other: what their rounds find may leave a strand to solids at any time."""
    force, change = load(s, CONTACT_FORCE), load(s, CONTACT_CHANGE)
    after = broadcast(s, 0.0)
    if curled:
        after = max(load(touching, at.strand) - CALM, 0.0)
    after = where(force > 0.0, max(after, STEADY), after)
    inverse_length = load(s, INVERSE_LENGTH)
    x, y, z = load3(s, FIRST_SEGMENT + (at.segments - 1) * SEGMENT + DISPLACEMENT, 1)
    u, v, w = load3(s, ROOT_SHIFT, 1)
    x, y, z = x - inverse_length * u, y - inverse_length * v, z - inverse_length * w
    way = ((SLIGHT_OF_CURLS if curled else SLIGHT) * at.segments) * sqrt(x * x + y * y + z * z)
    by_itself = duration * duration * inverse_length * change
    much = ~((change <= CHANGE * force) & ((by_itself < way) | (force <= 0.0)))  # what is not finite is much
    if among:
        much = force > 0.0
    store(touching, at.strand, where(much, broadcast(s, 1.0), after))
