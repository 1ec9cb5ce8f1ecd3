"""Rows of a batch of W vertices that are shaded together; those with a lifetime for `surfaces` also serve W points of a
solid.

Each name is the offset of a row of W numbers, or of the first of consecutive rows, in one float32 array.
"""

from __future__ import annotations

from ....constants import W
from ..rows import RowAllocator

layout = RowAllocator(
    W,
    {
        # "light" to "darken" run once for each light; "soft": shadows of solids in lights with a size
        "strands": ("gather", "ambient", "light", "soft", "maps", "dual", "highlights", "darken", "out"),
        "surfaces": ("gather", "ambient", "light", "soft", "maps", "reflect", "out"),
    },
)
# Of each point: sine of the light's angular radius, sine of the least angle between the light's centre and a solid's
# silhouette, and whether the current solid can shade it.
RADIUS, LEAST, ASKED = layout.allocate("soft shadow", 3, strands="soft", surfaces="soft")
# Of each listed point: its number, the vector to the beginning of the solid's axis, direction and distance of the
# light; and of the search along the axis the ends, the two places between, and the values there. Compaction moves all
# of these rows together.
LIST, WX, WY, WZ, DX, DY, DZ, END = layout.allocate("listed points", 8, strands="soft", surfaces="soft")
LOW, HIGH, NEAR, FAR, AT_NEAR, AT_FAR = layout.allocate("search along an axis", 6, strands="soft", surfaces="soft")

CHANNELS = 24
"""Channels of a node of the dual scattering tables (`strandcli.draw.fibre.kernels.dual`)."""

# Position, metres; unit tangent; unit direction to the eye.
X, Y, Z = layout.allocate("position", 3, strands="gather:out", surfaces="gather:out")
TX, TY, TZ = layout.allocate("tangent", 3, strands="gather:out")
EX, EY, EZ = layout.allocate("eye", 3, strands="gather:out", surfaces="ambient:out")
# Red, green and blue of: colour of a mass of strands; absorption in addition to the tables', 1/radius; radiance.
COLOUR = layout.allocate("colour", 3, strands="gather:out")[0]
EXTRA = layout.allocate("extra absorption", 3, strands="gather:out")[0]
RADIANCE = layout.allocate("radiance", 3, strands="ambient:out", surfaces="ambient:out")[0]
# Of the current light: unit direction to it; its distance, metres; its falloff × visibility.
LX, LY, LZ = layout.allocate("light", 3, strands="light:darken", surfaces="light:reflect")
REACH = layout.allocate_row("distance of the light", strands="light:darken", surfaces="light:reflect")
ARRIVES = layout.allocate_row("what arrives", strands="light:darken", surfaces="light:reflect")
# Position in a shadow map, texels, and depth there, metres; INSIDE: 1 in this map, −1 in an earlier one, else 0.
INSIDE = layout.allocate_row("inside of a map", strands="light:maps", surfaces="light:maps")
U, V = layout.allocate("place in a map", 2, strands="maps", surfaces="maps")
DEPTH = layout.allocate_row("depth in a map", strands="maps", surfaces="maps")
# Eight numbers of the texels around a vertex, or results from opacity maps.
TEXELS = layout.allocate("texels", 8, strands="maps", surfaces="maps")[0]
# Optical depth of the strands in front of a vertex and behind it; falloff × visibility without strands.
PASSED, LEFT = layout.allocate("strands before and behind", 2, strands="maps:dual")
UNBLOCKED = layout.allocate_row("what arrives without strands", strands="maps:dual")
# Dual scattering: angles, position in the tables, one node of them, and the two longitudinal lobes.
SIN_L, COS_L, SIN_V, COS_V, COS_PHI, PLACE = layout.allocate("angles", 6, strands="dual")
TABLE = layout.allocate("node of dual scattering", CHANNELS, strands="dual")[0]
RETURNED, FORWARD = layout.allocate("lobes of dual scattering", 2, strands="dual")
# Highlights: position in the azimuthal tables, and the weights of their entries.
NODE_X, NODE_Y = layout.allocate("place in azimuthal tables", 2, strands="highlights")
R, TT, TRT, REST = layout.allocate("longitudinal lobes", 4, strands="highlights")
# Radiance before a light contribution was added.
BEFORE = layout.allocate("radiance before", 3, strands="dual:darken")[0]

ROWS = layout.row_count("strands")
"""Rows of the array of a batch of vertices."""
