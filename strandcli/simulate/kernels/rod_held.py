"""Tips that are clamped: the joint between a strand's last edge and the direction of its clamp, and its twist.

The clamp is an edge beyond the last one, whose direction is given. The joint between has twice the rigidity that others
have there, as the root's has, for the clamp is half a segment from the last edge's middle; so ends count to the second
order. As an end of the frames' twist the clamp has a given axis across its direction: ψ_N is the angle from the
transported frame to it, followed from step to step through whole turns, and to it comes by how much the tip is turned.
Compiled only where tips are clamped.
"""

from __future__ import annotations

from ...constants import FOLD
from ...jit import device
from ...simd import load, load3, sqrt, store, store3
from ...simd.turning import cosine_sine
from .records import DAMPING, STEP, TIP_JOINT, TURN
from .rod_scratch import AXES, EDGE, FIRST_SEGMENT, PACK, REST_BEND, SEGMENT, STIFFNESS, TENSION
from .rod_tension import TINY

# the segment after the last one has these, beside its EDGE and REST_BEND; factors and loads of it stay zeros
RIGIDITY = TENSION
"""κ h² of the tip's joint."""
TORQUE, ANGLE = 3, 4
"""Twist torque of the tip's joint over 1 + e·e'; ψ of the last edge."""
TURNS = 4
"""Iterations in which ψ_N is found: three thirds of a turn from where it was, to the last digit."""


@device
def place_clamp(s, at, state, material, forcing):
    """Set direction, rest and rigidity of the joint, and what damping adds to the rest by the last edge before the
    step."""
    o = FIRST_SEGMENT + at.segments * SEGMENT
    damping = forcing.numbers[DAMPING] / forcing.numbers[STEP]
    share = damping / (1 + damping)
    ex, ey, ez = load3(state.edges, at.edge + (at.segments - 1) * AXES, PACK)
    x, y, z = load3(forcing.tips, at.tip, PACK)
    store3(s, o + EDGE, 1, x, y, z)
    store3(s, o + REST_BEND, 1, share * (x - ex), share * (y - ey), share * (z - ez))
    store(s, o + RIGIDITY, load(s, STIFFNESS) * forcing.numbers[TIP_JOINT])


@device
def joint_beyond(s, n):
    """Rigidity κ of the tip's joint and its bend's force κ (c − c̄)."""
    o = FIRST_SEGMENT + n * SEGMENT
    k = load(s, o + RIGIDITY)
    x, y, z = load3(s, o + EDGE, 1)
    px, py, pz = load3(s, o - SEGMENT + EDGE, 1)
    cx, cy, cz = load3(s, o + REST_BEND, 1)
    return k, (k * (x - px - cx), k * (y - py - cy), k * (z - pz - cz))


@device
def energy_beyond(s, n):
    """Twice the energy of the tip's joint."""
    k, (x, y, z) = joint_beyond(s, n)
    return (x * x + y * y + z * z) / max(k, TINY)


@device
def turn_tip(s, at, state, forcing, rigid, frame, chain):
    """Set ψ of the tip, and of the last edge by the elimination's ``chain``: its a and b. ``frame``: the last edge and
    the transported normal; ``rigid``: torsional rigidity of the last joint before the tip's and of the tip's."""
    (tx, ty, tz), (ax, ay, az) = frame
    o = FIRST_SEGMENT + at.segments * SEGMENT
    dx, dy, dz = load3(s, o + EDGE, 1)
    rate = 1.0 / max(1.0 + tx * dx + ty * dy + tz * dz, 1e-6)
    f = rate * (ax * dx + ay * dy + az * dz)
    ax, ay, az = ax - f * (tx + dx), ay - f * (ty + dy), az - f * (tz + dz)
    f = 1.0 / sqrt(max(ax * ax + ay * ay + az * az, TINY))
    ax, ay, az = f * ax, f * ay, f * az
    ux, uy, uz = load3(forcing.tips, at.tip + AXES, PACK)
    x = ux * ax + uy * ay + uz * az
    y = ux * (dy * az - dz * ay) + uy * (dz * ax - dx * az) + uz * (dx * ay - dy * ax)
    angle = load(state.turned, at.strand)
    for _ in range(TURNS):
        c, d = cosine_sine(angle)
        # 2 tan(δ/2), and no more than 2, of the rest δ
        along, across = x * c + y * d, y * c - x * d
        angle += min(max(2.0 * across / max(1.0 + along, 1e-6), -2.0), 2.0)
    store(state.turned, at.strand, angle)
    angle += forcing.numbers[TURN]
    a, b = chain
    before, after = rigid
    over = 1.0 / (before * (1.0 - b) + after)
    now = (before * a + after * angle) * over
    last = at.tension + (at.segments - 1) * PACK
    store(state.twist, last, now)
    store(s, o + TORQUE, after * (now - angle) * min(rate, 1.0 / FOLD))
    store(s, o + ANGLE, now)


@device
def beyond(s, n):
    """The clamp's direction, the twist torque of its joint over 1 + e·e', and ψ of the last edge."""
    o = FIRST_SEGMENT + n * SEGMENT
    return load3(s, o + EDGE, 1), load(s, o + TORQUE), load(s, o + ANGLE)
