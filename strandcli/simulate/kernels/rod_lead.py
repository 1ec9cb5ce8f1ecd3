"""Where motion leads the edges of a strand in a step, and which steps' rest shapes are set by such edges.

Rest shapes are forces that the matrix of a step knows nothing of. Edges before the step are too late for BDF2, and
those after it take another iteration; those that a strand has when it goes on as it moves are as good as these, to the
second order.
"""

from __future__ import annotations

from ...jit import device, inlined
from ...simd import any_lane, broadcast, load, load3, sqrt, where
from .rod_frames import NEARLY
from .rod_scratch import AXES, INVERSE_LENGTH, MOVED_SHARE, PACK, ROOT_SHIFT
from .rod_tension import TINY

GREATEST_TURN = 1.0
"""Tangent of the angle that an edge is led by at the most."""
LEAD = 0.8
"""Share of the way to the edges by which rests are set that follows velocities, not the last step. By velocities alone
motion keeps its amplitude best, but curls gain energy; with half of it they lose twice as much."""


@device
def way_of(s, at, forcing, scheme):
    """Factors of velocities and of last displacements in how far particles go on, in segments; and how far the root
    comes in this step.

    By BDF2 particles move on as in the step before; a share `LEAD` of the way is that of their velocities. Lanes that
    go by Euler's method stay.
    """
    lead = broadcast(s, LEAD)
    on = load(s, INVERSE_LENGTH) * load(forcing.led, at.strand) * (3.0 * load(s, MOVED_SHARE))
    x, y, z = load3(s, ROOT_SHIFT, 1)
    return (on * scheme.duration * lead, on * (1.0 - lead)), (on * x, on * y, on * z)


@inlined
def led_edge(at, j, state, way, last, rounding):
    """Edge j of a strand that goes on as it moves, of unit length, and how far its end comes. ``way``: of `way_of`;
    ``last``: how far its beginning comes."""
    far, near = way
    row = at.edge + j * AXES
    u, v, w = load3(state.velocity, row, PACK)
    x, y, z = load3(state.moved, row, PACK)
    u, v, w = far * u + near * x, far * v + near * y, far * w + near * z
    x, y, z = load3(state.edges, row, PACK)
    px, py, pz = last
    return turned(x, y, z, u - px, v - py, w - pz, rounding), (u, v, w)


@inlined
def turned(x, y, z, u, v, w, rounding):
    """The direction of an edge after a change (u, v, w), of which no more than `GREATEST_TURN` counts."""
    q = u * u + v * v + w * w
    far = q > GREATEST_TURN * GREATEST_TURN
    if any_lane(far):
        f = where(far, GREATEST_TURN / sqrt(max(q, TINY)), 1.0)
        u, v, w = f * u, f * v, f * w
    moved = q > 4.0 * rounding * rounding
    x, y, z = x + where(moved, u, 0.0), y + where(moved, v, 0.0), z + where(moved, w, 0.0)
    q = x * x + y * y + z * z
    off = abs(q - 1.0)
    f = where(off < rounding, 1.0, 1.5 - 0.5 * q)  # rounded anew, strands at rest would move
    far = off > NEARLY
    if any_lane(far):
        f = where(far, 1.0 / sqrt(max(q, TINY)), f)
    return f * x, f * y, f * z
