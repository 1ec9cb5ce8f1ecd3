"""Forces of contact with Coulomb's friction, contact by contact (Jean 1999: nonsmooth contact dynamics).

Of each contact the force λ on its second strand, and −λ on its first, keeps both apart (Signorini) and keeps them from
sliding, or opposes their sliding by µ times its normal part. Ways are those of the whole step, so strands that stick
are where they were. One contact after the other, with what the others do: nonlinear Gauss-Seidel.
"""

from __future__ import annotations

import math

from ....jit import device, function
from .contact_columns import (
    ALPHA,
    AXES,
    BETA,
    END,
    FIRST,
    FIRST_SEGMENT,
    NORMAL,
    SECOND,
    SECOND_SEGMENT,
    START,
    WANTED,
    YIELDING,
)
from .contact_slide import slide

TINY = 1e-30
SOFT = 1e-7
"""Share of a contact's own response that is added to it, so that it can be inverted."""


@device
def moved(moves, strand, end, share, c):
    """Coordinate c of the displacement of a place on the segment that ends at particle ``end`` of those that move;
    roots do not."""
    x = share * moves[strand, end, c]
    if end > 0:
        x += (1.0 - share) * moves[strand, end - 1, c]
    return x


@device
def moved_by(response, end, share, c, d):
    """The same by a unit of force along d."""
    x = share * response[end, c, d]
    if end > 0:
        x += (1.0 - share) * response[end - 1, c, d]
    return x


@function
def own_responses(pairs, numbers, responses, out):
    """Set ``out`` (m, 3, 3): how the way between both places of a contact changes by its own force."""
    for i in range(len(pairs)):
        a, b = pairs[i, FIRST_SEGMENT], pairs[i, SECOND_SEGMENT]
        same = pairs[i, FIRST] == pairs[i, SECOND]
        alpha, beta = numbers[i, ALPHA], numbers[i, BETA]
        one, other = responses[i, 0], responses[i, 1]
        for c in range(AXES):
            for d in range(AXES):
                x = moved_by(one, a, alpha, c, d) + moved_by(other, b, beta, c, d)
                if same:
                    x -= moved_by(one, b, beta, c, d) + moved_by(other, a, alpha, c, d)
                out[i, c, d] = x


@device
def invert_times(w, v, out):
    """Set ``out`` to the solution of w x = v, (3, 3), by Cramer's rule."""
    a = w[1, 1] * w[2, 2] - w[1, 2] * w[2, 1]
    b = w[1, 2] * w[2, 0] - w[1, 0] * w[2, 2]
    c = w[1, 0] * w[2, 1] - w[1, 1] * w[2, 0]
    f = 1.0 / max(w[0, 0] * a + w[0, 1] * b + w[0, 2] * c, TINY)
    out[0] = f * (
        a * v[0] + (w[0, 2] * w[2, 1] - w[0, 1] * w[2, 2]) * v[1] + (w[0, 1] * w[1, 2] - w[0, 2] * w[1, 1]) * v[2]
    )
    out[1] = f * (
        b * v[0] + (w[0, 0] * w[2, 2] - w[0, 2] * w[2, 0]) * v[1] + (w[0, 2] * w[1, 0] - w[0, 0] * w[1, 2]) * v[2]
    )
    out[2] = f * (
        c * v[0] + (w[0, 1] * w[2, 0] - w[0, 0] * w[2, 1]) * v[1] + (w[0, 0] * w[1, 1] - w[0, 1] * w[1, 0]) * v[2]
    )


@device
def dot(a, i, b, j):
    """Scalar product of vectors at places of two rows."""
    return a[i] * b[j] + a[i + 1] * b[j + 1] + a[i + 2] * b[j + 2]


