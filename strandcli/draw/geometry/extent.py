"""Extent of strands: their bounding box, and their width in the world and on the screen."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...constants import W
from ...scene.model import Material
from ..common.kernels.view_columns import CORNER_STRETCH
from ..common.scratch import Scratch
from ..view.camera import View
from ..view.kernels import project
from .curves import Polylines
from .kernels import ribbon
from .kernels.curves import find_shares

NO_WIDTHS = np.zeros(0, np.float32)


@dataclass(frozen=True)
class Thickness:
    """Width of strands in the world."""

    width: float = 0.0
    """At the root, metres."""
    taper: float = 0.0
    """Share by which the width is smaller at the tip; of strands whose widths vary from point to point, that of such
    with as great a mean."""

    @property
    def mean(self) -> float:
        """Mean width along a strand, metres."""
        return self.width * (1 - self.taper / 2)


class Extents(NamedTuple):
    """Bounding boxes of strands, from the root on, metres."""

    low: NDArray[np.float32]
    """(blocks, 3 W)"""
    high: NDArray[np.float32]
    """(blocks, 3 W)"""


def extents_of(positions: NDArray[np.float32]) -> Extents:
    """Return the bounding box of each strand of positions (blocks, n + 1, 3 W), metres."""
    return Extents(positions[:, 1:].min(1), positions[:, 1:].max(1))


def bounds_of(extents: Extents, strands: int, fade: NDArray[np.float32] | None = None) -> NDArray[np.float64]:
    """Return the bounding box (2, 3), metres, of the first ``strands`` of those with ``extents``.

    The rest does not count, so that a frame does not depend on strands that other frames need. ``fade`` (strands,):
    strands that fade extend the box in proportion, so that it does not jump."""
    low, high = (side.reshape(-1, 3, W) for side in extents)
    if fade is None:
        low, high = (side.transpose(1, 0, 2).reshape(3, -1)[:, :strands] for side in (low, high))
        return np.stack([low.min(1), high.max(1)]).astype(np.float64)
    lanes = np.full((len(low), 1, W), -1, np.float32)
    lanes.reshape(-1)[:strands] = fade
    whole, shares = lanes == fade.max(), np.maximum(lanes, 0)
    least = np.where(whole, low, np.float32(np.inf)).min((0, 2)).astype(np.float64)
    most = np.where(whole, high, np.float32(-np.inf)).max((0, 2)).astype(np.float64)
    shares[whole] = 0
    below = np.minimum((low - least[:, None]) * shares, 0).min((0, 2))
    above = np.maximum((high - most[:, None]) * shares, 0).max((0, 2))
    return np.stack([least + below, most + above])


def extents_on_screen(
    first: NDArray[np.int64],
    screen: NDArray[np.float32],
    widths: NDArray[np.float32] | None,
    width: int,
    scratch: Scratch,
) -> NDArray[np.float32]:
    """Return what `kernels.ribbon.find_on_screen` finds of strands in a picture so wide; widths: None for lines one
    sample wide."""
    found = scratch.borrow("extents", (len(first) - 1, ribbon.COLUMNS), np.float32)
    ribbon.find_on_screen(first, screen, NO_WIDTHS if widths is None else widths, width, found)
    return found


def thickness_of(
    material: Material, view: View, bounds: NDArray[np.float64], shares: NDArray[np.float32] | None = None
) -> Thickness:
    """Return the width with which strands shade their neighbours. Lines one pixel wide have the width of a pixel at the
    depth of the groom's centre; bounds (2, 3): bounding box, metres; shares (strands, n): of each strand's width, at
    its points, None: as the material tapers."""
    if material.width > 0:
        return Thickness(material.width, material.drawn_taper if shares is None else 2 * (1 - float(shares.mean())))
    depth = max(float((bounds.mean(0) - view.eye) @ view.forward), view.near) if view.perspective else 1.0
    return Thickness(depth / view.focal)


def widths_of(
    lines: Polylines, screen: NDArray[np.float32], view: View, material: Material, least: float, thins: bool,
    scratch: Scratch,
) -> NDArray[np.float32] | None:  # fmt: skip
    """Return the widths (V,) of strands on the screen, samples, at least ``least``; None: all are one sample wide.

    screen (V, 3): from `project.points`; ``thins``: whether strands that fade become thinner."""
    scale = lines.scale
    if not len(screen):
        return None
    if material.width == 0:
        return None if scale is None or not thins else np.repeat(scale, np.diff(lines.first))
    packed = view.pack()
    if least > 0:
        nearest = float(screen[:, 2].max()) if view.perspective else 1.0
        widest = float(packed[CORNER_STRETCH]) if scale is None else float(packed[CORNER_STRETCH] * scale.max())
        if material.width * widest * view.focal * nearest <= least:
            return None
    widths = scratch.borrow("widths", len(screen), np.float32)
    taper, along = lines.tapered(material.drawn_taper)
    project.widths(
        lines.first, screen, packed, np.float32(material.width), taper, scale, np.float32(least), along,
        widths,
    )  # fmt: skip
    return widths


def lost_of(lines: Polylines, shares: NDArray[np.float32], scratch: Scratch) -> NDArray[np.float32]:
    """Return `Polylines.lost` of strands that have ``shares`` (strands, n) of their widths at their points."""
    out = scratch.borrow("lost", len(lines.world), np.float32)
    find_shares(lines.first, lines.along, shares, out)
    return np.subtract(np.float32(1.0), out, out=out)
