"""Columns of the box and the cells of ambient occlusion."""

# The box, float32: centre of the first cell, cells a metre, and number of cells, along x, y and z.
MIDDLE_X, MIDDLE_Y, MIDDLE_Z = 0, 1, 2
PER_METRE_X, PER_METRE_Y, PER_METRE_Z = 3, 4, 5
COUNT_X, COUNT_Y, COUNT_Z = 6, 7, 8
FADE = 9
"""Distance from the box, metres, at which occlusion has fallen to a fourth."""
BOX_SIZE = 10

DENSITY = 0
"""ρ of a cell: Σ width · length / volume, 1/m."""
XX, XY, XZ, YY, YZ, ZZ = 1, 2, 3, 4, 5, 6
"""M of a cell: the same sum over t tᵀ of the unit directions t, 1/m."""
CHANNELS = 7

MEAN, SLOPE_X, SLOPE_Y, SLOPE_Z = range(4)
"""v₀ and v of the linear fit of a cell's visibility."""
