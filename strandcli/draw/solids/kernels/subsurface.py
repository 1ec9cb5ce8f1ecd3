"""Light that goes on under the surface of a solid: skin, wax, marble.

Light spreads before it leaves, so that on a round body it fades over a band about the line at which it grazes the
surface, in skin the furthest for red (d'Eon, Luebke and Enderton 2007; Penner and Borshukov 2011, "Pre-Integrated Skin
Shading"). Here the cosine of Lambert's law, max(μ, 0), is averaged over a window of half-width w,

    s(μ) = 0 up to −w,  (μ + w)² / 4w in between,  μ from w on,

whose integral over all directions is π (1 + w² / 3), and divided by 1 + w² / 3: no light is gained or lost, and away
from the band the surface is as bright as before. Light that spreads over a mean distance d on a body of the radius r
has w ≈ √3 d / r, by the variance of the window. For w = 0 it is Lambert's law.
"""

from __future__ import annotations

import numpy as np

from ....jit import function

ZERO = np.float32(0.0)
QUARTER = np.float32(0.25)
THIRD = np.float32(1.0 / 3.0)
ONE = np.float32(1.0)


@function
def scattered(cosine, width):
    """Return the share of a light's irradiance that leaves a surface on which it falls at a cosine, −1 to 1; width: w
    of the module's docstring, 0 to 1."""
    share = max(cosine, ZERO)
    if width > ZERO and abs(cosine) < width:
        share = (cosine + width) * (cosine + width) * QUARTER / width
    return share / (ONE + width * width * THIRD)
