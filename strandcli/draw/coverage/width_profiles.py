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
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..common.scratch import Scratch
from .kernels import width_profiles as kernel
from .kernels.width_profiles import Profiles

START, FULL = 2.0, 4.0
"""Widths, pixels, from which profiles begin to count, and count fully."""


def profiles_of(
    screen: NDArray[np.float32], widths: NDArray[np.float32] | None, samples: int, scratch: Scratch
) -> Profiles | None:
    """Return profiles, not yet filled, for the wide vertices of polylines; None if there are none.

    screen (V, 3), widths (V,): samples; ``samples``: along a side of a pixel."""
    if widths is None or not len(widths) or not float(widths.max()) > START * samples:
        return None
    wide = (widths > np.float32(START * samples)) & (screen[:, 2] > 0)
    count = int(np.count_nonzero(wide))
    if count == 0:
        return None
    slots = scratch.borrow("slots", len(widths), np.int32)
    slots.fill(-1)
    slots[wide] = np.arange(count, dtype=np.int32)
    profile = scratch.borrow("profile", (count, kernel.COLUMNS + 1, 3), np.float32)
    return Profiles(screen, widths, np.float32(samples), np.float32(START), np.float32(FULL), slots, profile)
