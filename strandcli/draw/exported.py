"""Polylines and widths of drawn strands for other programs, whatever the camera."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ..constants import W
from ..scene.model import Curves, Material, Scene
from .common.scratch import Scratch
from .geometry.curves import Polylines, flatten
from .geometry.extent import bounds_of, extents_of
from .geometry.kernels.curves import find_shares
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
    view = camera_view(scene.camera, 0.0, W, W, bounds_of(extents_of(strands.positions), strands.count))
    return flatten(strands.positions, strands.lengths, strands.count, curves, view, True, scratch)


def widths_along(material: Material, strands: Strands, lines: Polylines) -> NDArray[np.float32] | None:
    """Return the widths (count, vertices) of strands at their vertices, root to tip, metres; None of lines one pixel
    wide."""
    if material.width == 0:
        return None
    own = np.float32(material.width) * (np.ones(1, np.float32) if strands.level is None else strands.level.scale)
    shares = np.empty((strands.count, lines.per), np.float32)
    if strands.shares is not None:
        find_shares(lines.first, lines.along, strands.shares, shares.reshape(-1))
    else:
        shares[:] = 1 - np.float32(material.drawn_taper) * np.linspace(0, 1, lines.per, dtype=np.float32)
    return np.multiply(shares, own[:, None], out=shares)
