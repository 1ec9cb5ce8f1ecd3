"""Rows of a batch of points of one solid that are lit together: those of `batch`, and what surfaces have beside them.

A surface's normal is in the rows of a strand's tangent, and the light of its coat in those of a strand's colour.
"""

from __future__ import annotations

from ....constants import W
from .batch import COLOUR, EXTRA, TEXELS, TX, TY, TZ

NX, NY, NZ = TX, TY, TZ
COAT = COLOUR
# Place of the point itself while `X` is above the surface; on the screen, with the depth along its ray; how wide a
# pixel is there; how much of the picture it becomes; share of light that the coat leaves; of one light its cosine, what
# strands leave of it, and what arrives, in red, green and blue.
PX = EXTRA
SX, SY, DISTANCE, PIXEL, THERE, UNDER, COSINE = (TEXELS + i * W for i in range(7))
LEFT, ARRIVED = TEXELS + 7 * W, TEXELS + 10 * W
# Texels about a point: how far they reach and one over that, the first and the last column and row, sums of weights and
# of light that is lost; of one texel its column, −1 for none, its weight, the strands in front of the point, the depths
# where the cell's own begin and end, and of the light that they scatter on the weight and what the rest of it loses.
PER, FIRST_U, LAST_U, FIRST_V, LAST_V, TOTAL = (TEXELS + i * W for i in range(13, 19))
LOST, ACROSS, WEIGHT, PASSED = TEXELS + 19 * W, TEXELS + 22 * W, TEXELS + 23 * W, TEXELS + 24 * W
RADIUS, FRONT, BACK, NEAR, OTHER = (TEXELS + i * W for i in range(25, 30))
# How a map sees a point: texels of blur a metre of distance from what hides the light, that distance where nothing
# tells it, and the w of light that goes on.
BLUR, AWAY, CLOUD = (TEXELS + i * W for i in range(30, 33))
# The texel's row; every how manieth is looked at, and how much those between every other one of them have faded out.
DOWN, STRIDE, FADE = (TEXELS + i * W for i in range(33, 36))
ROWS = 27 + 36
