"""How two segments come near each other in a step: conservative advancement (Mirtich 1996; Tang et al. 2009).

Both segments move along straight lines from where a step began to where it would end. Time goes on by the distance over
the greatest relative speed of their ends, which can step over no contact, until they are closer than a share of what
they should keep: there the normal still tells on which side each of them is, however far both go on. A segment is a
pair of its ends, of three coordinates each.
"""

from __future__ import annotations

import math

from ....jit import device, function, inlined
from ....simd.vectors import add_scaled, cross, dot, less, scaled
from . import contact_pairs as columns

NEAR = 0.9
"""Share of the distance at the begin, or of the thickness where that is less, at which a contact is looked at."""
CLOSE = 1.02
"""Times that share at which advancing ends."""
TOGETHER = 1e-6
"""Share of the thickness up to which segments have no direction between them."""
ADVANCES = 64
"""Times that are looked at before the rest of the step is cut into pieces."""
PIECES, BISECTIONS = 24, 40
"""Pieces of a step in which segments may pass through each other, and bisections of such a one."""
BOUND = 4.0
"""Segments from the second on over which strands that begin too close come to be led apart: roots hold them there."""
SLOPE = 0.1
"""By how much the distance that strands keep grows along them, from that of their roots to their thickness."""
DEEP = 0.25
"""Share of the thickness from which on strands begin too close to stay on their sides in all of a step."""
TOUCH = 1e-3
"""Share of the least distance within which segments whose ends lie in a plane pass through each other."""
OBLIQUE = 0.05
"""Sine of the angle beyond a joint at which the segment before it comes nearer."""
TINY = 1e-30
PARALLEL = 1e-9
"""Square of the sine between segments below which they count as parallel."""


@inlined
def clamped(x):
    """A number in [0, 1]."""
    return min(max(x, 0.0), 1.0)


@inlined
def particle(x, strand, j):
    """Particle j of a strand of ``x`` (S, N + 1, 3)."""
    return x[strand, j, 0], x[strand, j, 1], x[strand, j, 2]


@inlined
def between(a, b, t):
    """The point at a share t from a to b."""
    return add_scaled(a, t, less(b, a))


@device
def segment_at(start, end, strand, j, t):
    """Segment j of a strand at a share t of the step."""
    return (
        between(particle(start, strand, j), particle(end, strand, j), t),
        between(particle(start, strand, j + 1), particle(end, strand, j + 1), t),
    )


@device
def nearest_at(start, end, pair, t):
    """Of a pair at a share t of the step the distance, the places on both segments that are nearest to each other, and
    the vector from the first to the second (Ericson 2005, §5.1.9). Of parallel segments the places are in the middle of
    what lies side by side."""
    p = segment_at(start, end, pair[columns.FIRST], pair[columns.FIRST_SEGMENT], t)
    q = segment_at(start, end, pair[columns.SECOND], pair[columns.SECOND_SEGMENT], t)
    u, v, w = less(p[1], p[0]), less(q[1], q[0]), less(p[0], q[0])
    a, b, c, d, e = max(dot(u, u), TINY), dot(u, v), max(dot(v, v), TINY), dot(u, w), dot(v, w)
    sine = a * c - b * b
    if sine > PARALLEL * a * c:
        alpha = clamped((b * e - c * d) / sine)
    else:
        alpha = 0.5 * (clamped(-d / a) + clamped((b - d) / a))
    beta = clamped((b * alpha + e) / c)
    alpha = clamped((b * beta - d) / a)
    offset = less(add_scaled(q[0], beta, v), add_scaled(p[0], alpha, u))
    return math.sqrt(dot(offset, offset)), alpha, beta, offset


@device
def nearer_before(start, end, strand, j, t, toward):
    """Whether the segment before segment j comes nearer to what is ``toward`` a direction than its end."""
    a, b = segment_at(start, end, strand, j - 1, t)
    back = less(a, b)
    return dot(toward, back) > OBLIQUE * math.sqrt(dot(back, back))


