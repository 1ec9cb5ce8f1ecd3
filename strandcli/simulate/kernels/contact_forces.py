"""Forces of contact between rods and solids, found within a step, in rounds.

Each round searches for the depths of all particles, updates the forces on them, and has Newton's iterations go on. A
force is the multiplier of an augmented Lagrangian (Nocedal & Wright 2006, §17.3): a particle at depth δ, with the
multiplier λ so far, gets

    λ' = max(0, λ + w δ),  at the surface if λ' > 0, released from λ if not,

and in the tangent plane the same with the sliding distance, at most μ λ' (Coulomb's law). Both are displacements,
forces times h²; w is the ratio of the effective mass of all that such forces on the strand move to the particle's: with
H of the iterations and χ = 1 at particles with forces, 1 / w = H⁻¹ M χ. That bounds the row sums of the response to the
forces, so all are updated at once without overshoot. The next step begins with the forces of this one, as accelerations
of particles, less what has stopped an impact. At rest δ = 0, and the force is the same at each step. What depth is left
after the last round is for `contact`, which turns edges out of solids.
"""

from __future__ import annotations

from ...constants import W
from ...jit import device, inlined
from ...simd import any_lane, broadcast, load, load3, sqrt, store, where
from .contact import CLEAR, slack_of
from .contact_circle import contact_circle
from .contact_corner import other_of, set_other, several
from .contact_place import carried_to, normal_at, slide
from .contact_shapes import TINY, edges_of, nearest
from .contact_spots import NORMAL, NOWHERE, begin_spot, released, size_of, spot_of, update_spot
from .records import CHANGED, Segment
from .rod import finish_mobility
from .rod_scratch import (
    AXES,
    CONTACT_CHANGE,
    CONTACT_FORCE,
    CONTACT_WORK,
    DISPLACEMENT,
    EDGE,
    FIRST_SEGMENT,
    IMPACT,
    INVERSE_LENGTH,
    PACK,
    REACH,
    ROOT_SHIFT,
    SEGMENT,
)
from .rod_tension import lasting_share, particle_gain
from .vectors import add_scaled, dot, scaled, select

ROW = 3 * W
"""Numbers of a row of positions."""
CLOSE = 1e-4
"""Change of all forces on a strand in a round, as a share of these, with which they count as found, both weighed by how
far they move particles."""
DEEP, HOVER = 0.01, 0.001
"""Depth, as a share of an edge, with which rounds go on for longer, for an edge that is turned by as much is a kink;
and height above the surface, of what is pressed, with which they do: strands hover on their tips."""
ASTRAY = 0.25
"""Depth in a solid or height above it, of what is pressed, as a share of an edge, from which on rounds have led a
strand astray."""
FAINT = 1e-20
"""Acceleration, m/s², that marks a particle without a force as one that contact acts on."""
SLIGHT = 0.3
"""Share of the tip's way in `mark`. Strands over a pole keep .90 of their swing in four seconds at 24 steps a second,
with a third of this .77, a tenth .41, and without the rule .99, but then a fine one over a ball rocks for ever."""


@device
def begin(s, at, push, pressed):
    """Begin a step: all forces that there are last. ``pressed``: whether some strand of the vector has any."""
    store(s, IMPACT, 0.0)
    store(s, CONTACT_FORCE, 0.0)
    store(s, CONTACT_CHANGE, 0.0)
    for j in range(at.segments):
        begin_spot(s, spot_of(at.segments, j, at.edge + j * AXES), push, pressed)


