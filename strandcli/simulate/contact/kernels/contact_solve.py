"""Forces of contact with Coulomb's friction, contact by contact (Jean 1999: nonsmooth contact dynamics).

Of each contact the force λ on its second strand, and −λ on its first, keeps both apart (Signorini) and keeps them from
sliding, or opposes their sliding by µ times its normal part. Displacements are those of the whole step, so strands that
stick are where they were. One contact after the other, with what the rest do: nonlinear Gauss-Seidel. Where a contact
slides, friction opposes its slip exactly: with its response w and α >= 0, the slip over the friction,

    n·w λ = what is missing along the normal n,    (w λ)_t + α λ_t = what would stick across it,    |λ_t| = µ λ_n.
"""

from __future__ import annotations

import math

from ....jit import device, function, inlined
from ....simd.vectors import add_scaled, cross, dot, less, scaled, sum_of
from . import contact_pairs as columns

TINY = 1e-30
MOST_STEPS, EXACT = 60, 1e-10
"""Steps to the force of a contact that slides, at the most, and µ λ_n / |λ_t| − 1 with which it is found."""
LEAST = 1e-12
"""Least determinant of a response across the normal, as a share of the square of its trace."""
SOFT = 1e-7
"""Share of a contact's own response that is added to it, so that it can be inverted."""


@inlined
def three(row, i):
    """Three numbers of a row from place i on."""
    return row[i], row[i + 1], row[i + 2]


@inlined
def times(w, v):
    """The product of a matrix, three rows, and a vector."""
    return dot(w[0], v), dot(w[1], v), dot(w[2], v)


@device
def moved(moves, strand, end, share):
    """The displacement of a place on the segment that ends at particle ``end`` of those that move; roots do not."""
    displacement = scaled(share, three(moves[strand, end], 0))
    if end > 0:
        displacement = add_scaled(displacement, 1.0 - share, three(moves[strand, end - 1], 0))
    return displacement


@device
def moved_by(response, end, share, c, d):
    """The same by a unit of force along d."""
    x = share * response[end, c, d]
    if end > 0:
        x += (1.0 - share) * response[end - 1, c, d]
    return x


@function
def own_responses(pairs, numbers, responses, out):
    """Set ``out`` (m, 3, 3): how the vector between both places of a contact changes by its own force."""
    for i in range(len(pairs)):
        a, b = pairs[i, columns.FIRST_SEGMENT], pairs[i, columns.SECOND_SEGMENT]
        same = pairs[i, columns.FIRST] == pairs[i, columns.SECOND]
        alpha, beta = numbers[i, columns.ALPHA], numbers[i, columns.BETA]
        one, other = responses[i, 0], responses[i, 1]
        for c in range(columns.AXES):
            for d in range(columns.AXES):
                x = moved_by(one, a, alpha, c, d) + moved_by(other, b, beta, c, d)
                if same:
                    x -= moved_by(one, b, beta, c, d) + moved_by(other, a, alpha, c, d)
                out[i, c, d] = x


@device
def solution(w, v):
    """The solution of w x = v, by Cramer's rule."""
    a, b, c = cross(w[1], w[2]), cross(w[2], w[0]), cross(w[0], w[1])
    x = add_scaled(add_scaled(scaled(v[0], a), v[1], b), v[2], c)
    return scaled(1.0 / max(dot(w[0], a), TINY), x)


@device
def force_of(normal, start, free, wanted, friction, w):
    """The force of one contact with the response w, where ``free`` is the vector between its places without it, and
    ``start`` that when the step begins."""
    missing = wanted - dot(normal, free)
    if missing <= 0.0:
        return 0.0, 0.0, 0.0
    # where both stick: across the normal as at the begin
    force = solution(w, less(add_scaled(start, wanted - dot(normal, start), normal), free))
    push = dot(normal, force)
    across = add_scaled(force, -push, normal)
    if push >= 0.0 and math.sqrt(dot(across, across)) <= friction * push:
        return force
    return slide(normal, less(start, free), missing, friction, w)


