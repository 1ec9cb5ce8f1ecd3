"""Scratch of a rod's step: which vectors it holds of a strand and of each of its segments.

Scratch is a heap of vectors, one lane a strand. Those of the strand come first, then `SEGMENT` of each segment, from
the first one at place `FIRST_SEGMENT`, and then those that `rod_tension` adds. The vectors of a segment lie together
and, for short strands, fit the nearest cache. Two segments of zeros before the first and two after the last spare the
recurrences their special cases.

Lengths are in segments (rest length ℓ), so that a displacement is in units of ℓ. Two names with the same number share a
vector: the docstring says when it changes hands.
"""

from __future__ import annotations

PACK = 16
"""Strands whose state lies together, number by number in the order in which a step reads them: in single precision a
cache line each, which processors fetch ahead."""
AXES = 3 * PACK
"""Numbers in a row of three coordinates of all strands of a pack."""

INDEFINITE = 0
"""Of a strand: above 0 where τ makes H indefinite; 2 where τ is bounded by masses alone (`rod_elimination`)."""
ROOT_SHIFT = 1
"""(3) Displacement of the root in this step, metres."""
STIFFNESS = 4
"""κ h² of a joint whose relative rigidity is 1, damping included."""
INVERSE_LENGTH = 5
"""1 / ℓ, 1/m."""
ADDED_VELOCITY = 6
"""(3) Velocity that gravity and moving air add in a step, m/s."""
VELOCITY_SCALE = 9
"""Displacement, in segments, by a velocity of 1 m/s."""
ACCELERATION_SCALE = 10
"""Displacement, in segments, by an acceleration of 1 m/s²."""
CORRECTION = 11
"""(3) In the last sweep: by how much normalisation and contact have moved the particle, in segments."""
DEGENERATE = 14
"""In the last sweep: 1 where an edge has no finite direction, from there to the tip."""
IMPACT = 15
"""Above 0 where BDF2 starts anew: a particle has met a solid, or the strand spins."""
CONTACT_FORCE = 16
"""In the last sweep: the sum of the absolute coordinates of all accelerations by contact that last, m/s²."""
SOLID_SLOTS = 17
"""Two slots for the nearest solid, 8 vectors each (`contact_place`)."""
REACH = 33
"""Displacement of a free particle by 1 m/s² in a step, metres."""
SQUARE = 34
"""h², the product of those of displacements and velocities, by which forces enter the step, s²."""
INVERSE_STEP = 35
"""1 / h of displacements, 1/s."""
MOVED_SHARE = 36
"""Share of the last displacement that goes on: 1/3 for BDF2, and 0 for Euler's method."""
CROWD_STEP = 37
"""h of velocities for the accelerations by the strands around, s."""
CROWD_CHANGE = 38
"""That by which they change the velocity that the step begins with, s: as much, or 0 where they act all through it."""

CONTACT_CHANGE = 42
"""The sum of the absolute coordinates of all changes of accelerations by contact in the rounds of a step, m/s²."""
SPIN_AXIS = 39
"""(3) In the last sweep: the direction from root to tip where a strand has spun (`rod_spin`), else 0."""
CONTACT_WORK = 43
"""Σ M a·w of the last change a of accelerations by contact, and the displacements w that were wanted before it."""
BEYOND = 44
"""The same at the end of that change where it has gone too far, below 0; 0 where not."""
REACHED = 45
"""How far along that change the strand is: 1 at its end."""
WIDTH = 46
"""The length of that change as a share of what it was at first."""
FIRST_WORK = 47
"""The work along that change at its beginning if it was as steep as at first."""

THIRD_SLOT = 48
"""(8) One more slot, for the nearest solid but that one (`contact_corner`)."""

SEGMENT = 17
"""Vectors of a segment. An odd number: vectors at distances of a power of two would share lines of the cache."""
FIRST_SEGMENT = 56 + 2 * SEGMENT
"""Place of the first segment."""
EDGE = 0
"""(3) Of a segment: e_j, of unit length at the start and the end of a step."""
INERTIAL = 3
"""(3) u*_j − u_j, what is left of the free displacement: the inertial residual over the mass."""
DISPLACEMENT = INERTIAL
"""(3) In the last sweep: u_j."""
REST_BEND = 6
"""(3) c̄_j."""
LOAD = 9
"""(3) g_j, what loads alone change of the edge."""
EDGE_GAIN = LOAD
"""(3) From `rod_tension.filter_forward` to the sweep after it: the Kalman gain of the next edge."""
TENSION = 12
"""Force density τ_j h², relative to a segment's mass."""
INVERSE_PIVOT = 13
"""i_j of the elimination."""
EDGE_FACTOR = 14
"""i_j κ_j, by which z_j follows z_{j−1}."""
PARTICLE_FACTOR = 15
"""i_j B_j, by which z_j opposes y_{j−1}."""
INNOVATION = 16
"""The filter's innovation over its variance."""
MOBILITY = INNOVATION
"""After the iterations, where there are forces of contact: H⁻¹ M χ (`rod.begin_mobility`)."""


def vectors_for(n: int) -> int:
    """Vectors of a strand and its ``n`` segments; all begin as zeros."""
    return FIRST_SEGMENT + (n + 2) * SEGMENT