@device
def search(s, at, length, state, contact):
    """Find where particles are in solids or leave them: set their `NORMAL` and, in place of their gain, the
    displacement by which contact should move them. Those without a force yet get a `FAINT` one. Returns whether there
    are any in the vector, whether some are nearer to a solid than `CLEAR`, and in which lanes some are `DEEP` in one or
    `HOVER` above one, and in which `ASTRAY`.

    Particles are where the last sweep of the step will see them, with edges of exact length.
    """
    reach = load(s, REACH)
    margin = CLEAR * length
    q = load3(state.positions, at.position + ROW, W)
    left = broadcast(s, 0.0), broadcast(s, 0.0), broadcast(s, 0.0)
    acted, near, deep, astray = False, False, reach < 0.0, reach < 0.0
    corners = several(contact.solids)
    for j in range(at.segments):
        o = FIRST_SEGMENT + j * SEGMENT
        segment = Segment(o, at.edge + j * AXES, at.position + (j + 2) * ROW, length, j == 0)
        e = add_scaled(load3(s, o + EDGE, 1), -1.0, left)
        d = scaled(1.0 / sqrt(max(dot(e, e), TINY)), e)
        end = add_scaled(q, length, d)
        held = reach * size_of(load3(state.push, segment.row, PACK))
        within = max(where(held > 0.0, at.segments * length, margin), held)
        edges = edges_of(s, o, d, length, contact.segments, segment.first)
        depth, found = nearest(s, end, edges, (state.positions, segment.position, True), within, contact.solids)
        close = depth > -within
        if any_lane(close | (held > 0.0)):
            near = True
            inside = close & ((depth > slack_of(length, q, contact)) | (held > 0.0))
            if any_lane(inside | (held > 0.0)):
                acted = True
                place = q, d, end
                d = set_wanted(s, at, segment, found, place, depth, inside, state, contact)
                if corners:
                    pushed = held + max(depth, 0.0) + CLOSE * length
                    set_other(s, at, segment, found, place, (inside, pushed), edges, state, contact)
                able = size_of(load3(s, o + NORMAL, 1)) > 0.0
                far = (held > DEEP * length) & ~able
                deep = deep | (able & ((depth > DEEP * length) | (depth < -HOVER * length))) | far
                astray = astray | ((able | far) & (abs(depth) > ASTRAY * length))
        left = add_scaled(d, -1.0, e)
        q = add_scaled(q, length, d)
    return acted, near, deep, astray


@inlined
def set_wanted(s, at, segment, found, place, depth, inside, state, contact):
    """Set what `search` finds of the particle of a segment, in the lanes in which it is ``inside`` the solid in slot
    ``found``, and nothing in others. ``place``: where the edge begins, its direction, and where it ends. Returns the
    direction, turned in lanes where no edge from there can end at the surface: its depth is no force's."""
    q, d, end = place
    j = (segment.scratch - FIRST_SEGMENT) // SEGMENT
    n = normal_at(s, found, end, depth)
    axis, _, share, square = contact_circle(s, found, q, load(s, INVERSE_LENGTH))
    able = inside & (square > 0.0)
    carried = carried_to(s, found, segment, state, contact)
    way = slide(carried, end, d, n, depth)
    wanted = add_scaled(scaled(depth + dot(way, n), n), -1.0, way)
    zero = broadcast(depth, 0.0)
    for c in range(3):
        store(s, segment.scratch + NORMAL + c, where(able, n[c], zero))
        store(s, particle_gain(at.segments, j) + c, where(inside, wanted[c], zero))
    lasting = load(s, lasting_share(at.segments, j))
    new = able & (lasting < 0.0)
    if any_lane(new):
        before = load3(state.velocity, segment.row, PACK), load3(state.positions, segment.position, W)
        resting = resting_depth(carried, before, n, depth, contact.duration)
        store(s, lasting_share(at.segments, j), where(new, resting / max(depth, TINY), lasting))
        store(s, IMPACT, where(new, broadcast(depth, 1.0), load(s, IMPACT)))
    push = load3(state.push, segment.row, PACK)
    bare = able & ~(size_of(push) > 0.0)
    if any_lane(bare):
        for c in range(3):
            store(state.push, segment.row + c * PACK, where(bare, FAINT * n[c], push[c]))
    stuck = inside & (depth > 0.0) & (square <= 0.0)
    return select(stuck, scaled(share, axis), d)