@device
def counts(start, end, pair, places, normal, t):
    """Whether the contact of a pair is a nearest place of both strands: at a joint it counts for the segment after it
    alone, and nowhere if the one before it comes nearer."""
    (alpha, beta), a, b, last = places, pair[columns.FIRST_SEGMENT], pair[columns.SECOND_SEGMENT], start.shape[1] - 2
    if (alpha == 1.0 and a < last) or (beta == 1.0 and b < last):
        return False
    if alpha == 0.0 and a > 0 and nearer_before(start, end, pair[columns.FIRST], a, t, normal):
        return False
    return not (beta == 0.0 and b > 0 and nearer_before(start, end, pair[columns.SECOND], b, t, scaled(-1.0, normal)))


@device
def greatest_speed(start, end, pair):
    """The greatest relative displacement of the ends of a pair's segments."""
    worst = 0.0
    for i in range(2):
        a = pair[columns.FIRST_SEGMENT] + i
        one = less(particle(end, pair[columns.FIRST], a), particle(start, pair[columns.FIRST], a))
        for j in range(2):
            b = pair[columns.SECOND_SEGMENT] + j
            relative = less(less(particle(end, pair[columns.SECOND], b), particle(start, pair[columns.SECOND], b)), one)
            worst = max(worst, dot(relative, relative))
    return math.sqrt(worst)


@device
def aside(pair, p):
    """A unit vector across the segment p for a pair that lies in one line: it differs from pair to pair, and is the
    same at each step."""
    turn = 2.399963 * (7.0 * pair[columns.FIRST] + 13.0 * pair[columns.SECOND])
    normal = cross(less(p[1], p[0]), (math.cos(turn), math.sin(turn), math.cos(0.7 * turn)))
    return scaled(1.0 / max(math.sqrt(dot(normal, normal)), TINY), normal)


@device
def least_distance(start, pair, lengths, thickness):
    """The distance that segments should keep: that of their roots, which hold them there, and more the further from
    these, up to the thickness."""
    if pair[columns.FIRST] == pair[columns.SECOND]:
        return thickness
    roots = less(particle(start, pair[columns.FIRST], 0), particle(start, pair[columns.SECOND], 0))
    one = lengths[pair[columns.FIRST]] * pair[columns.FIRST_SEGMENT]
    other = lengths[pair[columns.SECOND]] * pair[columns.SECOND_SEGMENT]
    return min(thickness, math.sqrt(dot(roots, roots)) + SLOPE * min(one, other))


@device
def across_both(start, end, pair, t):
    """The vector product of a pair's segments at a share t of the step, and its product with the vector between their
    beginnings, which changes its sign where the ends lie in a plane (Provot 1997)."""
    p = segment_at(start, end, pair[columns.FIRST], pair[columns.FIRST_SEGMENT], t)
    q = segment_at(start, end, pair[columns.SECOND], pair[columns.SECOND_SEGMENT], t)
    across = cross(less(p[1], p[0]), less(q[1], q[0]))
    return across, dot(across, less(q[0], p[0]))


@device
def rest_of_step(start, end, pair, t, least):
    """Whether a pair passes through each other from a share t of the step on, at which one that does first, else 1,
    and what `nearest_at` finds there; ``least`` counts as the distance where it does, along what is across both, to the
    side where it was before."""
    low, before = t, across_both(start, end, pair, t)[1]
    for piece in range(1, PIECES + 1):
        high = t + piece / PIECES * (1.0 - t)
        after = across_both(start, end, pair, high)[1]
        if (before > 0.0) != (after > 0.0):
            at, above = low, high
            for _ in range(BISECTIONS):
                middle = 0.5 * (at + above)
                if (across_both(start, end, pair, middle)[1] > 0.0) == (before > 0.0):
                    at = middle
                else:
                    above = middle
            distance, alpha, beta, offset = nearest_at(start, end, pair, at)
            if distance < TOUCH * least:
                across, _ = across_both(start, end, pair, at)
                size = math.sqrt(dot(across, across))
                if size <= TINY:
                    return True, at, (0.0, alpha, beta, offset)
                return True, at, (least, alpha, beta, scaled(math.copysign(least, before) / size, across))
        low, before = high, after
    return False, 1.0, nearest_at(start, end, pair, 1.0)


