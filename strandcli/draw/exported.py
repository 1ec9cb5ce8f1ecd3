"""Polylines and widths of drawn strands for other programs, whatever the camera."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ..constants import W
from ..scene.model import Curves, Material, Scene
from .common.scratch import Scratch
from .geometry.curves import Polylines, flatten
from .geometry.extent import bounds_of
from .strand_batches import Strands
from .view.camera import camera_view

MOST_ADAPTIVE = 2
"""Level of curves that the screen does not tell, at most: four pieces a segment."""


def evenly_cut(curves: Curves, level: int | None = None) -> Curves:
    """Return curves of which every segment has as many pieces, 2 ** ``level``: by default what they have themselves, of
    adaptive ones at most `MOST_ADAPTIVE`."""
    if level is None:
        level = {"fixed": curves.level, "adaptive": min(curves.level, MOST_ADAPTIVE)}.get(curves.mode, 0)
    return replace(curves, mode="fixed" if level else "off", level=level)


def polylines(scene: Scene, strands: Strands, curves: Curves, scratch: Scratch) -> Polylines:
    """Return the polylines of drawn strands, of curves that do not depend on the view."""
    view = camera_view(scene.camera, 0.0, W, W, bounds_of(strands.positions, strands.count))
    return flatten(strands.positions, strands.lengths, strands.count, curves, view, True, scratch)


def widths_along(
    material: Material, per: int, count: int, scale: NDArray[np.float32] | None
) -> NDArray[np.float32] | None:
    """Return the widths (count, per) of strands at their vertices, root to tip, metres; None of lines one pixel wide.
    scale (count,): factor of each strand's width, or None."""
    if material.width == 0:
        return None
    thinner = np.float32(material.taper) / np.float32(max(per - 1, 1))
    along = np.float32(material.width) * (np.float32(1) - thinner * np.arange(per, dtype=np.float32))
    own = np.ones(count, np.float32) if scale is None else scale
    return np.asarray(own[:, None] * along)
