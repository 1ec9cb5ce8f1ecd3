"""Haze: strands and solids fade with distance into the background behind them.

Of light that travels d metres through homogeneous air, e^(−d / distance) arrives (Beer and Lambert); in-scattered light
with the colour of the background replaces the rest. d is the depth along the camera's axis. It is computed in NumPy
on shaded values, so that kernels are the same with and without haze.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..common.kernels.keys import FIRST, LOW, SHIFT
from ..coverage.kernels.width_profiles import Profiles
from ..view.camera import View

AT_ONCE = 1 << 18
"""Vertices or samples processed at once, which bounds the memory."""


def veil_strands(
    haze: float, view: View, backdrop: NDArray[np.float32], screen: NDArray[np.float32], marks: NDArray[np.uint8],
    colours: NDArray[np.float32], body: Profiles | None,
) -> None:  # fmt: skip
    """Blend the colours (V, 3) of marked vertices with the backdrop (height, width, 3) behind them, and scale their
    width profiles alike.

    haze: distance, metres, at which 1 / e of the light is left; screen (V, 3); marks (V,): non-zero for vertices to
    change; body: profiles of wide strands, or None."""
    height, width = backdrop.shape[:2]
    for begin in range(0, len(marks), AT_ONCE):
        chosen = begin + np.flatnonzero(marks[begin : begin + AT_ONCE])
        places = screen[chosen]
        arrives = _arrives(haze, view, places[:, 2])
        with np.errstate(invalid="ignore"):  # vertices behind the eye have no valid position
            x = np.clip(np.nan_to_num(places[:, 0]), 0, width - 1).astype(np.int64)
            y = np.clip(np.nan_to_num(places[:, 1]), 0, height - 1).astype(np.int64)
        behind = backdrop[y, x]
        colours[chosen] = behind + arrives[:, None] * (colours[chosen] - behind)
        if body is not None:
            slots = body.slots[chosen]
            wide = slots >= 0
            body.profile[:, slots[wide]] *= arrives[wide, None, None]


def veil_solids(
    haze: float, view: View, behind: NDArray[np.float32], keys: NDArray[np.uint64], image: NDArray[np.float32]
) -> None:
    """Blend the solids in a picture (height, width, 3) with the picture ``behind`` them, of the same shape; keys
    (height * width,): z-buffer of the solids."""
    light, back = image.reshape(-1, 3), behind.reshape(-1, 3)
    for begin in range(0, len(keys), AT_ONCE):
        some = keys[begin : begin + AT_ONCE]
        seen = begin + np.flatnonzero(((some & LOW) >= FIRST) & (some != ~np.uint64(0)))
        numbers = (LOW - (keys[seen] >> SHIFT)).astype(np.uint32).view(np.float32)
        there = back[seen]
        light[seen] = there + _arrives(haze, view, numbers)[:, None] * (light[seen] - there)


def _arrives(haze: float, view: View, numbers: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return the share of light that arrives from surfaces with these depth numbers (see `kernels.project.points`)."""
    if view.perspective:
        depth = 1 / np.maximum(numbers.astype(np.float64), 1e-12)
    else:
        depth = view.near + (1 - numbers.astype(np.float64)) * (view.far - view.near)
    return np.exp(-np.maximum(depth, 0) / haze).astype(np.float32)
