"""Arguments of the kernels of a rod's step, as flat tuples of pointers and numbers.

P packs of S = `rod_scratch.PACK` strands with N segments each; (P, N, 3 S) holds x of all strands of a pack, then y,
then z. The driver fills `State`, `Material` and `Forcing` with arrays of one floating type; kernels see pointers to
them.
"""

from __future__ import annotations

from typing import Any, NamedTuple

STEP, GRAVITY, AIR, DRAG, DAMPING, MOVED, FRICTION, TOLERANCE, ROUNDING, TORSION = 0, 1, 4, 7, 8, 9, 10, 11, 12, 13
VELOCITY_STEP, LASTING, ROOT_TWIST, FREE = range(14, 18)
NUMBERS = 18
"""Columns of ``Forcing.numbers``: h of displacements in s, gravity (3) in m/s², velocity of the air (3) in m/s, drag in
1/s, material damping in s times h over the step, share of the last displacement that goes on, 1/3 for BDF2 and 0 for
Euler's method, friction, error of |e|² at which iterations stop, error that is no more than rounding, torsional over
bending rigidity, h of velocities in s, above 0 where `State.crowd` are accelerations by contact, which act all through
a step as gravity does, the relative rigidity against twist about the root, and above 0 where nothing but solids can
give strands energy (`rod_energy`)."""
ROTATION, TRANSLATION, TURNED, SHIFTED = 0, 9, 12, 21
POSE = 24
"""Columns of ``Forcing.pose``: the emitter's rotation by rows and its translation, and the change of both in this
step."""

SPHERES, CAPSULES, PLANES, BOXES, OTHERS = range(5)
"""Members of ``Contact.solids``, in the order of the fields of `strandcli.solids.Solids`."""
MOTION, MOTION_SHIFT = 12, 9
"""Columns that follow a packed solid's: the rigid motion of this step, rotation by rows and then translation."""

CHANGED = 2.0
"""`State.touching` of strands of which other particles than in the step before are pressed."""


class State(NamedTuple):
    """What a step changes. Members that a scene does not need have one row, which is not read."""

    edges: Any
    """(P, N, 3 S) unit vectors."""
    velocity: Any
    """(P, N, 3 S) of particles, m/s."""
    before: Any
    """(P, N, 3 S) velocity one step before, m/s."""
    ahead: Any
    """(P, N, 3 S) velocity extrapolated from the last three, m/s."""
    moved: Any
    """(P, N, 3 S) last displacement, metres."""
    tension: Any
    """(P, N, S) force densities of the last step over h², 1/s²."""
    push: Any
    """(P, N, 3 S) acceleration of particles by contact with solids, m/s²; needed with these."""
    touching: Any
    """(P, S) 1 for strands that solids press, `CHANGED` for those that take the next step by Euler's method, as BDF2
    would go on with forces that have come or gone; needed with solids."""
    twist: Any
    """(P, N, S) twist angles of the frames about their edges, radians; needed by curled strands."""
    crowd: Any
    """(P, N, 3 S) acceleration of particles by the strands around them, m/s²; needed where strands interact, and with
    the rule contact, by which alone it is then. A step with code beside it (`work_queue.call_for`) has those of a pack
    in scratch of its own instead."""
    jolted: Any
    """(P, S) 1 for strands that those around push otherwise than in the step before, which take the step by Euler's
    method; needed where strands interact."""
    positions: Any
    """(blocks, N + 2, 3 W) world, metres: row 0 one segment before the root, row 1 the root."""
    residuals: Any
    """(P, S) greatest | |e| − 1 | before lengths are made exact."""
    energy: Any
    """(P, S) what strands may have, m²/s² times relative masses, `rod_energy.UNKNOWN` where it is not known; this and
    the next one needed by curled strands."""
    calmed: Any
    """(P, S) above 0 for strands that take the next step by Euler's method, as their energy would grow."""


