"""Colours of points of a mesh: those of its vertices, or its texture, filtered to the width of a pixel."""

from __future__ import annotations

import math

import numpy as np

from ...jit import device
from ...jit.indices import FIRST, SECOND, THIRD
from .arrays import COLOURS, UV, surface_of, texture_of

ONE = np.float32(1.0)
HALF = np.float32(0.5)
SLANT = 0.1
"""Least cosine to the eye at which a pixel's width on the surface still grows."""
NONE = (np.float32(-1.0), np.float32(-1.0), np.float32(-1.0))
"""The solid's own colour."""


@device
def colour_at(data, k, row, u, v, width, facing):
    """Linear colour of the point u, v of triangle ``row`` of mesh k; negative where it has no colours.

    width: of a pixel, metres; facing: cosine between the normal and the eye, by whose root a pixel is wider.
    """
    if data.table[k, COLOURS] != 0:
        colours = surface_of(data, k).colours
        return mixed(colours, row, FIRST, u, v), mixed(colours, row, SECOND, u, v), mixed(colours, row, THIRD, u, v)
    if data.table[k, UV] != 0:
        uv = surface_of(data, k).uv
        texels = width * surface_of(data, k).density[row] / math.sqrt(max(facing, SLANT))
        s, t = mixed(uv, row, FIRST, u, v), mixed(uv, row, SECOND, u, v)
        return texture_at(texture_of(data, k), s, t, np.float32(texels))
    return NONE


@device
def mixed(corners, row, c, u, v):
    """Coordinate c of a triangle's corners, interpolated."""
    a = corners[row, 0, c]
    return np.float32(a + u * (corners[row, 1, c] - a) + v * (corners[row, 2, c] - a))


@device
def texture_at(texture, s, t, texels):
    """Linear colour of a texture at (s, t), of which the origin is at the lower left, over so many texels."""
    last = texture.levels.shape[0] - 1
    level = 0
    while texels > ONE + ONE and level < last:
        texels *= HALF
        level += 1
    r, g, b = bilinear(texture, level, s, t)
    if texels > ONE and level < last:
        share = texels - ONE
        x, y, z = bilinear(texture, level + 1, s, t)
        r, g, b = r + share * (x - r), g + share * (y - g), b + share * (z - b)
    return r, g, b


@device
def bilinear(texture, level, s, t):
    """Linear colour of a level of the texture, interpolated; the picture repeats."""
    texels, levels, linear = texture
    wide, high = levels[level, 1], levels[level, 2]
    x = (s - np.floor(s)) * np.float32(wide) - HALF
    y = (ONE - (t - np.floor(t))) * np.float32(high) - HALF
    i, j = int(np.floor(x)), int(np.floor(y))
    p, q = x - np.float32(i), y - np.float32(j)
    left, right = (i + wide) % wide, (i + 1) % wide
    base = levels[level, 0]
    above, below = base + (j + high) % high * wide, base + (j + 1) % high * wide
    return (
        between(texels, linear, above + left, above + right, below + left, below + right, FIRST, p, q),
        between(texels, linear, above + left, above + right, below + left, below + right, SECOND, p, q),
        between(texels, linear, above + left, above + right, below + left, below + right, THIRD, p, q),
    )


@device
def between(texels, linear, a, b, c, d, channel, p, q):
    """Light between four texels."""
    upper, lower = linear[texels[a, channel]], linear[texels[c, channel]]
    upper += p * (linear[texels[b, channel]] - upper)
    lower += p * (linear[texels[d, channel]] - lower)
    return upper + q * (lower - upper)
