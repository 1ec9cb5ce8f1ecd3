"""A second solid that presses a particle: where strands lie in the groove between two.

With the force of one solid a round a particle in a groove would have the force of either in turn, and no round would be
the last. The second one is looked for in scenes of several solids, and only of particles that the first one presses.
"""

from __future__ import annotations

from ...jit import device, inlined
from ...simd import any_lane, broadcast, load, load3, store3, where
from .contact_circle import contact_circle
from .contact_cone import ALIKE
from .contact_others import count_of
from .contact_place import SLOT, carried_to, normal_at, slide
from .contact_shapes import BOX, CAPSULE, PLANE, SPHERE, nearest_but
from .contact_spots import NORMAL, size_of
from .records import BOXES, CAPSULES, PLANES, SPHERES
from .rod_scratch import AXES, FIRST_SEGMENT, INVERSE_LENGTH, PACK, SEGMENT, SOLID_SLOTS, THIRD_SLOT
from .rod_tension import spare
from .vectors import add_scaled, dot, scaled, select


@inlined
def several(solids):
    """Whether there are two solids or more."""
    count = solids[SPHERES][1] // SPHERE + solids[CAPSULES][1] // CAPSULE
    count += solids[PLANES][1] // PLANE + solids[BOXES][1] // BOX
    return count + count_of(solids) > 1


@inlined
def other_of(n, j):
    """Place of a second solid's normal at the particle after segment j of n, and of by how much it should move that:
    `rod_descent` needs the room when forces have been found."""
    return spare(n, j)


@device
def set_other(s, at, segment, found, place, known, edges, state, contact):
    """Set what a second solid wants of the particle of a segment, and zeros in lanes where none is near. ``found``:
    slot of the first solid; ``place``: where the edge begins, its direction, and where it ends; ``known``: in which
    lanes the particle is inside the first, and how far forces and depth may move it, metres; edges: its `Edges`."""
    q, d, end = place
    inside, reach = known
    slots = THIRD_SLOT, 2 * SOLID_SLOTS + SLOT - found
    before = state.positions, segment.position, True
    depth, second = nearest_but(s, found, slots, end, edges, before, reach, contact.solids)
    zero = broadcast(depth, 0.0)
    n, wanted = (zero, zero, zero), (zero, zero, zero)
    close = inside & (depth > -reach)
    if any_lane(close):
        there, one = normal_at(s, second, end, depth), load3(s, segment.scratch + NORMAL, 1)
        _, _, _, square = contact_circle(s, second, q, load(s, INVERSE_LENGTH))
        cosine = dot(there, one)
        able = close & (square > 0.0) & (cosine * cosine < ALIKE) & (size_of(one) > 0.0)
        way = slide(carried_to(s, second, segment, state, contact), end, d, there, depth)
        way = add_scaled(scaled(depth + dot(way, there), there), -1.0, way)
        n, wanted = select(able, there, n), select(able, way, wanted)
    o = other_of(at.segments, (segment.scratch - FIRST_SEGMENT) // SEGMENT)
    store3(s, o, 1, n[0], n[1], n[2])
    store3(s, o + 3, 1, wanted[0], wanted[1], wanted[2])


@device
def between(s, at, state):
    """In which lanes a particle that solids press is near a second one. Asked after a search."""
    found = broadcast(s, 0.0)
    for j in range(at.segments):
        held = size_of(load3(state.push, at.edge + j * AXES, PACK))
        found = max(found, where(held > 0.0, size_of(load3(s, other_of(at.segments, j), 1)), 0.0))
    return found > 0.0
