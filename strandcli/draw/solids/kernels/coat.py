"""Surface of solids beyond their colour: a specular coat, and patches.

docs/drawing.md has the coat's formulas. Over a light of angular radius a, half vectors lie within a / 2, and the coat
mirrors the mean of the distribution over that disc: a polished one shows the disc, with its edge. The density of
slopes, α² / (π (α² + s²)²), is that of a sphere's surface in stereographic projection, which makes a disc a cap: its
share is ½ (1 + x / √(x² + 4 α² b²)), with x = b² − s² − α², for a disc of radius b at a distance s. Ambient light is
mirrored as a whole, with a Fresnel term that rises less the rougher the coat is. The base receives what the coat does
not mirror, so that a white solid in uniform light is as bright as the light.

Patches are three-dimensional noise in octaves, each faded out where it is finer than a pixel.
"""

from __future__ import annotations

import numpy as np

from ....jit import inlined
from ....simd import sqrt, where
from ...common.kernels.numbers import HALF, INV_PI, ONE, THREE, TWO, ZERO

FOUR = np.float32(4.0)
TINY = np.float32(1e-6)
QUARTER = np.float32(0.25)
OCTAVES = 5
FAINTER = np.float32(0.7)
"""Weight of an octave over that of the one before it."""
BITS = np.float32(2.0**-24)
WATER = np.float32(0.02)
"""Least reflectance of a coat that covers all of the surface, straight on."""
COAT, ROUGH, MOTTLE, GRAIN = 0, 1, 2, 3
SUBSURFACE = 4
"""Columns of `strandcli.draw.solids.solids.coats_of`; the last one is followed by those of green and blue."""
THIRD = np.float32(1.0 / 3.0)


@inlined
def fresnel(coat, edge, cosine):
    """Return the reflectance at a cosine: ``coat`` at normal incidence; at grazing angles ``edge`` of what the coat
    covers (Schlick 1994)."""
    x = min(max(ONE - cosine, ZERO), ONE)
    square = x * x
    edge = max(edge, WATER) * min(coat / WATER, ONE)
    return coat + (edge - coat) * square * square * x


@inlined
def mirrored(coat, rough, nv):
    """Return the share of ambient light that a coat mirrors to the eye; nv: cosine between normal and eye."""
    return fresnel(coat, max(ONE - rough, coat), nv)


@inlined
def gleam(coat, rough, size, normal, light, eye):
    """Return the coat's BRDF, 1/sr, for unit vectors of the normal, to the light and to the eye; size: sine of the
    light's angular radius. Vectors of lanes."""
    nx, ny, nz = normal
    lx, ly, lz = light
    vx, vy, vz = eye
    hx = lx + vx
    hy = ly + vy
    hz = lz + vz
    per = ONE / sqrt(max(hx * hx + hy * hy + hz * hz, TINY))
    nh = min((nx * hx + ny * hy + nz * hz) * per, ONE)
    lh = min((lx * hx + ly * hy + lz * hz) * per, ONE)
    nl = max(nx * lx + ny * ly + nz * lz, TINY)
    nv = max(nx * vx + ny * vy + nz * vz, TINY)
    disc = QUARTER * size * size
    facets = facets_over(rough * rough * rough * rough, disc, max(nh * nh, TINY))
    square = rough * rough * rough * rough + disc
    seen = nl * sqrt(nv * nv * (ONE - square) + square) + nv * sqrt(nl * nl * (ONE - square) + square)
    return fresnel(coat, ONE, lh) * facets * HALF / max(seen, TINY)


@inlined
def facets_over(square, disc, cosine):
    """Return the mean of the distribution of half vectors over a disc of slopes, 1/sr; square: α², disc: the square of
    its radius, cosine: the square of that between the normal and its middle."""
    away = (ONE - cosine) / cosine
    inside = disc - away - square
    root = sqrt(inside * inside + FOUR * square * disc)
    density = where(inside > ZERO, HALF * (root + inside) / (root * disc), TWO * square / (root * (root - inside)))
    return density * INV_PI / (cosine * cosine)


@inlined
def add_octave(total, x, y, z, size, pixel, weight, seed):
    """Return the noise so far with an octave added, whose patches are of this size, metres. Without branches."""
    # an octave is complete from a size of two pixels on, and absent at one pixel or less
    shown = min(max(size / max(pixel, TINY) - ONE, ZERO), ONE)
    per = ONE / size if shown > ZERO else ZERO
    return total + shown * weight * lattice(x * per, y * per, z * per, seed)


@inlined
def lattice(x, y, z, seed):
    """Return value noise in [−1, 1]: uniform random values at integer points, interpolated smoothly."""
    i = np.floor(x)
    j = np.floor(y)
    k = np.floor(z)
    u = smooth(x - i)
    v = smooth(y - j)
    w = smooth(z - k)
    a, b, c = np.uint32(np.int32(i)), np.uint32(np.int32(j)), np.uint32(np.int32(k))
    total = ZERO
    for corner in range(8):
        p, q, r = corner & 1, (corner >> 1) & 1, corner >> 2
        weight = (u if p else ONE - u) * (v if q else ONE - v) * (w if r else ONE - w)
        total += weight * value(
            np.uint32(a + np.uint32(p)), np.uint32(b + np.uint32(q)), np.uint32(c + np.uint32(r)), seed
        )
    return TWO * total - ONE


@inlined
def smooth(t):
    """Return the smoothstep 3t² − 2t³ of t in [0, 1]."""
    return t * t * (THREE - TWO * t)


@inlined
def value(a, b, c, seed):
    """Return a uniform random value in [0, 1) for an integer point, uint32 (Wellons's `lowbias32` hash)."""
    bits = np.uint32(a * np.uint32(73856093)) ^ np.uint32(b * np.uint32(19349663)) ^ np.uint32(c * np.uint32(83492791))
    bits = np.uint32(np.uint32(bits) + np.uint32(np.uint32(0x9E3779B9) * seed))
    bits = np.uint32((bits ^ (bits >> np.uint32(16))) * np.uint32(0x7FEB352D))
    bits = np.uint32((bits ^ (bits >> np.uint32(15))) * np.uint32(0x846CA68B))
    bits = np.uint32(bits ^ (bits >> np.uint32(16)))
    return np.float32(bits >> np.uint32(8)) * BITS


@inlined
def scattered(cosine, width):
    """Return the share of a light's irradiance that leaves a surface on which it falls at cosines, −1 to 1, a vector of
    lanes; width: w of the module's docstring, 0 to 1."""
    share = max(cosine, ZERO)
    if width > ZERO:
        share = where(abs(cosine) < width, (cosine + width) * (cosine + width) * QUARTER / width, share)
    return share / (ONE + width * width * THIRD)
