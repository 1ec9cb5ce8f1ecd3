"""Rows of a batch of W points of one solid that are shaded together, in addition to those of `batch`."""

from __future__ import annotations

from .batch import layout

# Unit normal; position on the screen, and distance along the ray; width of a pixel there, metres; the point's share of
# its pixel.
NX, NY, NZ = layout.allocate(3, surfaces="ambient:out")
SX, SY = layout.allocate(2, surfaces="gather:reflect")
DISTANCE = layout.allocate(surfaces="gather:ambient")[0]
PIXEL = layout.allocate(surfaces="ambient:out")[0]
THERE = layout.allocate(surfaces="ambient:out")[0]
# How much of a pixel's light is that of the point; distances along the rays of a pixel in which a solid has an edge in
# front of itself.
SHARE = layout.allocate(surfaces="gather:out")[0]
RAYS = layout.allocate(surfaces="gather")[0]
# A number that the look of a solid is looked for at (`strandcli.scene.model.solids.SolidShape.look`), or −1.
BEFORE = layout.allocate(surfaces="gather:ambient")[0]
# Width of a pixel on the surface, metres, and patches in [−1, 1].
ACROSS, TONE = layout.allocate(2, surfaces="ambient")
# Mirror direction of the eye, and the share of ambient light that the coat mirrors.
MX, MY, MZ = layout.allocate(3, surfaces="ambient")
MIRRORED = layout.allocate(surfaces="ambient")[0]
# Noise of a pixel, in 8-bit levels.
NOISE = layout.allocate(surfaces="out")[0]
# Light that a coat reflects, red, green and blue; its transmittance.
COAT = layout.allocate(3, surfaces="ambient:out")[0]
UNDER = layout.allocate(surfaces="ambient:out")[0]
# Where shadow rays begin, from the point, and the colour: of solids that have a look of their own, else 0 and theirs.
LIFT = layout.allocate(3, surfaces="ambient:out")[0]
ALBEDO = layout.allocate(3, surfaces="ambient:out")[0]
# Of the current light: position of the point itself, because `X` is offset above the surface; cosine of incidence; unit
# direction to it, where shadow rays take another; and in red, green and blue the transmittance of strands and the
# irradiance.
PX = layout.allocate(3, surfaces="light:soft")[0]
COSINE = layout.allocate(surfaces="light:reflect")[0]
TRUE_X, TRUE_Y, TRUE_Z = layout.allocate(3, surfaces="light:soft")
LEFT = layout.allocate(3, surfaces="maps:reflect")[0]
ARRIVED = layout.allocate(3, surfaces="reflect")[0]
# In a map: filter radius, texels; blur, texels a metre of distance to the occluder; that distance where no texel gives
# one, metres; w of light that is scattered forward, metres.
RADIUS, BLUR, AWAY, CLOUD = layout.allocate(4, surfaces="maps")
# Of the points of a vector: weights of the columns of their windows, two numbers a column.
COLUMNS = layout.allocate(4, surfaces="maps")[0]

ROWS = layout.row_count("surfaces")
"""Rows of the array of a batch of points."""