@device
def update(s, at, length, state, contact, mass, gain, along):
    """Update forces by what `search` has found, with the mobilities that `rod.begin_mobility` has begun, and take what
    they change from the inertial residuals; in lanes that go ``along`` the last change, by what that says. ``gain``:
    factor of what `search` has found. Returns whether the forces on some strand are not found yet."""
    y, z = broadcast(s, 0.0), broadcast(s, 0.0)
    sums = y, y, y
    factors = load(s, REACH), gain, contact.friction, direction_of(s, along)
    corners = several(contact.solids)
    for j in range(at.segments):
        y, z = finish_mobility(s, FIRST_SEGMENT + j * SEGMENT, y, z)
        spot = spot_of(at.segments, j, at.edge + j * AXES, other_of(at.segments, j) if corners else NOWHERE)
        sums = update_spot(s, spot, state.push, mass[j], factors, along, sums)
    total, changed, work = sums
    slack = slack_of(length, load3(state.positions, at.position + ROW, W), contact)
    store(s, CONTACT_WORK, where(along.going, load(s, CONTACT_WORK), load(s, INVERSE_LENGTH) * work))
    return any_lane(along.going | (changed > max(CLOSE * total, slack)))


@inlined
def direction_of(s, along):
    """-1 in lanes that take a change back, else 1: what is taken back has not changed."""
    return where(along.move < 0.0, broadcast(s, -1.0), 1.0)


@device
def mark_released(s, at, push):
    """Have BDF2 start anew in lanes where a particle that solids pressed is free now: it would go on with the force."""
    impact = load(s, IMPACT)
    for j in range(at.segments):
        spot = spot_of(at.segments, j, at.edge + j * AXES)
        impact = where(released(s, spot, push), 1.0, impact)
    store(s, IMPACT, impact)


@device
def sprung(s, at, length, state):
    """In which lanes a particle that solids pressed is free now, and further than `ASTRAY` from where it was: strands
    between two ends snap through where rounds press too much for one of them."""
    zero = broadcast(s, 0.0)
    q, found = (zero, zero, zero), zero
    for j in range(at.segments):
        row = at.edge + j * AXES
        spot = spot_of(at.segments, j, row)
        e, before = load3(s, spot.scratch + EDGE, 1), load3(state.edges, row, PACK)
        q = add_scaled(add_scaled(q, length, e), -length, before)
        found = max(found, where(released(s, spot, state.push), dot(q, q), 0.0))
    return found > (ASTRAY * length) * (ASTRAY * length)


@inlined
def mark(s, at, touching, duration):
    """Set `State.touching` at the end of a step of ``duration`` seconds: `CHANGED` where other particles are pressed,
    and where forces have changed by what would move all particles by `SLIGHT` of the tip's way or more: BDF2 would go
    on with these, and strands that hardly move would never come to rest."""
    n, inverse_length = at.segments, load(s, INVERSE_LENGTH)
    tip = load3(s, FIRST_SEGMENT + (n - 1) * SEGMENT + DISPLACEMENT, 1)
    way = add_scaled(tip, -inverse_length, load3(s, ROOT_SHIFT, 1))
    by_itself = duration * duration * inverse_length * load(s, CONTACT_CHANGE)
    pressed = load(s, CONTACT_FORCE) > 0.0
    still = pressed & ~(by_itself < SLIGHT * n * sqrt(dot(way, way)))
    one = broadcast(s, 1.0)
    found = where(still | (load(s, IMPACT) > 0.0), CHANGED * one, one)
    store(touching, at.strand, where(pressed | (load(s, IMPACT) > 0.0), found, 0.0))


@inlined
def resting_depth(carried, begun, n, depth, duration):
    """Return the part of the depth of a particle in new contact that its velocity before the step does not account for;
    the rest is an impact and gives no lasting force. ``carried``: where the solid carries it; ``begun``: its velocity
    before the step, and its place then."""
    v, before = begun
    way = carried[0] - before[0], carried[1] - before[1], carried[2] - before[2]
    fall = dot(n, way) - duration * dot(n, v)
    return max(depth - max(fall, 0.0), 0.0)
