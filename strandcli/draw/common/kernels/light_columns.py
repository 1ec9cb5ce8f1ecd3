"""Columns of the lights as kernels read them: (lights, 16) float32, a row a light, packed by `pack_lights`."""

KIND = 0
"""0 directional, 1 point."""
PLACE_X, PLACE_Y, PLACE_Z = 1, 2, 3
"""Unit direction to a directional light; position of a point light, metres."""
POWER_R, POWER_G, POWER_B = 4, 5, 6
"""Irradiance of a directional light; intensity of a point light, W/sr."""
FIRST_MAP, MAP_COUNT = 7, 8
"""The light's shadow maps."""
BIAS = 9
"""Depth in front of which a map shades nothing, metres."""
MAP_LAYERS = 10
"""Layers of its opacity maps; 0 for min/max maps."""
CLEAR_ROW = 11
"""0, or one more than the row of `clear` that tells exactly what strands leave of the light at marked vertices."""
LIGHT_SIZE = 12
"""Sine of the angular radius of a directional light; radius of a point light, metres."""
STRAND_WIDTH = 13
"""Mean width of strands, metres."""
PER_FALL = 14
"""1 / h of opacity maps (`strandcli.draw.shadows.kernels.opacity`), 1/m."""
COLUMNS = 16
