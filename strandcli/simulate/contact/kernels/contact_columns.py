"""Columns of the arrays that the kernels of contact between strands share.

S strands with N segments each, in the order of emission; lengths in metres. Particle 0 is the root.
"""

from __future__ import annotations

FIRST, FIRST_SEGMENT, SECOND, SECOND_SEGMENT = range(4)
"""Of a pair (int64): a strand and which of its segments, another (or the same) and which of its."""
ALPHA, BETA, GAP, WANTED, BEGIN, SAME, COUNTS, KEPT, YIELDING, IMPACT, URGENCY = range(11)
"""Of a contact (float64): places on both segments as shares from their beginnings; distance along the normal at the end
of the step, and the one that is wanted there; distance of the segments when the step begins; cosine between
the normal and that when the step begins; 1 where the place is nearest on both strands; the distance that
roots leave to the pair, at most the thickness; by how many times its own response it gives way to its force; the share
of that which is an impact; and how many times as far its force goes in a round as the response says, 0 as 1."""
NUMBERS = 11
NORMAL, START, END = 0, 3, 6
VECTORS = 9
"""Of a contact (float64), three each: unit normal from the first to the second strand; the way between both places at
the begin of the step and at its end."""
LOW, HIGH = 0, 3
"""Of a box: its least and its greatest corner."""
AXES = 3
