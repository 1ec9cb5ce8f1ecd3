"""Scratch of a rod's step: vectors, one lane a strand, of a vector of strands and of each of their segments.

Lengths are in segments (rest length ℓ), masses relative. Rows are numbered as segments are; rows −1 and N of what the
recurrences read there stay zeros, or the clamped direction.
"""

from __future__ import annotations

from itertools import accumulate
from typing import Any, NamedTuple

from numba.core import types
from numba.core.extending import intrinsic

from ....simd.kinds import PointerType, vector_of


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
    """(24) state of the segment when the step began, for a step in parts; as `parts.copy` has it."""
    best: Any
    """(24) the same of the best step so far."""
    mean: Any
    """(4) means of the force of contact and of the tension in these parts."""


SIZES = Scratch(
    3, 3, 3, 3, 3, 3, 1, 1, 1, 1, 1, 3, 3, 4, 3, 1, 1, 1, 1, 3, 3, 1, 1, 1, 3, 3, 1, 1, 3, 1, 1, 1, 2, 3, 3, 18,
    24, 24, 4,
)  # fmt: skip
"""Vectors of a segment."""
FIRSTS = tuple(accumulate(SIZES, initial=0))[:-1]
"""And of those before it."""
BEFORE, AFTER = 1, 2
"""Rows before the first segment and after the last one."""
ALL = sum(SIZES)


def vectors_for(n: int) -> int:
    """Vectors of scratch for ``n`` segments; all begin as zeros."""
    return ALL * (n + BEFORE + AFTER)


@intrinsic
def scratch_at(typingctx: Any, base: Any, n: Any) -> Any:
    """The `Scratch` of ``n`` segments that begins at a pointer to vectors: of each field a pointer to its first vector
    of segment 0, which lies behind all rows of the fields before it."""
    if not (isinstance(base, PointerType) and base.whole):
        return None

    def emit(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        word = args[1].type
        start = builder.bitcast(args[0], context.get_value_type(vector_of(base)).as_pointer())
        rows = builder.add(args[1], word(BEFORE + AFTER))
        firsts = [
            builder.add(builder.mul(rows, word(first)), word(BEFORE * size))
            for first, size in zip(FIRSTS, SIZES, strict=True)
        ]
        fields = [builder.bitcast(builder.gep(start, [first]), args[0].type) for first in firsts]
        return context.make_tuple(builder, sig.return_type, fields)

    return types.NamedUniTuple(base, len(SIZES), Scratch)(base, n), emit
