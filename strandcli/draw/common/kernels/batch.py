"""Rows of a batch of W vertices that are shaded together, and those that a batch of a solid's points shares with it.

Each name is the offset of a row of W numbers, or of the first of neighbouring rows, in one float32 array.
"""

from __future__ import annotations

from . import soft_rows  # noqa: F401  rows are handed out in one order, whoever is imported first
from .layout import layout

CHANNELS = 24
"""Of a node of the tables of dual scattering (`strandcli.draw.fibre.kernels.dual`)."""

# Position in metres, unit tangent, unit direction to the eye.
X, Y, Z = layout.take("position", 3, strands="gather:out", surfaces="gather:out")
TX, TY, TZ = layout.take("tangent", 3, strands="gather:out")
EX, EY, EZ = layout.take("eye", 3, strands="gather:out", surfaces="ambient:out")
# In red, green and blue: colour of a mass, absorption beyond the tables' in 1/radius, radiance.
COLOUR = layout.take("colour", 3, strands="gather:out")[0]
EXTRA = layout.take("extra absorption", 3, strands="gather:out")[0]
RADIANCE = layout.take("radiance", 3, strands="ambient:out", surfaces="ambient:out")[0]
# Of one light: unit direction to it, its distance, and what of it arrives.
LX, LY, LZ = layout.take("light", 3, strands="light:darken", surfaces="light:reflect")
REACH = layout.one("distance of the light", strands="light:darken", surfaces="light:reflect")
ARRIVES = layout.one("what arrives", strands="light:darken", surfaces="light:reflect")
# Place in a shadow map, texels, and the depth there; 1 inside of the map, −1 inside of one before it.
INSIDE = layout.one("inside of a map", strands="light:maps", surfaces="light:maps")
U, V = layout.take("place in a map", 2, strands="maps", surfaces="maps")
DEPTH = layout.one("depth in a map", strands="maps", surfaces="maps")
# Of a map: eight numbers of the texels about a vertex, or what opacity maps tell.
TEXELS = layout.take("texels", 8, strands="maps")[0]
# Strands in front of a vertex and behind it; what arrives where no strand is in the way.
PASSED, LEFT = layout.take("strands before and behind", 2, strands="maps:dual")
UNBLOCKED = layout.one("what arrives without strands", strands="maps:dual")
# Dual scattering: angles, the place in its tables, a node of them, and its two longitudinal lobes.
SIN_L, COS_L, SIN_V, COS_V, COS_PHI, PLACE = layout.take("angles", 6, strands="dual")
TABLE = layout.take("node of dual scattering", CHANNELS, strands="dual")[0]
RETURNED, FORWARD = layout.take("lobes of dual scattering", 2, strands="dual")
# Highlights: the place in the azimuthal tables, and weights of what they hold.
NODE_X, NODE_Y = layout.take("place in azimuthal tables", 2, strands="highlights")
R, TT, TRT, REST = layout.take("longitudinal lobes", 4, strands="highlights")
# Radiance as it was before light of one kind was added, and that light in one channel.
BEFORE = layout.take("radiance before", 3, strands="dual:darken")[0]
ADDED = layout.one("radiance added", strands="darken")

ROWS = layout.count("strands")
"""Rows of a batch of vertices."""
