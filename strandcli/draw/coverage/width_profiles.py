"""Width profiles of strands near the camera: light that varies across their width.

The light of a thin strand is the average over its width, which is all that a pixel shows of it. For strands wider than
two pixels the average is resolved into columns of the offset h ∈ [−1, 1], each with its own part of the azimuthal
functions,

    N_p(θ, φ) = ½ ∫ A_p(θ, h) D(φ − Φ_p(h)) dh,

so that R is a narrow streak on the side of the light, TT the glow of a strand in front of it, TRT the coloured streaks
beside them. Light that is in no lobe, scattered from strand to strand, is distributed as a cosine. Only departures from
the average are stored, and their sum over the width is 0: the total light of a strand is the same as far away, and
between two and four pixels departures are faded in, so that nothing jumps as the camera comes near. The part of the
width that a pixel shows is averaged exactly, so that a strand three pixels wide does not flicker.

Exact shadows vary across the width too, and their departures begin at a thirtieth of a pixel: shadows are traced along
lines on the side that the camera sees, and each sample has the light and the shadow of the part of width and length
that it shows. With dual scattering, shadows are those of the whole width.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..common.scratch import Scratch
from ..geometry.curves import Polylines
from .kernels import width_profiles as kernel
from .kernels.column_light import LINES
from .kernels.width_profiles import Profiles

START, FULL = 2.0, 4.0
"""Widths, pixels, from which profiles begin to count, and count fully."""
EXACT = 0.03, 0.06
"""The same under exact shadows, which vary across the width."""


def add_to_zbuffer(
    profiles: Profiles, keys: NDArray[np.uint64], base: int, lines: Polylines, image: NDArray[np.float32]
) -> None:
    """Add departures from the average to the picture, where the z-buffer ``keys`` shows these polylines; base: number
    of their first vertex in the keys."""
    kernel.add_to_zbuffer(keys, base, lines.per, lines.stride, profiles, image)


def profiles_of(
    lines: Polylines, screen: NDArray[np.float32], widths: NDArray[np.float32] | None, samples: int, scratch: Scratch,
    traced: int = 0, marks: NDArray[np.uint8] | None = None,
) -> Profiles | None:  # fmt: skip
    """Return profiles, not yet filled, for the wide vertices of polylines; None if there are none.

    screen (V, 3), widths (V,): samples; ``samples``: along a side of a pixel; ``traced``: number of lights with exact
    shadows; ``marks`` (V,): only vertices where it is not 0 get profiles, because under exact shadows many are wide."""
    start, full = EXACT if traced else (START, FULL)
    if widths is None or not len(widths) or not float(widths.max()) > start * samples:
        return None
    wide = (widths > np.float32(start * samples)) & (screen[:, 2] > 0)
    if marks is not None:
        wide &= marks != 0
    count = int(np.count_nonzero(wide))
    if count == 0:
        return None
    slots = scratch.borrow("slots", len(widths), np.int32)
    slots.fill(-1)
    slots[wide] = np.arange(count, dtype=np.int32)
    profile = scratch.borrow("profile", (1 + traced, count, kernel.COLUMNS + 1, 3), np.float32)
    shades = scratch.borrow("shades", (traced, count, LINES), np.uint64) if traced else None
    sizes = (np.float32(samples), np.float32(start), np.float32(full))
    return Profiles(screen, widths, *sizes, slots, profile, shades)
