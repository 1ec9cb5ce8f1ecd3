"""How two segments come near each other in a step: conservative advancement (Mirtich 1996; Tang et al. 2009).

Both segments move along straight lines from where a step began to where it would end. Time goes on by the distance over
the greatest relative speed of their ends, which can step over no contact, until they are closer than a share of what
they should keep: there the normal still tells on which side each of them is, however far both go on.
"""

from __future__ import annotations

import math

from ....jit import device, function
from .contact_pairs import (
    ALPHA,
    AXES,
    BEGIN,
    BETA,
    COUNTS,
    END,
    FIRST,
    FIRST_SEGMENT,
    GAP,
    KEPT,
    NORMAL,
    SAME,
    SECOND,
    SECOND_SEGMENT,
    START,
    WANTED,
)

NEAR = 0.9
"""Share of the distance at the begin, or of the thickness where that is less, at which a contact is looked at."""
CLOSE = 1.02
"""Times that share at which advancing ends."""
ADVANCES = 64
"""Times that are looked at before the rest of the step is cut into pieces."""
PIECES, BISECTIONS = 8, 40
"""Pieces of a step in which segments may pass through each other, and bisections of such a one."""
BOUND = 4.0
"""Segments from the second on over which strands that begin too close come to be led apart: roots hold them there."""
SLOPE = 0.1
"""By how much the distance that strands keep grows along them, from that of their roots to their thickness."""
DEEP = 0.25
"""Share of the thickness from which on strands are too close when a step begins to be kept on their sides in all of it:
of a crowd that begins inside each other not all can be, and those that are would be thrown."""
TOUCH = 1e-3
"""Share of the least distance within which segments whose ends lie in a plane pass through each other."""
OBLIQUE = 0.05
"""Sine of the angle beyond a joint at which the segment before it comes nearer."""
TINY = 1e-30
PARALLEL = 1e-9
"""Square of the sine between segments below which they count as parallel."""


@device
def clamped(x):
    """A number in [0, 1]."""
    return min(max(x, 0.0), 1.0)


@device
def nearest(p, q, out):
    """Set places on the segments p and q (2, 3) that are nearest to each other, ``ALPHA`` and ``BETA`` of ``out``, and
    ``out[2:5]``, the way from the first to the second; return its length (Ericson 2005, §5.1.9). Of parallel segments
    the places are in the middle of what lies side by side."""
    a = b = c = d = e = 0.0
    for k in range(AXES):
        u, v, w = p[1, k] - p[0, k], q[1, k] - q[0, k], p[0, k] - q[0, k]
        a, b, c, d, e = a + u * u, b + u * v, c + v * v, d + u * w, e + v * w
    a, c = max(a, TINY), max(c, TINY)
    sine = a * c - b * b
    if sine > PARALLEL * a * c:
        s = clamped((b * e - c * d) / sine)
    else:
        one, other = clamped(-d / a), clamped((b - d) / a)
        s = 0.5 * (one + other)
    t = clamped((b * s + e) / c)
    s = clamped((b * t - d) / a)
    total = 0.0
    for k in range(AXES):
        way = q[0, k] + t * (q[1, k] - q[0, k]) - p[0, k] - s * (p[1, k] - p[0, k])
        out[2 + k] = way
        total += way * way
    out[ALPHA], out[BETA] = s, t
    return math.sqrt(total)


@device
def at_time(start, end, strand, segment, t, out):
    """Set ``out`` (2, 3) to a segment at a share t of the step."""
    for i in range(2):
        for k in range(AXES):
            x = start[strand, segment + i, k]
            out[i, k] = x + t * (end[strand, segment + i, k] - x)


@device
def nearer_before(start, end, strand, segment, t, normal, side):
    """Whether the segment before this one comes nearer to what is along ``side`` times the normal than its end."""
    along = size = 0.0
    for k in range(AXES):
        a, b = start[strand, segment - 1, k], start[strand, segment, k]
        a += t * (end[strand, segment - 1, k] - a)
        b += t * (end[strand, segment, k] - b)
        along += side * normal[k] * (a - b)
        size += (a - b) ** 2
    return along > OBLIQUE * math.sqrt(size)


@device
def counts(start, end, pair, number, normal, t):
    """Whether the contact of a pair is a nearest place of both strands: at a joint it counts for the segment after it
    alone, and nowhere if the one before it comes nearer."""
    a, b, last = pair[FIRST_SEGMENT], pair[SECOND_SEGMENT], start.shape[1] - 2
    if (number[ALPHA] == 1.0 and a < last) or (number[BETA] == 1.0 and b < last):
        return False
    if number[ALPHA] == 0.0 and a > 0 and nearer_before(start, end, pair[FIRST], a, t, normal, 1.0):
        return False
    return not (number[BETA] == 0.0 and b > 0 and nearer_before(start, end, pair[SECOND], b, t, normal, -1.0))