@device
def force_of(vector, wanted, friction, w, rows):
    """Set ``rows[1]``, the force of one contact, where ``rows[0]`` is the way between its places without it.
    ``rows[2:4]`` are scratch."""
    free, force, way = rows[0], rows[1], rows[2]
    missing = wanted - dot(vector, NORMAL, free, 0)
    start = dot(vector, NORMAL, vector, START)
    if missing <= 0.0:
        force[...] = 0.0
        return
    for c in range(AXES):  # where both stick: across the normal as at the begin
        way[c] = vector[START + c] + (wanted - start) * vector[NORMAL + c] - free[c]
    invert_times(w, way, force)
    push = dot(vector, NORMAL, force, 0)
    size = 0.0
    for c in range(AXES):
        size += (force[c] - push * vector[NORMAL + c]) ** 2
    if push >= 0.0 and math.sqrt(size) <= friction * push:
        return
    slide(vector, missing, friction, w, rows)


@function
def solve(pairs, contacts, responses, settings, forces, moves, rows):
    """Change ``forces`` (m, 3) and with them ``moves`` (S, N, 3), displacements against `END` of the contacts'
    ``vectors``, until no contact changes its way by more than the tolerance. ``contacts``: numbers and vectors;
    ``responses``: those of `contact_response.respond` and `own_responses`; ``settings``: friction, sweeps at the most,
    tolerance in metres, and response of contacts that are left out; ``rows`` (7, 3) is scratch. Returns the sweeps."""
    _, sweeps, tolerance, _ = settings
    for sweep in range(sweeps):
        worst = 0.0
        for i in range(len(pairs)):
            worst = max(worst, solve_one(i, pairs, contacts, responses, settings, forces, moves, rows))
        if worst < tolerance:
            return sweep + 1
    return sweeps


@function
def move(pairs, responses, forces, moves):
    """Add to ``moves`` (S, N, 3) what ``forces`` (m, 3) move particles by."""
    for i in range(len(pairs)):
        apply(pairs[i], responses[i], forces[i, 0], forces[i, 1], forces[i, 2], moves)


@device
def apply(pair, response, x, y, z, moves):
    """Add what a force moves the particles of a pair's strands by."""
    a, b = pair[FIRST], pair[SECOND]
    for j in range(moves.shape[1]):
        for c in range(AXES):
            one, other = response[0, j, c], response[1, j, c]
            moves[a, j, c] -= one[0] * x + one[1] * y + one[2] * z
            moves[b, j, c] += other[0] * x + other[1] * y + other[2] * z


@device
def solve_one(i, pairs, contacts, responses, settings, forces, moves, rows):
    """Solve for the force of one contact, with what the others do; return by how much its way changes, metres."""
    numbers, vectors = contacts
    response, own = responses
    a, b = pairs[i, FIRST], pairs[i, SECOND]
    soft = own[i, 0, 0] + own[i, 1, 1] + own[i, 2, 2]
    if soft <= settings[3]:
        return 0.0
    w = rows[4:7]
    soft *= SOFT + numbers[i, YIELDING] / AXES
    for c in range(AXES):
        x = vectors[i, END + c] + moved(moves, b, pairs[i, SECOND_SEGMENT], numbers[i, BETA], c)
        x -= moved(moves, a, pairs[i, FIRST_SEGMENT], numbers[i, ALPHA], c)
        rows[0, c] = x - own[i, c, 0] * forces[i, 0] - own[i, c, 1] * forces[i, 1] - own[i, c, 2] * forces[i, 2]
        for d in range(AXES):
            w[c, d] = own[i, c, d]
        w[c, c] += soft
    force_of(vectors[i], numbers[i, WANTED], settings[0], w, rows)
    worst, some = 0.0, False
    for d in range(AXES):
        change = rows[1, d] - forces[i, d]
        forces[i, d] = rows[1, d]
        rows[1, d] = change
        worst = max(worst, abs(change) * own[i, d, d])
        some = some or change != 0.0
    if some:
        apply(pairs[i], response[i], rows[1, 0], rows[1, 1], rows[1, 2], moves)
    return worst
