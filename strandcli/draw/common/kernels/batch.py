"""Rows of a batch of vertices that are lit together.

W numbers a row, all in one array: a compiler that knows how far apart they are need not fear that they overlap.
"""

from __future__ import annotations

from ....constants import W

CHANNELS = 24
"""Of a node of the tables of dual scattering (`strandcli.draw.fibre.kernels.dual`)."""

# Position, tangent, direction to the eye, colour, absorption beyond the tables', radiance; then of one light the
# direction to it, its distance, what of it arrives, the place in a map with its texels or in a table with weights,
# strands that it passed and that it would still meet; at last the radiance as it was before.
X, Y, Z, TX, TY, TZ, EX, EY, EZ = (i * W for i in range(9))
COLOUR, EXTRA, RADIANCE = 9 * W, 12 * W, 15 * W
LX, LY, LZ, REACH, ARRIVES = (i * W for i in range(18, 23))
U, V, DEPTH, INSIDE = (i * W for i in range(23, 27))
TEXELS = 27 * W
R, TT, TRT, REST = (TEXELS + i * W for i in range(4))
PASSED, WHOLE, LEFT = 35 * W, 36 * W, 37 * W
SIN_L, COS_L, SIN_V, COS_V, COS_PHI, PLACE = (i * W for i in range(38, 44))
TABLE = 44 * W
BEFORE = (44 + CHANNELS) * W
ROWS = 47 + CHANNELS