@function
def look(start, end, lengths, pairs, sizes, numbers, vectors):
    """Set the contacts of ``pairs``: their ``numbers`` and ``vectors`` as in `contact_pairs`. ``start`` and ``end``
    (S, N + 1, 3): particles when the step begins, and where it would end. ``sizes``: the distance that strands keep,
    how much of it they come apart in a step at the most, where they begin closer, and the distance at the end from
    which on a contact does not count. ``lengths`` (S,): of a segment."""
    for i in range(len(pairs)):
        look_at(start, end, lengths, pairs[i], sizes, numbers[i], vectors[i])


@device
def look_at(start, end, lengths, pair, sizes, number, vector):
    """Set a contact of a pair."""
    thickness, ease, far = sizes
    found = nearest_at(start, end, pair, 0.0)
    begin, first = found[0], scaled(1.0 / max(found[0], TINY), found[3])
    number[columns.BEGIN] = begin
    speed = greatest_speed(start, end, pair)
    if begin - speed > far:
        number[columns.COUNTS] = 0.0
        return
    free = min(1.0, max(0.0, min(pair[columns.FIRST_SEGMENT], pair[columns.SECOND_SEGMENT]) - 1.0) / BOUND)
    number[columns.KEPT] = retained = least_distance(start, pair, lengths, thickness)
    number[columns.WANTED] = min(retained, begin + free * ease * thickness)
    least = NEAR * min(begin, thickness)
    t = 0.0
    for _ in range(ADVANCES):
        if t >= 1.0 or found[0] <= CLOSE * least:
            break
        t = min(1.0, t + (found[0] - least) / max(speed, TINY))
        found = nearest_at(start, end, pair, t)
    decided = t >= 1.0 or found[0] <= CLOSE * least
    normal = touch(start, end, pair, t, found, thickness, number, vector)
    # what does not keep a pair apart, at a joint or to the side of where it goes, may let it through later
    if (
        t < 1.0
        and begin > DEEP * thickness
        and not (decided and number[columns.COUNTS] > 0.0 and number[columns.GAP] < number[columns.WANTED])
    ):
        passes, t, last = rest_of_step(start, end, pair, t, CLOSE * least)
        if passes or not decided:
            found = last
            normal = touch(start, end, pair, t, found, thickness, number, vector)
    number[columns.SAME] = dot(first, normal) if found[0] > TOGETHER * thickness else 0.0


@device
def touch(start, end, pair, t, found, thickness, number, vector):
    """Set the contact of a pair to what `nearest_at` has ``found`` at a share t of the step; return the normal."""
    distance, alpha, beta, offset = found
    number[columns.ALPHA], number[columns.BETA] = alpha, beta
    if distance > TOGETHER * thickness:
        normal = scaled(1.0 / distance, offset)
    else:
        normal = aside(pair, segment_at(start, end, pair[columns.FIRST], pair[columns.FIRST_SEGMENT], t))
    vector[columns.NORMAL], vector[columns.NORMAL + 1], vector[columns.NORMAL + 2] = normal
    a, b = pair[columns.FIRST_SEGMENT], pair[columns.SECOND_SEGMENT]
    for place, x in ((columns.START, start), (columns.END, end)):
        first = between(particle(x, pair[columns.FIRST], a), particle(x, pair[columns.FIRST], a + 1), alpha)
        second = between(particle(x, pair[columns.SECOND], b), particle(x, pair[columns.SECOND], b + 1), beta)
        offset = less(second, first)
        vector[place], vector[place + 1], vector[place + 2] = offset
    number[columns.GAP] = dot(normal, offset)
    number[columns.COUNTS] = 1.0 if counts(start, end, pair, (alpha, beta), normal, t) else 0.0
    return normal
