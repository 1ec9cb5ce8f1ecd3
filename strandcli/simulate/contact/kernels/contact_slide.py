"""Coulomb's friction of a contact that slides, exactly.

With the response w of the way between both places to the force λ, and α >= 0 the way that they slide over the friction
that opposes it,

    n·w λ = what is missing along the normal n,    (w λ)_t + α λ_t = what would stick across it,    |λ_t| = µ λ_n.

Without λ_n, (S + α) λ_t = b, where S is w across the normal less what it does by way of the normal: 2 × 2, symmetric,
and brought to its axes once. µ λ_n / |λ_t| − 1 is not above 0 where α is 0, as the force that would stick is out of the
cone, is so from an α on that is known, and nearly straight between: the root is found by false position (the Illinois
rule, Dowell & Jarratt 1971). Iterations for the direction of sliding need not come to an end where a strand gives way
along itself far less than across: they would have ways of millimetres in which friction does not oppose the way.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from ....jit import device
from .contact_columns import AXES, NORMAL, START

TINY = 1e-30
MOST_STEPS, EXACT = 60, 1e-10
"""Steps to the root at the most, and µ λ_n / |λ_t| − 1 with which it is found."""
LEAST = 1e-12
"""Least response along an axis of S, as a share of the other's."""


class Sliding(NamedTuple):
    """A contact across its normal, in the axes of S."""

    missing: Any
    """Along the normal, metres."""
    own: Any
    """Response along the normal."""
    friction: Any
    soft: Any
    """Greater response of S."""
    firm: Any
    """Smaller one."""
    far: Any
    """What would stick along the axis of the greater one, metres."""
    near: Any
    """Along the other."""
    far_turn: Any
    """Response along the normal to a force along the axis of the greater one."""
    near_turn: Any


@device
def slide(vector, missing, friction, w, rows):
    """Set ``rows[1]``, the force of a contact that slides, where ``rows[0]`` is the way between its places without it,
    ``missing`` what it lacks along the normal, metres, and ``w`` (3, 3) its response. ``rows[2:4]`` are scratch."""
    free, force, one, other = rows[0], rows[1], rows[2], rows[3]
    set_across(vector, one, other)
    own = product(w, vector, NORMAL, vector, NORMAL)
    turn, other_turn = product(w, one, 0, vector, NORMAL), product(w, other, 0, vector, NORMAL)
    a = product(w, one, 0, one, 0) - turn * turn / own
    b = product(w, one, 0, other, 0) - turn * other_turn / own
    d = product(w, other, 0, other, 0) - other_turn * other_turn / own
    x, y = -turn * missing / own, -other_turn * missing / own
    for c in range(AXES):
        way = vector[START + c] - free[c]
        x += one[c] * way
        y += other[c] * way
    # to the axes of S: the angle by which the first of both turns to that of the greater response
    angle = 0.5 * math.atan2(2.0 * b, a - d)
    cosine, sine = math.cos(angle), math.sin(angle)
    half, spread = 0.5 * (a + d), math.hypot(0.5 * (a - d), b)
    soft = max(half + spread, TINY)
    of = Sliding(
        missing, own, friction, soft, max(half - spread, LEAST * soft), cosine * x + sine * y, cosine * y - sine * x,
        cosine * turn + sine * other_turn, cosine * other_turn - sine * turn,
    )  # fmt: skip
    more = root_of(of)
    push, far, near = force_at(of, more)
    x, y = cosine * far - sine * near, sine * far + cosine * near
    for c in range(AXES):
        force[c] = push * vector[NORMAL + c] + x * one[c] + y * other[c]


@device
def set_across(vector, one, other):
    """Set two unit vectors across the normal and each other."""
    x, y, z = vector[NORMAL], vector[NORMAL + 1], vector[NORMAL + 2]
    if abs(x) < 0.6:
        one[0], one[1], one[2] = 0.0, -z, y
    else:
        one[0], one[1], one[2] = -y, x, 0.0
    size = max(math.sqrt(one[0] ** 2 + one[1] ** 2 + one[2] ** 2), TINY)
    for c in range(AXES):
        one[c] /= size
    other[0] = y * one[2] - z * one[1]
    other[1] = z * one[0] - x * one[2]
    other[2] = x * one[1] - y * one[0]


@device
def product(w, a, i, b, j):
    """a·w b, of vectors at places of two rows."""
    total = 0.0
    for c in range(AXES):
        for d in range(AXES):
            total += a[i + c] * w[c, d] * b[j + d]
    return total


@device
def force_at(of, more):
    """The force along the normal and both axes across it, with α = ``more``."""
    far, near = of.far / (of.soft + more), of.near / (of.firm + more)
    push = (of.missing - of.far_turn * far - of.near_turn * near) / of.own
    return push, far, near


@device
def over_cone(of, more):
    """µ λ_n / |λ_t| − 1, with α = ``more``."""
    push, far, near = force_at(of, more)
    return of.friction * push / max(math.hypot(far, near), TINY) - 1.0


@device
def root_of(of):
    """α with which friction is µ times the pressure; infinite without friction."""
    if of.friction <= 0.0:
        return math.inf
    low, below = 0.0, over_cone(of, 0.0)
    if below >= 0.0:
        return 0.0
    # |λ_t| is at most |b| / α, which bounds what λ_n is less by it
    turned = math.hypot(of.far_turn, of.near_turn)
    high = math.hypot(of.far, of.near) * (of.own / of.friction + turned) / max(of.missing, TINY)
    above, side, at = over_cone(of, high), 0, high
    for _ in range(MOST_STEPS):
        at = (low * above - high * below) / max(above - below, TINY)
        found = over_cone(of, at)
        if abs(found) < EXACT:
            break
        if found > 0.0:
            high, above = at, found
            if side > 0:
                below *= 0.5
            side = 1
        else:
            low, below = at, found
            if side < 0:
                above *= 0.5
            side = -1
    return at
