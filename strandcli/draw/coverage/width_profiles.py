"""Width profiles of strands near the camera: light that varies across their width.

Everywhere else a strand's light is the average over its width, which is all that a pixel shows of a thin strand. Where
strands are wider than two pixels the average is resolved: into columns of the offset h ∈ [−1, 1], each with its own
part of the azimuthal functions,

    N_p(θ, φ) = ½ ∫ A_p(θ, h) D(φ − Φ_p(h)) dh,

so that R is a narrow streak on the side of the light, TT the glow of a strand before it, TRT the coloured streaks
beside them. What is no lobe, the light from strand to strand, is rounded off by a cosine. Only departures from the
average are kept, and they add up to nothing over the width: a strand's whole light is what it is far away, and between
two and four pixels departures grow from nothing, so that nothing jumps as the camera comes near. A pixel's share of the
width is averaged exactly, so that a strand three pixels wide does not flicker.

Where a light's shadows are exact they have their edges across the width too, and departures begin at a thirtieth of a
pixel: shadows are traced along lines on the side that the camera sees, and each sample has the light and the shadow of
the part of the width and of the length that it shows. With dual scattering shadows stay those of the whole width.
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
"""Widths in pixels from which profiles count, and count fully;"""
EXACT = 0.03, 0.06
"""where shadows are exact: there they vary across the width."""


def add_to_zbuffer(
    profiles: Profiles, keys: NDArray[np.uint64], base: int, lines: Polylines, image: NDArray[np.float32]
) -> None:
    """Add departures from the average where the z-buffer ``keys`` shows these polylines, whose vertices are numbered
    from ``base``."""
    kernel.add_to_zbuffer(keys, base, lines.per, lines.stride, profiles, image)


def profiles_of(
    lines: Polylines, screen: NDArray[np.float32], widths: NDArray[np.float32] | None, samples: int, scratch: Scratch,
    traced: int = 0, marks: NDArray[np.uint8] | None = None,
) -> Profiles | None:  # fmt: skip
    """Empty profiles of what is wide of polylines (V,) with these widths in samples; None where nothing is.

    ``traced``: lights with exact shadows, under which only the vertices with ``marks`` (V,) matter: they are many."""
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
