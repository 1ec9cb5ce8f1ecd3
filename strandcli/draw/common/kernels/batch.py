"""Rows of a batch of W vertices that are shaded together; those with a lifetime for `surfaces` also serve W points of a
solid.

Each name is the offset of a row of W numbers, or of the first of consecutive rows, in one float32 array. Rows are at
constant offsets, so the compiler knows that they do not overlap; quantities that are never live together share rows.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ....constants import W
from ....jit import inlined


class RowAllocator:
    """Allocates the rows of one scratch array.

    ``stages``: for each user of the layout, the names of its stages in order. A user is a group of kernels; two users
    never work on one array at the same time, so their lifetimes are independent. Where stages run in a loop, a quantity
    that is carried from one turn to the next lives from the first stage of the loop to the last.
    """

    def __init__(self, **stages: Sequence[str]) -> None:
        self._stages: Mapping[str, Sequence[str]] = stages
        self._taken: set[tuple[int, str, str]] = set()
        """Row, user and stage."""

    def allocate(self, count: int = 1, **lifetime: str) -> tuple[int, ...]:
        """Return the offsets, in numbers, of the first ``count`` consecutive rows that are free for a quantity.

        ``lifetime``: for each user that needs the quantity a stage, or the first and the last one as "light:shade".
        """
        live: set[tuple[str, str]] = set()
        for user, named in lifetime.items():
            (begin, _, end), order = named.partition(":"), self._stages[user]
            live |= {(user, stage) for stage in order[order.index(begin) : order.index(end or begin) + 1]}
        first = 0
        while any((row, *one) in self._taken for row in range(first, first + count) for one in live):
            first += 1
        self._taken |= {(row, *one) for row in range(first, first + count) for one in live}
        return tuple(W * row for row in range(first, first + count))

    def row_count(self, user: str) -> int:
        """Return the number of rows that a user's array needs."""
        return 1 + max(row for row, who, _ in self._taken if who == user)


layout = RowAllocator(
    # "light" to "darken" run once for each light; "soft": shadows of solids in lights with a size
    strands=("gather", "ambient", "light", "soft", "maps", "dual", "highlights", "darken", "out"),
    surfaces=("gather", "ambient", "light", "soft", "maps", "reflect", "out"),
)
# Of each point: sine of the light's angular radius, sine of the least angle between the light's centre and a solid's
# silhouette, and whether the current solid can shade it.
RADIUS, LEAST, ASKED = layout.allocate(3, strands="soft", surfaces="soft")

CHANNELS = 24
"""Channels of a node of the dual scattering tables (`strandcli.draw.fibre.kernels.dual`)."""

# Position, metres; unit tangent; unit direction to the eye.
X, Y, Z = layout.allocate(3, strands="gather:out", surfaces="gather:out")
TX, TY, TZ = layout.allocate(3, strands="gather:out")
EX, EY, EZ = layout.allocate(3, strands="gather:out", surfaces="ambient:out")
# Red, green and blue of: colour of a mass of strands; absorption in addition to the tables', 1/radius; radiance.
COLOUR = layout.allocate(3, strands="gather:out")[0]
EXTRA = layout.allocate(3, strands="gather:out")[0]
RADIANCE = layout.allocate(3, strands="ambient:out", surfaces="ambient:out")[0]
# Of the current light: unit direction to it; its distance, metres; its falloff × visibility.
LX, LY, LZ = layout.allocate(3, strands="light:darken", surfaces="light:reflect")
REACH = layout.allocate(strands="light:darken", surfaces="light:reflect")[0]
ARRIVES = layout.allocate(strands="light:darken", surfaces="light:reflect")[0]
# Position in a shadow map, texels, and depth there, metres; INSIDE: 1 in this map, −1 in an earlier one, else 0.
INSIDE = layout.allocate(strands="light:maps", surfaces="light:maps")[0]
U, V = layout.allocate(2, strands="maps", surfaces="maps")
DEPTH = layout.allocate(strands="maps", surfaces="maps")[0]
# Eight numbers of the texels around a vertex, or results from opacity maps.
TEXELS = layout.allocate(8, strands="maps", surfaces="maps")[0]
# Optical depth of the strands in front of a vertex and behind it; falloff × visibility without strands.
PASSED, LEFT = layout.allocate(2, strands="maps:dual")
UNBLOCKED = layout.allocate(strands="maps:dual")[0]
# Dual scattering: angles, position in the tables, one node of them, and the two longitudinal lobes.
SIN_L, COS_L, SIN_V, COS_V, COS_PHI, PLACE = layout.allocate(6, strands="dual")
TABLE = layout.allocate(CHANNELS, strands="dual")[0]
RETURNED, FORWARD = layout.allocate(2, strands="dual")
# Highlights: position in the azimuthal tables, and the weights of their entries.
NODE_X, NODE_Y = layout.allocate(2, strands="highlights")
R, TT, TRT, REST = layout.allocate(4, strands="highlights")
# Radiance before a light contribution was added.
BEFORE = layout.allocate(3, strands="dual:darken")[0]

ROWS = layout.row_count("strands")
"""Rows of the array of a batch of vertices."""


@inlined
def vector_at(work, row, k):
    """Return the three numbers of item k of a batch that stand in consecutive rows from `row` on."""
    return work[row + k], work[row + W + k], work[row + 2 * W + k]


@inlined
def set_vector(work, row, k, vector):
    """Store three numbers of item k of a batch in consecutive rows from `row` on."""
    work[row + k], work[row + W + k], work[row + 2 * W + k] = vector