@device
def greatest_speed(start, end, pair):
    """The greatest relative way of the ends of a pair's segments."""
    worst = 0.0
    for i in range(2):
        for j in range(2):
            total = 0.0
            for k in range(AXES):
                a, b = pair[FIRST_SEGMENT] + i, pair[SECOND_SEGMENT] + j
                u = end[pair[SECOND], b, k] - start[pair[SECOND], b, k]
                u -= end[pair[FIRST], a, k] - start[pair[FIRST], a, k]
                total += u * u
            worst = max(worst, total)
    return math.sqrt(worst)


@device
def aside(pair, p, way):
    """Set a ``way`` across the segment p for a pair that lies in one line: it differs from pair to pair, and is the
    same at each step."""
    turn = 2.399963 * (7.0 * pair[FIRST] + 13.0 * pair[SECOND])
    x, y, z = p[1, 0] - p[0, 0], p[1, 1] - p[0, 1], p[1, 2] - p[0, 2]
    u, v, w = math.cos(turn), math.sin(turn), math.cos(0.7 * turn)
    way[0], way[1], way[2] = y * w - z * v, z * u - x * w, x * v - y * u
    size = math.sqrt(way[0] ** 2 + way[1] ** 2 + way[2] ** 2)
    for k in range(AXES):
        way[k] = way[k] / max(size, TINY)


@device
def kept_distance(start, pair, lengths, thickness):
    """The distance that segments should keep: that of their roots, which hold them there, and more the further from
    these, up to the thickness."""
    if pair[FIRST] == pair[SECOND]:
        return thickness
    total = 0.0
    for k in range(AXES):
        total += (start[pair[FIRST], 0, k] - start[pair[SECOND], 0, k]) ** 2
    one = lengths[pair[FIRST]] * pair[FIRST_SEGMENT]
    other = lengths[pair[SECOND]] * pair[SECOND_SEGMENT]
    return min(thickness, math.sqrt(total) + SLOPE * min(one, other))


@device
def nearest_at(start, end, pair, t, scratch):
    """As `nearest` of a pair at a share t of the step: segments and what is found go to rows 0 to 2 of ``scratch``."""
    at_time(start, end, pair[FIRST], pair[FIRST_SEGMENT], t, scratch[0])
    at_time(start, end, pair[SECOND], pair[SECOND_SEGMENT], t, scratch[1])
    return nearest(scratch[0], scratch[1], scratch[2].reshape(-1))


@device
def volume(start, end, pair, t, scratch):
    """The determinant of a pair's segments and the way between their beginnings, at a share t of the step: it changes
    its sign where their ends lie in a plane (Provot 1997). The segments go to rows 0 and 1 of ``scratch``."""
    p, q = scratch[0], scratch[1]
    at_time(start, end, pair[FIRST], pair[FIRST_SEGMENT], t, p)
    at_time(start, end, pair[SECOND], pair[SECOND_SEGMENT], t, q)
    x, y, z = cross(p, q)
    return x * (q[0, 0] - p[0, 0]) + y * (q[0, 1] - p[0, 1]) + z * (q[0, 2] - p[0, 2])


@device
def cross(p, q):
    """The vector product of the segments p and q (2, 3)."""
    x, y, z = p[1, 0] - p[0, 0], p[1, 1] - p[0, 1], p[1, 2] - p[0, 2]
    u, v, w = q[1, 0] - q[0, 0], q[1, 1] - q[0, 1], q[1, 2] - q[0, 2]
    return y * w - z * v, z * u - x * w, x * v - y * u


@device
def rest_of_step(start, end, pair, t, least, scratch):
    """Whether a pair passes through each other from a share t of the step on, at which one that does first, else 1,
    and the distance there, as which ``least`` counts where it does, on the side where it was before. What is nearest
    goes to ``scratch`` as by `nearest_at`."""
    low, before, found = t, volume(start, end, pair, t, scratch), scratch[2].reshape(-1)
    for piece in range(1, PIECES + 1):
        high = t + piece / PIECES * (1.0 - t)
        after = volume(start, end, pair, high, scratch)
        if (before > 0.0) != (after > 0.0):
            at, above = low, high
            for _ in range(BISECTIONS):
                middle = 0.5 * (at + above)
                if (volume(start, end, pair, middle, scratch) > 0.0) == (before > 0.0):
                    at = middle
                else:
                    above = middle
            if nearest_at(start, end, pair, at, scratch) < TOUCH * least:
                return True, at, stand_off(scratch[0], scratch[1], math.copysign(least, before), found)
        low, before = high, after
    return False, 1.0, nearest_at(start, end, pair, 1.0, scratch)


