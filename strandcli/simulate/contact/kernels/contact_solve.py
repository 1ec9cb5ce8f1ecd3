"""Forces of contact with Coulomb's friction, contact by contact (Jean 1999: nonsmooth contact dynamics).

Of each contact the force λ on its second strand, and −λ on its first, keeps both apart (Signorini) and keeps them from
sliding, or opposes their sliding by µ times its normal part. Displacements are those of the whole step, so strands that
stick are where they were. One contact after the other, with what the rest do: nonlinear Gauss-Seidel. Where a contact
slides, friction opposes its way exactly: with its response w and α >= 0, the way over the friction,

    n·w λ = what is missing along the normal n,    (w λ)_t + α λ_t = what would stick across it,    |λ_t| = µ λ_n.
"""

from __future__ import annotations

import math

from ....jit import device, function
from .contact_pairs import (
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

TINY = 1e-30
MOST_STEPS, EXACT = 60, 1e-10
"""Steps to the force of a contact that slides, at the most, and µ λ_n / |λ_t| − 1 with which it is found."""
LEAST = 1e-12
"""Least determinant of a response across the normal, as a share of the square of its trace."""
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


@device
def slide(vector, missing, friction, w, rows):
    """Set ``rows[1]``, the force of a contact that slides, where ``rows[0]`` is the way between its places without it,
    ``missing`` what it lacks along the normal, metres, and ``w`` (3, 3) its response. ``rows[2:4]`` are scratch.

    With λ_n eliminated, (S + α) λ_t = b, S being 2 × 2 and symmetric. µ λ_n / |λ_t| − 1 is below 0 where α is 0, as the
    force that would stick is out of the cone, is above from an α on that is known, and nearly straight between: the
    root is found by false position (the Illinois rule, Dowell & Jarratt 1971). Iterations for the direction of sliding
    need not end where a strand gives way along itself far less than across."""
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
    of = missing, own, friction, (a, b, d), (x, y), (turn, other_turn)
    push, x, y = missing / own, 0.0, 0.0
    if friction > 0.0:
        push, x, y = force_at(of, root_of(of))
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
    missing, own, _, (a, b, d), (x, y), (turn, other_turn) = of
    a, d = a + more, d + more
    over = 1.0 / max(a * d - b * b, LEAST * (a + d) * (a + d), TINY)
    u, v = over * (d * x - b * y), over * (a * y - b * x)
    return (missing - turn * u - other_turn * v) / own, u, v


@device
def over_cone(of, more):
    """µ λ_n / |λ_t| − 1, with α = ``more``."""
    push, u, v = force_at(of, more)
    return of[2] * push / max(math.hypot(u, v), TINY) - 1.0


@device
def root_of(of):
    """α with which friction is µ times the pressure."""
    missing, own, friction, _, (x, y), (turn, other_turn) = of
    low, below = 0.0, over_cone(of, 0.0)
    if below >= 0.0:
        return 0.0
    # |λ_t| is at most |b| / α, which bounds what λ_n is less by it
    high = math.hypot(x, y) * (own / friction + math.hypot(turn, other_turn)) / max(missing, TINY)
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
