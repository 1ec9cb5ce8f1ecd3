"""Rows of a batch of W points of one solid that are shaded together, beside those of `batch` that surfaces share."""

from __future__ import annotations

from .batch import layout

# Unit normal; place on the screen and the depth along its ray; how wide a pixel is there; how much of the picture the
# point becomes.
NX, NY, NZ = layout.take("normal", 3, surfaces="ambient:out")
SX, SY, DISTANCE = layout.take("place on the screen", 3, surfaces="gather:ambient")
PIXEL = layout.one("width of a pixel", surfaces="ambient")
THERE = layout.one("share of the picture", surfaces="ambient:out")
# What a coat mirrors in red, green and blue, and the share of light that it leaves to what is under it.
COAT = layout.take("light of the coat", 3, surfaces="ambient:out")[0]
UNDER = layout.one("share under the coat", surfaces="ambient:out")
# Of one light: the place of the point itself while `X` is above the surface, its cosine, and in red, green and blue
# what strands leave of it and what arrives.
PX = layout.take("place on the surface", 3, surfaces="light:soft")[0]
COSINE = layout.one("cosine", surfaces="light:reflect")
LEFT = layout.take("share that strands leave", 3, surfaces="maps:reflect")[0]
ARRIVED = layout.take("light that arrived", 3, surfaces="reflect")[0]
# Texels about a point: how far they reach and one over that, the first and the last column and row, sums of weights and
# of light that is lost in red, green and blue.
RADIUS, PER, FIRST_U, LAST_U, FIRST_V, LAST_V, TOTAL = layout.take("texels about a point", 7, surfaces="maps")
LOST = layout.take("light that is lost", 3, surfaces="maps")[0]
# Of one texel its column, −1 for none, its row, its weight, the strands in front of the point, the depths where the
# cell's own begin and end, and of the light that they scatter on the weight and what the rest of it loses.
ACROSS, DOWN, WEIGHT, PASSED = layout.take("texel", 4, surfaces="maps")
FRONT, BACK, NEAR, OTHER = layout.take("strands of a texel", 4, surfaces="maps")
# How a map sees a point: texels of blur a metre of distance from what hides the light, that distance where nothing
# tells it, and the w of light that goes on; every how manieth texel is looked at, and how much those between every
# other one of them have faded out.
BLUR, AWAY, CLOUD, STRIDE, FADE = layout.take("blur of a point", 5, surfaces="maps")

ROWS = layout.count("surfaces")
"""Rows of a batch of points."""
