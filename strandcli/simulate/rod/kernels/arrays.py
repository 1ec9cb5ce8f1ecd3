"""Arguments of a rod's step: named arrays and numbers.

P packs of S = `PACK` strands with N segments each; (P, N, 3 S) holds x of all strands of a pack, then y, then z. All
arrays of `State`, `Material` and `Drive` have one floating type. Members that a scene does not need have one pack,
which is not read. Fields marked "changed" are written by a step.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from ....constants import W

PACK = 16
"""Strands whose state lies together: in single precision a cache line each."""
AXES = 3 * PACK
"""Numbers in a row of three coordinates of all strands of a pack."""
ROW = 3 * W
"""Numbers of a row of positions, which are drawn and lie in blocks."""
MOTION = 12
"""Columns that follow a packed solid's: its rigid motion in this step, rotation by rows and then translation."""


class State(NamedTuple):
    """What a step changes."""

    edges: Any
    """(P, N, 3 S) unit vectors; changed."""
    velocity: Any
    """(P, N, 3 S) of particles, m/s; changed."""
    before: Any
    """(P, N, 3 S) velocity one step before, m/s; changed."""
    ahead: Any
    """(P, N, 3 S) velocity extrapolated to the next step, m/s; changed."""
    moved: Any
    """(P, N, 3 S) last displacement, metres; changed."""
    tension: Any
    """(P, N, S) force densities, 1/s²; changed."""
    force: Any
    """(P, N, 3 S) force of solids on each segment, over the mass of a particle, m/s²; changed; needed with solids."""
    share: Any
    """(P, N, S) where on its segment it acts, from its beginning; changed; needed where whole segments stay out."""
    restart: Any
    """(P, S) above 0 for strands that take this step by Euler's method; changed."""
    acceleration: Any
    """(P, N, 3 S) of particles by the strands around, m/s²; changed before a step; of contact alone, where listed."""
    jolted: Any
    """(P, S) 1 for strands that those around push otherwise than in the step before; the same."""
    twist: Any
    """(P, N, S) angles of the material frames about the edges, radians; changed; needed by curled strands."""
    positions: Any
    """(blocks, N + 2, 3 W) world, metres: row 0 one segment before the root, row 1 the root; changed."""
    residuals: Any
    """(P, S) greatest | |e| − 1 | that the iterations have left; changed."""


class Material(NamedTuple):
    """What strands are made of."""

    lengths: Any
    """(P, S) of a segment, metres."""
    stiffness: Any
    """(P, S) B / (ρ A ℓ⁴), 1/s²."""
    mass: Any
    """(N,) relative mass of a particle; the tip has 1/2, a pinned one very much."""
    joint: Any
    """(N,) relative rigidity of the joint before an edge; a clamped root has 2."""
    bends: Any
    """(P, N + 1, 3 S) row 0 a unit vector across the clamped direction, in the emitter's frame, at which frames begin;
    then the rest value of each c_j in the frame of the edge before it. Needed by curled strands."""


class Drive(NamedTuple):
    """What moves strands in a step."""

    roots: Any
    """(P, 3 S) in the emitter's frame, metres."""
    directions: Any
    """(P, 3 S) unit vectors along which strands are clamped, in the emitter's frame."""
    gust: Any
    """(P, S) factor of the air's velocity."""
    drift: Any
    """(P, 3 S) displacement of roots in the step besides that of the emitter, metres; needed by roots that deform."""
    tips: Any
    """(P, 3 S) displacement of pinned tips in the step, metres; needed by these."""


class Step(NamedTuple):
    """Numbers of a step."""

    duration: Any
    """Seconds."""
    bdf2: Any
    """Whether strands go by BDF2, but those that `State.restart` marks; otherwise by Euler's method."""
    iterations: Any
    """Newton's iterations, at most."""
    tolerance: Any
    """Error of |e|² at which they stop."""
    contact_tolerance: Any
    """The same without what pinned tips ask for; contact goes by it."""
    rounding: Any
    """Error of |e|² that is no more than rounding."""
    gravity: Any
    """(3) m/s²."""
    air: Any
    """(3) velocity, m/s."""
    drag: Any
    """1/s."""
    damping: Any
    """Of the material, s."""
    friction: Any
    """Coulomb's coefficient."""
    torsion: Any
    """Torsional over bending rigidity."""
    root_twist: Any
    """Relative rigidity against twist of the joint after the first edge."""
    rotation: Any
    """(9) the emitter's at the end of the step, by rows."""
    translation: Any
    """(3) metres."""
    turned: Any
    """(9) change of the rotation in the step."""
    shifted: Any
    """(3) change of the translation."""


class Needs(NamedTuple):
    """What a scene needs; tested at run time, once a vector or segment."""

    curled: Any
    """Whether rest shapes are curved."""
    solids: Any
    """Whether there are solids."""
    segments: Any
    """Whether solids keep whole segments out, and not particles alone."""
    deforming: Any
    """Whether roots move in the emitter's frame."""
    pinned: Any
    """Whether tips are pinned."""
    pushed: Any
    """Whether other strands accelerate particles."""
    lasting: Any
    """Whether they do so all through a step, as gravity does; else they change the velocity it begins with."""


class Place(NamedTuple):
    """Where a vector of strands is in the arrays: flat indices of its first lane."""

    segments: Any
    """N."""
    strand: Any
    """In (P, S)."""
    root: Any
    """In (P, 3 S)."""
    edge: Any
    """In (P, N, 3 S), of the first segment."""
    number: Any
    """In (P, N, S), of the first segment."""
    bend: Any
    """In (P, N + 1, 3 S), of the first row."""
    position: Any
    """In the positions, of row 0."""


class Coefficients(NamedTuple):
    """What follows from the method and the length of a step for each strand of a vector; vectors of lanes, lengths in
    segments."""

    length: Any
    """Of a segment, metres."""
    inverse_length: Any
    """1/m."""
    velocity_scale: Any
    """Displacement by a velocity of 1 m/s."""
    reach: Any
    """Displacement in metres by 1 m/s² that acts all through the step, h g / (1 + γ g); forces enter with it."""
    added: Any
    """(3) Velocity that gravity and air add, m/s."""
    stiffness: Any
    """κ of a joint whose relative rigidity is 1, damping included."""
    damped: Any
    """Share of it that is damping's."""
    moved_share: Any
    """Share of the last displacement that goes on: 1/3 for BDF2, and 0 for Euler's method."""
    push_step: Any
    """h of velocities for the accelerations by the strands around, s."""
    push_change: Any
    """That by which they change the velocity that the step begins with, s: as much, or 0 where they last."""
    inverse_step: Any
    """1 / h of displacements, 1/s."""
    duration: Any
    """Of the step or its part, seconds."""
