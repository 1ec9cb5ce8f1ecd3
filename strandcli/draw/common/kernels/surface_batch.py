"""Rows of a batch of W points of one solid that are shaded together, in addition to those of `batch`."""

from __future__ import annotations

from .batch import layout

# Unit normal; position on the screen, and distance along the ray; width of a pixel there, metres; the point's share of
# its pixel.
NX, NY, NZ = layout.allocate("normal", 3, surfaces="ambient:out")
SX, SY, DISTANCE = layout.allocate("place on the screen", 3, surfaces="gather:ambient")
PIXEL = layout.allocate_row("width of a pixel", surfaces="ambient")
THERE = layout.allocate_row("share of the picture", surfaces="ambient:out")
# Noise of a pixel, in 8-bit levels.
NOISE = layout.allocate_row("noise of a pixel", surfaces="out")
# Light that a coat reflects, red, green and blue; its transmittance.
COAT = layout.allocate("light of the coat", 3, surfaces="ambient:out")[0]
UNDER = layout.allocate_row("share under the coat", surfaces="ambient:out")
# Where shadow rays begin, from the point, and the colour: of solids that have a look of their own, else 0 and theirs.
LIFT = layout.allocate("lift of the point", 3, surfaces="ambient:out")[0]
ALBEDO = layout.allocate("colour of the surface", 3, surfaces="ambient:out")[0]
# Of the current light: position of the point itself, because `X` is offset above the surface; cosine of incidence; unit
# direction to it, where shadow rays take another; and in red, green and blue the transmittance of strands and the
# irradiance.
PX = layout.allocate("place on the surface", 3, surfaces="light:soft")[0]
COSINE = layout.allocate_row("cosine", surfaces="light:reflect")
TRUE_X, TRUE_Y, TRUE_Z = layout.allocate("light, unbent", 3, surfaces="light:soft")
LEFT = layout.allocate("share that strands leave", 3, surfaces="maps:reflect")[0]
ARRIVED = layout.allocate("light that arrived", 3, surfaces="reflect")[0]
# Filter window of a point in a map: radius, texels, and its inverse; first and last column and row; sums of the weights
# and of the light lost in red, green and blue.
RADIUS, PER, FIRST_U, LAST_U, FIRST_V, LAST_V, TOTAL = layout.allocate("texels about a point", 7, surfaces="maps")
LOST = layout.allocate("light that is lost", 3, surfaces="maps")[0]
# Of one texel of the window: column, −1 outside of the map; row; weight; optical depth in front of the point; depths at
# which the strands of its cell begin and end; weight of the light that these scatter forward, and what the rest loses.
ACROSS, DOWN, WEIGHT, PASSED = layout.allocate("texel", 4, surfaces="maps")
FRONT, BACK, NEAR, OTHER = layout.allocate("strands of a texel", 4, surfaces="maps")
# Blur at a point: texels a metre of distance to the occluder; that distance where no texel gives one; weight of light
# that is scattered forward; distance between the texels that are read, and how far every other one has faded out.
BLUR, AWAY, CLOUD, STRIDE, FADE = layout.allocate("blur of a point", 5, surfaces="maps")

ROWS = layout.row_count("surfaces")
"""Rows of the array of a batch of points."""