@device
def slide(normal, slip, missing, friction, w):
    """The force of a contact that slides, where ``slip`` is what would stick, and ``missing`` what it lacks along the
    normal, metres.

    With λ_n eliminated, (S + α) λ_t = b, S being 2 × 2 and symmetric. µ λ_n / |λ_t| − 1 is below 0 where α is 0, as the
    force that would stick is out of the cone, is above from an α on that is known, and nearly straight between: the
    root is found by false position (the Illinois rule, Dowell & Jarratt 1971). Iterations for the direction of sliding
    need not end where a strand yields along itself far less than across."""
    one = (0.0, -normal[2], normal[1]) if abs(normal[0]) < 0.6 else (-normal[1], normal[0], 0.0)
    one = scaled(1.0 / max(math.sqrt(dot(one, one)), TINY), one)
    other = cross(normal, one)
    along, by_one, by_other = times(w, normal), times(w, one), times(w, other)
    own, turn, other_turn = dot(normal, along), dot(one, along), dot(other, along)
    a = dot(one, by_one) - turn * turn / own
    b = dot(one, by_other) - turn * other_turn / own
    d = dot(other, by_other) - other_turn * other_turn / own
    x, y = dot(one, slip) - turn * missing / own, dot(other, slip) - other_turn * missing / own
    of = missing, own, friction, (a, b, d), (x, y), (turn, other_turn)
    push, x, y = missing / own, 0.0, 0.0
    if friction > 0.0:
        push, x, y = force_at(of, root_of(of))
    return add_scaled(add_scaled(scaled(push, normal), x, one), y, other)


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
def solve(pairs, contacts, responses, settings, forces, moves):
    """Change ``forces`` (m, 3) and with them ``moves`` (S, N, 3), displacements against `END` of the contacts'
    ``vectors``, until no contact changes its displacement by more than the tolerance. ``contacts``: numbers and
    vectors; ``responses``: those of `contact_response.respond` and `own_responses`; ``settings``: friction, sweeps at
    the most, tolerance in metres, and response of contacts that are left out. Returns the sweeps."""
    _, sweeps, tolerance, _ = settings
    for sweep in range(sweeps):
        worst = 0.0
        for i in range(len(pairs)):
            worst = max(worst, solve_one(i, pairs, contacts, responses, settings, forces, moves))
        if worst < tolerance:
            return sweep + 1
    return sweeps


@function
def move(pairs, responses, forces, moves):
    """Add to ``moves`` (S, N, 3) what ``forces`` (m, 3) move particles by."""
    for i in range(len(pairs)):
        apply(pairs[i], responses[i], three(forces[i], 0), moves)


@device
def apply(pair, response, force, moves):
    """Add what a force moves the particles of a pair's strands by."""
    a, b = pair[columns.FIRST], pair[columns.SECOND]
    for j in range(moves.shape[1]):
        for c in range(columns.AXES):
            moves[a, j, c] -= dot(response[0, j, c], force)
            moves[b, j, c] += dot(response[1, j, c], force)


@device
def solve_one(i, pairs, contacts, responses, settings, forces, moves):
    """Solve for the force of one contact, with what the rest do; return the change of its displacement, metres."""
    pair, number, vector = pairs[i], contacts[0][i], contacts[1][i]
    response, own, friction, least = responses[0][i], responses[1][i], settings[0], settings[3]
    soft = own[0, 0] + own[1, 1] + own[2, 2]
    if soft <= least:
        return 0.0
    soft *= SOFT + number[columns.YIELDING] / columns.AXES
    x, y, z = three(own[0], 0), three(own[1], 0), three(own[2], 0)
    past = three(forces[i], 0)
    other = moved(moves, pair[columns.SECOND], pair[columns.SECOND_SEGMENT], number[columns.BETA])
    free = less(other, moved(moves, pair[columns.FIRST], pair[columns.FIRST_SEGMENT], number[columns.ALPHA]))
    free = less(sum_of(three(vector, columns.END), free), times((x, y, z), past))
    w = (x[0] + soft, x[1], x[2]), (y[0], y[1] + soft, y[2]), (z[0], z[1], z[2] + soft)
    force = force_of(
        three(vector, columns.NORMAL), three(vector, columns.START), free, number[columns.WANTED], friction, w
    )
    forces[i, 0], forces[i, 1], forces[i, 2] = force
    change = less(force, past)
    if change[0] != 0.0 or change[1] != 0.0 or change[2] != 0.0:
        apply(pair, response, change, moves)
    return max(abs(change[0]) * x[0], abs(change[1]) * y[1], abs(change[2]) * z[2])
