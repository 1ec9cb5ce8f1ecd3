"""Columns of the lights as kernels read them: (lights, 16) float32, a row a light, packed by `pack_lights`."""

KIND = 0
"""0: directional, 1: point."""
PLACE_X, PLACE_Y, PLACE_Z = 1, 2, 3
"""Unit direction to a directional light; position of a point light, metres."""
POWER_R, POWER_G, POWER_B = 4, 5, 6
"""Irradiance of a directional light; intensity of a point light, W/sr."""
FIRST_MAP, MAP_COUNT = 7, 8
"""Number of the light's first shadow map, and how many it has."""
BIAS = 9
"""Depth bias of shadow maps, metres."""
MAP_LAYERS = 10
"""Layers of the light's opacity maps; 0: it has min/max maps."""
CLEAR_ROW = 11
"""0, or 1 + the row of `clear` with the light's visibility at marked vertices."""
LIGHT_SIZE = 12
"""Sine of the angular radius of a directional light; radius of a point light, metres."""
STRAND_WIDTH = 13
"""Mean width of strands, metres."""
PER_FALL = 14
"""1 / h of opacity maps (`strandcli.draw.shadows.kernels.opacity`), 1/m."""
COLUMNS = 16
