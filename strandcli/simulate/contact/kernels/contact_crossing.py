"""When two segments pass through each other: where their four ends lie in a plane, the roots of a cubic (Provot 1997).

The cubic is monotonic between the roots of its derivative, so that a fixed number of bisections finds each of its
roots, however fast the segments are and however long they slide along each other.
"""

from __future__ import annotations

import math

from ....jit import device
from .contact_columns import AXES, FIRST, FIRST_SEGMENT, SECOND, SECOND_SEGMENT

BISECTIONS = 52
"""As many as a share in [0, 1] has bits."""


@device
def volume(ways, i, j, k):
    """The determinant of rows 0, 1, 2 of ``ways`` (3, 2, 3), each either as it is (0) or its change (1)."""
    u, v, w = ways[0, i], ways[1, j], ways[2, k]
    x = u[1] * v[2] - u[2] * v[1]
    y = u[2] * v[0] - u[0] * v[2]
    z = u[0] * v[1] - u[1] * v[0]
    return x * w[0] + y * w[1] + z * w[2]


@device
def set_ways(start, end, pair, t, ways):
    """Set ``ways`` (3, 2, 3) to both segments of a pair and the way between their beginnings, at a share t of the step,
    and to what they change by until its end."""
    a, b = pair[FIRST_SEGMENT], pair[SECOND_SEGMENT]
    for k in range(AXES):
        for i, x in ((0, start), (1, end)):
            one, other = x[pair[FIRST]], x[pair[SECOND]]
            ways[0, i, k] = one[a + 1, k] - one[a, k]
            ways[1, i, k] = other[b + 1, k] - other[b, k]
            ways[2, i, k] = other[b, k] - one[a, k]
        for c in range(3):
            change = ways[c, 1, k] - ways[c, 0, k]
            ways[c, 0, k] += t * change
            ways[c, 1, k] = (1.0 - t) * change


@device
def cubic_of(ways):
    """The coefficients of the determinant of ``ways`` as a cubic of the share of their change, the constant first."""
    return (
        volume(ways, 0, 0, 0),
        volume(ways, 1, 0, 0) + volume(ways, 0, 1, 0) + volume(ways, 0, 0, 1),
        volume(ways, 0, 1, 1) + volume(ways, 1, 0, 1) + volume(ways, 1, 1, 0),
        volume(ways, 1, 1, 1),
    )


@device
def value(cubic, x):
    """A cubic at x."""
    return cubic[0] + x * (cubic[1] + x * (cubic[2] + x * cubic[3]))


@device
def next_turn(cubic, x):
    """The least place above x where a cubic's derivative is 0, or 1 if none is less."""
    a, b, c = 3.0 * cubic[3], cubic[2], cubic[1]
    root = b * b - a * c
    if root < 0.0:
        return 1.0
    half = -(b + math.copysign(math.sqrt(root), b))
    low, high = half / a if a != 0.0 else 1.0, c / half if half != 0.0 else 1.0
    low, high = min(low, high), max(low, high)
    if low > x:
        return min(low, 1.0)
    return min(high, 1.0) if high > x else 1.0


@device
def root_between(cubic, low, high):
    """Where a cubic changes its sign between two places at which it has different ones."""
    above = value(cubic, low) > 0.0
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        if (value(cubic, middle) > 0.0) == above:
            low = middle
        else:
            high = middle
    return low
