"""Which forces solids may give: the cones of Coulomb's law, of one solid and of two."""

from __future__ import annotations

from typing import Any, NamedTuple

from ...jit import inlined
from ...simd import broadcast, sqrt, where
from .contact_circle import TINY
from .vectors import add_scaled, dot, scaled, select

ALIKE = 0.97
"""Squared cosine between the normals of two solids above which only one of them counts: 10 degrees between faces."""


class Given(NamedTuple):
    """What solids give a particle in an update."""

    force: Any
    """The displacement by it, metres."""
    normal: Any
    """Of the one solid that presses, or the first of both."""
    wanted: Any
    """By how much what presses should move the particle, metres."""
    groove: Any
    """Unit vector along the line where two solids meet that both press; zero elsewhere."""
    both: Any
    """Whether both press."""


@inlined
def in_cone(held, n, wanted, friction):
    """The displacement by a force, ``held`` and what is ``wanted`` besides, that pulls at nothing and keeps to
    Coulomb's law; n: normal, or zero where there is no contact, and then no force."""
    along, more = max(dot(held, n), 0.0), dot(wanted, n)
    pressed = max(along + more, 0.0)
    x = add_scaled(add_scaled(held, 1.0, wanted), -(dot(held, n) + more), n)
    f = min(sqrt(friction * friction * pressed * pressed / max(dot(x, x), TINY)), 1.0)
    f = where(dot(n, n) > 0.5, f, 0.0)
    return add_scaled(scaled(f, x), pressed, n)


@inlined
def by_one(held, n, wanted, friction):
    """What one solid gives."""
    zero = broadcast(n[0], 0.0)
    return Given(in_cone(held, n, wanted, friction), n, wanted, (zero, zero, zero), zero < zero)


@inlined
def by_two(held, one, wanted, other, wanted_there, friction):
    """What two solids give, with the normals ``one`` and ``other``, which is zero where there is one alone: as
    `in_cone` of the first, if that leads out of the second, or of the second if that leads out of the first. Else both
    press until the particle is where their surfaces meet, and friction acts along the groove."""
    zero = broadcast(one[0], 0.0)
    none, there = (zero, zero, zero), dot(other, other) > 0.5
    # of what is held, one solid may have all and more, and the other less than nothing
    free, free_there = add_scaled(held, 1.0, wanted), add_scaled(held, 1.0, wanted_there)
    first = select(there, in_cone(none, one, free, friction), in_cone(held, one, wanted, friction))
    last = in_cone(none, other, free_there, friction)
    depth, depth_there = dot(free, one), dot(free_there, other)
    second = there & (depth_there > dot(first, other))
    both = second & (depth > dot(last, one))
    cosine = dot(one, other)
    rate = 1.0 / max(1.0 - cosine * cosine, 1.0 - ALIKE)
    a, b = rate * (depth - cosine * depth_there), rate * (depth_there - cosine * depth)
    a, b = where(b > 0.0, max(a, 0.0), depth), where(a > 0.0, max(b, 0.0), depth_there)
    size = sqrt(rate)
    groove = (
        size * (one[1] * other[2] - one[2] * other[1]), size * (one[2] * other[0] - one[0] * other[2]),
        size * (one[0] * other[1] - one[1] * other[0]),
    )  # fmt: skip
    most = friction * (a + b)
    along = min(max(dot(free, groove), -most), most)
    pressed = add_scaled(add_scaled(scaled(a, one), b, other), along, groove)
    a, b = dot(wanted, one), dot(wanted_there, other)
    toward = add_scaled(scaled(rate * (a - cosine * b), one), rate * (b - cosine * a), other)
    toward = add_scaled(toward, dot(wanted, groove), groove)
    return Given(
        select(both, pressed, select(second, last, first)), select(second & ~both, other, one),
        select(both, toward, select(second, wanted_there, wanted)), select(both, groove, none), both,
    )  # fmt: skip


@inlined
def pressing_of(given, change):
    """The part of a change of the force that is pressure."""
    one = scaled(dot(change, given.normal), given.normal)
    return select(given.both, add_scaled(change, -dot(change, given.groove), given.groove), one)