@device
def stand_off(p, q, side, found):
    """Set the way between the segments p and q to one across both of the length and with the sign of ``side``; return
    its length, 0 of parallel ones."""
    a, b, c = cross(p, q)
    size = math.sqrt(a * a + b * b + c * c)
    if size <= TINY:
        return 0.0
    found[2], found[3], found[4] = side * a / size, side * b / size, side * c / size
    return abs(side)


@function
def look(start, end, lengths, pairs, sizes, numbers, vectors, scratch):
    """Set the contacts of ``pairs``: their ``numbers`` and ``vectors`` as in `contact_pairs`. ``start`` and ``end``
    (S, N + 1, 3): particles when the step begins, and where it would end. ``sizes``: the distance that strands keep,
    how much of it they come apart in a step at the most, where they begin closer, and the distance at the end from
    which on a contact does not count. ``lengths`` (S,): of a segment. ``scratch`` (6, 2, 3)."""
    for i in range(len(pairs)):
        look_at(start, end, lengths, pairs[i], sizes, numbers[i], vectors[i], scratch)


@device
def look_at(start, end, lengths, pair, sizes, number, vector, scratch):
    """Set a contact of a pair."""
    thickness, ease, far = sizes
    found = scratch[2].reshape(-1)
    distance = nearest_at(start, end, pair, 0.0, scratch)
    begin = number[BEGIN] = distance
    speed = greatest_speed(start, end, pair)
    if begin - speed > far:
        number[COUNTS] = 0.0
        return
    size = max(begin, TINY)
    x, y, z = found[2] / size, found[3] / size, found[4] / size
    free = min(1.0, max(0.0, min(pair[FIRST_SEGMENT], pair[SECOND_SEGMENT]) - 1.0) / BOUND)
    number[KEPT] = kept = kept_distance(start, pair, lengths, thickness)
    number[WANTED] = min(kept, begin + free * ease * thickness)
    least = NEAR * min(begin, thickness)
    t = 0.0
    for _ in range(ADVANCES):
        if t >= 1.0 or distance <= CLOSE * least:
            break
        t = min(1.0, t + (distance - least) / max(speed, TINY))
        distance = nearest_at(start, end, pair, t, scratch)
    decided = t >= 1.0 or distance <= CLOSE * least
    touch(start, end, pair, (t, distance, thickness), number, vector, scratch)
    # what does not keep a pair apart, at a joint or to the side of where it goes, may let it through later
    if t < 1.0 and begin > DEEP * thickness and not (decided and number[COUNTS] > 0.0 and number[GAP] < number[WANTED]):
        passes, t, distance = rest_of_step(start, end, pair, t, CLOSE * least, scratch)
        if passes or not decided:
            touch(start, end, pair, (t, distance, thickness), number, vector, scratch)
    number[SAME] = x * vector[NORMAL] + y * vector[NORMAL + 1] + z * vector[NORMAL + 2]
    if distance <= 1e-6 * thickness:
        number[SAME] = 0.0


@device
def touch(start, end, pair, at, number, vector, scratch):
    """Set the contact of a pair to what `nearest_at` has found: ``at`` its share of the step and the distance, and the
    thickness."""
    t, distance, thickness = at
    found = scratch[2].reshape(-1)
    number[ALPHA], number[BETA] = found[ALPHA], found[BETA]
    if distance > 1e-6 * thickness:
        for k in range(AXES):
            vector[NORMAL + k] = found[2 + k] / distance
    else:
        aside(pair, scratch[0], vector)
    gap = 0.0
    a, b = pair[FIRST_SEGMENT], pair[SECOND_SEGMENT]
    for k in range(AXES):
        for place, x in ((START, start), (END, end)):
            one, other = x[pair[FIRST]], x[pair[SECOND]]
            vector[place + k] = (
                other[b, k] + number[BETA] * (other[b + 1, k] - other[b, k])
                - one[a, k] - number[ALPHA] * (one[a + 1, k] - one[a, k])
            )  # fmt: skip
        gap += vector[NORMAL + k] * vector[END + k]
    number[GAP] = gap
    number[COUNTS] = 1.0 if counts(start, end, pair, number, vector, t) else 0.0
