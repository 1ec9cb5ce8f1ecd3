"""Haze: strands and solids fade with distance into the background behind them.

Of light that travels d metres through homogeneous air, e^(−d / distance) arrives (Beer and Lambert); in-scattered light
with the colour of the background replaces the rest. d is the depth along the camera's axis. Shaded values are changed,
so that kernels of shading are the same with and without haze.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ..coverage.kernels.width_profiles import Profiles
from ..view.camera import View
from .kernels import haze as kernel

NO_SLOTS, NO_PROFILE = np.zeros(0, np.int32), np.zeros((0, 0, 3), np.float32)
MOST_RATE = 1e30
"""Halvings of light a metre in the thickest haze, which single precision holds."""


def veil_strands(
    haze: float, view: View, backdrop: NDArray[np.float32], screen: NDArray[np.float32], marks: NDArray[np.uint8],
    colours: NDArray[np.float32], body: Profiles | None,
) -> None:  # fmt: skip
    """Blend the colours (V, 3) of marked vertices with the backdrop (height, width, 3) behind them, and scale their
    width profiles alike.

    haze: distance, metres, at which 1 / e of the light is left; screen (V, 3); marks (V,): non-zero for vertices to
    change; body: profiles of wide strands, or None."""
    slots, profile = (NO_SLOTS, NO_PROFILE) if body is None else (body.slots, body.profile)
    kernel.veil_strands(_air(haze, view), backdrop, screen, marks, colours, slots, profile)


def veil_solids(
    haze: float, view: View, behind: NDArray[np.float32], keys: NDArray[np.uint64], image: NDArray[np.float32],
    hidden: NDArray[np.uint8],
) -> None:  # fmt: skip
    """Blend the solids in a picture (height, width, 3) with the picture ``behind`` them, of the same shape; keys
    (height * width,): z-buffer of the solids; hidden (height * width,): non-zero for pixels that are not changed, (0,):
    there are none."""
    kernel.veil_solids(_air(haze, view), behind.reshape(-1, 3), keys, hidden, image.reshape(-1, 3))


def _air(haze: float, view: View) -> kernel.Air:
    rate = -min(1 / (haze * math.log(2.0)), MOST_RATE)
    return kernel.Air(*map(np.float32, (rate, view.perspective, view.near, view.far - view.near)))
