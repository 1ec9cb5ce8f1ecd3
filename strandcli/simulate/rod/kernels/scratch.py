"""Scratch of a rod's step: vectors, one lane a strand, of a vector of strands and of each of their segments.

Lengths are in segments (rest length ℓ), masses relative. Rows are numbered as segments are; rows −1 and N of what the
recurrences read there stay zeros, or the clamped direction.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from ....jit import device
from ....simd import shifted


class Scratch(NamedTuple):
    """Pointers to vectors; (k) of each segment. All are scratch: a step begins with what `begin` writes."""

    edge: Any
    """(3) e_j, of unit length at the end of a step; row −1 is the clamped direction."""
    free: Any
    """(3) u*_j, the displacement of a particle by its momentum, loads and contact alone."""
    inertial: Any
    """(3) u*_j − u_j, what is left of that: the inertial residual over the mass."""
    rest: Any
    """(3) c̄_j."""
    damped: Any
    """(3) what damping adds to c̄_j."""
    load: Any
    """(3) g_j, what loads alone change of the edge."""
    tension: Any
    """Force density τ_j."""
    pivot: Any
    """i_j of the elimination."""
    edge_factor: Any
    """i_j κ_j, by which z_j follows z_{j−1}."""
    particle_factor: Any
    """i_j B_j, by which z_j opposes y_{j−1}."""
    innovation: Any
    """The filter's innovation over its variance."""
    particle_gain: Any
    """(3) Kalman gain of the next particle."""
    edge_gain: Any
    """(3) Kalman gain of the next edge."""
    firm: Any
    """(4) σ ê_j and σ, which keep edges of curled strands near the last iterate."""
    target: Any
    """(3) what of a rest vector is across the edge before it, by the last twist."""
    twist: Any
    """ψ_{j−1} of the last iterate."""
    twist_offset: Any
    """a of ψ_{j−1} = a + b ψ_j, from the elimination of twist."""
    twist_factor: Any
    """b of that."""
    fold: Any
    """1 / (1 + e_{j−1}·e_j)."""
    force: Any
    """(3) force of a solid on the segment, in units of mass times segments; row N is not used."""
    normal: Any
    """(3) unit normal of the solid there."""
    gap: Any
    """Distance from it, negative inside."""
    share: Any
    """Where on the segment, 1 at its end."""
    active: Any
    """1 where the force is one of contact, else 0."""
    slip: Any
    """(3) by how much the place has moved on the solid in this step."""
    across: Any
    """(3) unit vector across the normal; in a corner toward the second solid."""
    corner: Any
    """1 where a second solid touches the place, too, else 0."""
    second_gap: Any
    """Distance from the next solid, metres."""
    second_normal: Any
    """(3)"""
    place: Any
    """Where on the segment the solid is nearest."""
    nearer: Any
    """1 where the solid that was considered last is the nearest."""
    mobility: Any
    """Of the place across the normal, by the last iteration."""
    compliance: Any
    """(2) R of Coulomb's cone along both tangents."""
    wanted: Any
    """(3) residuals along the normal and both tangents."""
    contact_innovation: Any
    """(3) as ``innovation``: along the normal and both tangents."""
    contact_gain: Any
    """(18) Kalman gains of the segment's own particle and edge, three observations."""
    begun: Any
    """(24) state of the segment when the step began, for a step in parts; as `parts.keep` has it."""
    best: Any
    """(24) the same of the best step so far."""
    mean: Any
    """(4) means of the force of contact and of the tension in these parts."""


SIZES = Scratch(
    3, 3, 3, 3, 3, 3, 1, 1, 1, 1, 1, 3, 3, 4, 3, 1, 1, 1, 1, 3, 3, 1, 1, 1, 3, 3, 1, 1, 3, 1, 1, 1, 2, 3, 3, 18,
    24, 24, 4,
)  # fmt: skip
"""Vectors of a segment."""
BEFORE, AFTER = 1, 2
"""Rows before the first segment and after the last one."""
ALL = sum(SIZES)


def vectors_for(n: int) -> int:
    """Vectors of scratch for ``n`` segments; all begin as zeros."""
    return ALL * (n + BEFORE + AFTER)


@device
def scratch_at(base, n):
    """The `Scratch` of ``n`` segments that begins at a pointer to vectors."""
    rows = n + BEFORE + AFTER
    return Scratch(
        part(base, 0, rows, 3), part(base, 3, rows, 3), part(base, 6, rows, 3), part(base, 9, rows, 3),
        part(base, 12, rows, 3), part(base, 15, rows, 3), part(base, 18, rows, 1), part(base, 19, rows, 1),
        part(base, 20, rows, 1), part(base, 21, rows, 1), part(base, 22, rows, 1), part(base, 23, rows, 3),
        part(base, 26, rows, 3), part(base, 29, rows, 4), part(base, 33, rows, 3), part(base, 36, rows, 1),
        part(base, 37, rows, 1), part(base, 38, rows, 1), part(base, 39, rows, 1), part(base, 40, rows, 3),
        part(base, 43, rows, 3), part(base, 46, rows, 1), part(base, 47, rows, 1), part(base, 48, rows, 1),
        part(base, 49, rows, 3), part(base, 52, rows, 3), part(base, 55, rows, 1), part(base, 56, rows, 1),
        part(base, 57, rows, 3), part(base, 60, rows, 1), part(base, 61, rows, 1), part(base, 62, rows, 1),
        part(base, 63, rows, 2), part(base, 65, rows, 3), part(base, 68, rows, 3), part(base, 71, rows, 18),
        part(base, 89, rows, 24), part(base, 113, rows, 24), part(base, 137, rows, 4),
    )  # fmt: skip


@device
def part(base, first, rows, size):
    """The vectors of a field whose ``size`` is so many a segment and which begins after ``first`` a segment of others:
    pointer to those of segment 0."""
    return shifted(base, first * rows + BEFORE * size)
