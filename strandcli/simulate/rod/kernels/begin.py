"""The begin of a rod's step: coefficients, roots, and u* of each particle."""

from __future__ import annotations

from ....constants import W
from ....jit import device, inlined
from ....jit.indices import FIRST, SECOND, THIRD
from ....simd import load, load3, no_fma, store, store3, where
from ....simd.vectors import add_scaled, less, scaled, sum_of
from .arrays import AXES, PACK, ROW, Coefficients

BLEND = 0.8
"""θ: share of BDF3 in the difference formula of velocities, the rest is BDF2; stable at any step (Park 1975)."""
VELOCITY_RATE = 1.5 + BLEND / 3
"""Δt over the h of velocities."""
GAIN = (0.5 + 2 * BLEND / 3) / VELOCITY_RATE
OLD_GAIN = BLEND / 3 / VELOCITY_RATE
"""Shares of the last change of velocity that v̂ goes on by, and of the one before it that it stays behind by."""
FARTHEST = 1e10
"""Segments that a free particle moves in a step at the most."""


@device
def coefficients_of(at, state, material, drive, step, needs, parts, frame):
    """`Coefficients` of a step, or of one of its ``parts`` by Euler's method where there are several. ``frame``: the
    velocity of the frame in which strands move, m/s."""
    one = load(material.lengths, at.strand)
    length, zero = one, one * 0.0
    duration = step.duration / parts
    h, g, moved_share = zero + duration, zero + duration, zero
    if step.bdf2 and parts == 1:
        euler = load(state.restart, at.strand) > 0.0
        h = where(euler, h, duration * (2.0 / 3.0))
        g = where(euler, g, duration / VELOCITY_RATE)
        moved_share = where(euler, zero, 1.0 / 3.0)
    push_step = push_change = zero + duration
    if needs.lasting and step.bdf2:
        push_step, push_change = g, where(moved_share > 0.0, zero, push_change)
    drag = 1.0 + step.drag * g
    reach = h * g / drag
    inverse_length = 1.0 / length
    air = step.drag * load(drive.gust, at.strand)
    moving = step.drag * frame[0], step.drag * frame[1], step.drag * frame[2]
    damping = step.damping / duration
    return Coefficients(
        length, inverse_length, h / drag * inverse_length, reach,
        (g * (step.gravity[0] + air * step.air[0] - moving[0]), g * (step.gravity[1] + air * step.air[1] - moving[1]),
         g * (step.gravity[2] + air * step.air[2] - moving[2])),
        load(material.stiffness, at.strand) * reach * (1.0 + damping), damping / (1.0 + damping), moved_share,
        push_step, push_change, 1.0 / h, duration,
    )  # fmt: skip


@device
def rotated(turn, x, y, z):
    """A vector turned by a matrix (9), rounded as NumPy rounds it."""
    return (
        no_fma(turn[0] * x) + no_fma(turn[1] * y) + no_fma(turn[2] * z),
        no_fma(turn[3] * x) + no_fma(turn[4] * y) + no_fma(turn[5] * z),
        no_fma(turn[6] * x) + no_fma(turn[7] * y) + no_fma(turn[8] * z),
    )


@device
def place_root(s, at, state, drive, step, deforming):
    """Set the root's position and the clamped direction, as the edge before the first; return the displacement of the
    root in this step, metres."""
    x, y, z = load3(drive.roots, at.root, PACK)
    there = sum_of(rotated(step.rotation, x, y, z), step.translation)
    store3(state.positions, at.position + ROW, W, there[0], there[1], there[2])
    moved = sum_of(rotated(step.turned, x, y, z), step.shifted)
    if deforming:
        moved = sum_of(moved, load3(drive.drift, at.root, PACK))
    x, y, z = load3(drive.directions, at.root, PACK)
    x, y, z = rotated(step.rotation, x, y, z)
    store3(s.edge, -3, 1, x, y, z)
    return moved


@device
def begin(s, at, state, needs, c, shift):
    """Write a step's begin to the scratch: edges where the root alone has moved, by ``shift`` metres, u*, τ, and
    what damping adds to c̄: it pulls each joint toward the bend that it had, κ being
    multiplied by 1 + δ/Δt and κ c̄ greater by δ/Δt κ c."""
    before = load3(s.edge, -3, 1)
    for j in range(at.segments):
        row = at.edge + j * AXES
        store(s.tension, j, load(state.tension, at.number + j * PACK) * c.reach)
        edge = load3(state.edges, row, PACK)
        x, y, z = add_scaled(edge, -c.inverse_length, shift) if j == 0 else edge
        store3(s.edge, 3 * j, 1, x, y, z)
        x, y, z = scaled(c.damped, less(edge, before))
        store3(s.damped, 3 * j, 1, x, y, z)
        store3(s.rest, 3 * j, 1, x, y, z)
        before = edge
        x, y, z = (
            predict(state, needs, c, row, FIRST), predict(state, needs, c, row, SECOND),
            predict(state, needs, c, row, THIRD),
        )  # fmt: skip
        store3(s.free, 3 * j, 1, x, y, z)
        store3(s.inertial, 3 * j, 1, x, y, z)


@inlined
def predict(state, needs, c, row, k):
    """Coordinate k of the free displacement of a particle in segments, at most `FARTHEST`.

    BDF2 is an Euler step of h = 2/3 Δt from extrapolated values: x̂ = x_n + (x_n − x_{n−1}) / 3, and v̂, which the step
    before has left (`finish.set_velocity`)."""
    place = row + k * PACK
    v = where(c.moved_share > 0.0, load(state.ahead, place), load(state.velocity, place)) + c.added[k]
    if needs.pushed:
        v += c.push_step * load(state.acceleration, place)
    u = c.velocity_scale * v + load(state.moved, place) * c.moved_share * c.inverse_length
    return min(max(u, -FARTHEST), FARTHEST)


@device
def aim_tip(s, at, drive, c, parts, shift):
    """Have the pinned tip go where it is to be at the end of a step, or of the first of so many ``parts``, in a frame
    that has moved by a ``shift``, metres."""
    x, y, z = scaled(c.inverse_length / parts, less(load3(drive.tips, at.root, PACK), shift))
    last = 3 * (at.segments - 1)
    store3(s.free, last, 1, x, y, z)
    store3(s.inertial, last, 1, x, y, z)