class Material(NamedTuple):
    """What strands are made of, and their rest shapes."""

    lengths: Any
    """(P, S) of a segment, metres."""
    stiffness: Any
    """(P, S) B / (ρ A ℓ⁴), 1/s²."""
    mass: Any
    """(N,) relative mass of a particle, times 1 + drag h; the tip has 1/2."""
    joint: Any
    """(N,) relative rigidity of the joint before an edge; the root has 2."""
    bends: Any
    """(P, N + 1, 3 S) row 0 a unit vector across the clamped direction, in the emitter's frame, which the frame of the
    clamp begins with; then the rest value of each c_j in the frame of the edge
    before it. Needed by curled strands."""


class Forcing(NamedTuple):
    """What moves strands in a step; ``drift`` as members of `State`."""

    roots: Any
    """(P, 3 S) in the emitter's frame, metres."""
    directions: Any
    """(P, 3 S) unit vectors along which strands are clamped, in the emitter's frame."""
    gust: Any
    """(P, S) factor of the air's velocity."""
    pose: Any
    """(`POSE`,)"""
    numbers: Any
    """(`NUMBERS`,)"""
    drift: Any
    """(P, 3 S) displacement of roots in the step beside that of the emitter, metres; needed by roots that deform."""
    firmness: Any
    """(P, S) rigidity that keeps edges where they are led, in units of κ θ² of the joints at both ends; needed, with
    the next one, by curled strands."""
    led: Any
    """(P, S) share of a step's way that motion leads edges."""


class Flags(NamedTuple):
    """What a scene needs. Tested at run time, for each variant of the kernel takes seconds to compile; but for
    ``crowded``, which is True, or None that leaves what it needs out of a kernel: a step takes a fourteenth less
    then."""

    curled: Any
    """Whether rest shapes are curved."""
    solids: Any
    """Whether there are solids."""
    segments: Any
    """Whether solids keep whole segments out, and not only particles."""
    deforming: Any
    """Whether roots move in the emitter's frame."""
    crowded: Any
    """Whether strands interact."""


class Place(NamedTuple):
    """Places of a vector of strands in the arrays: of its first lane, as flat indices."""

    segments: Any
    """N."""
    strand: Any
    """In (P, S)."""
    edge: Any
    """In (P, N, 3 S), of the first segment."""
    tension: Any
    """In (P, N, S), of the first segment."""
    bend: Any
    """In (P, N + 1, 3 S), of the first row."""
    position: Any
    """In the positions, of row 0."""


class Scheme(NamedTuple):
    """Time integration: how a particle's free displacement is predicted."""

    share: Any
    """Of the last displacement that goes on, 1/3 for BDF2."""
    pressed: Any
    """Whether solids press some strand of the vector."""
    mixed: Any
    """Whether some strand of the vector takes the step by Euler's method (`rod_start.disturbed`)."""
    crowded: Any
    """Whether the strands around accelerate particles (`rod_start.set_steps_of_crowd`): True, or None."""
    duration: Any
    """Of the step, seconds."""
    curled: Any
    """Whether rest shapes are curved, and forces keep edges where motion leads them (`rod_tension.firm_force`)."""


class Contact(NamedTuple):
    """Solids and the numbers of contact."""

    solids: Any
    """Pairs of rows and their size, as `contact_shapes.nearest` takes them."""
    any_solids: Any
    """Whether there are any; at the end of a step, whether some are near strands of the vector."""
    segments: Any
    """Whether whole segments are kept out."""
    duration: Any
    """Of the step, seconds."""
    friction: Any
    """Coulomb's coefficient."""
    rounding: Any
    """Relative rounding error of a coordinate."""
    moved: Any
    """Whether solids have moved since the particles were where they are (`rod_parts`)."""


class Segment(NamedTuple):
    """A segment of a vector of strands whose end is tested against solids."""

    scratch: Any
    """Its place in the scratch (`rod_scratch`)."""
    row: Any
    """Its place in (P, N, 3 S)."""
    position: Any
    """Place of its end in the positions."""
    length: Any
    """Metres, a vector."""
    first: Any
    """Whether it begins at the root."""
