"""Columns of the grid of ambient occlusion as kernels read it."""

# Of the box, float32: the middle of the first cell, cells a metre along x, y and z, and cells along each.
MIDDLE_X, MIDDLE_Y, MIDDLE_Z = 0, 1, 2
PER_METRE_X, PER_METRE_Y, PER_METRE_Z = 3, 4, 5
COUNT_X, COUNT_Y, COUNT_Z = 6, 7, 8
FADE = 9
"""Metres beyond the box over which occlusion falls to a fourth."""
BOX_SIZE = 10

DENSITY = 0
"""Of a cell: ρ, projected width of strands a metre,"""
XX, XY, XZ, YY, YZ, ZZ = 1, 2, 3, 4, 5, 6
"""and M, the same sum over the squares of their directions."""
CHANNELS = 7
