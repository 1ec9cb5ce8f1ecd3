"""Shadow maps of all lights that have one."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..scene.model import DirectionalLight, Light
from .camera import View, ball, parallel_view, point_views
from .curves import Polylines
from .kernels import shadow as kernel
from .raster import into_bands, to_screen
from .scratch import Scratch


@dataclass(frozen=True)
class ShadowMaps:
    """All maps in one array of texels, as `kernels.shadow.transmittance` reads them."""

    views: list[View]
    packed: NDArray[np.float32]
    """(M, 24) the views packed."""
    starts: NDArray[np.int64]
    sizes: NDArray[np.int64]
    texels: NDArray[np.float32]
    """(T, 2) nearest and farthest depth, metres."""
    owners: list[tuple[int, int]]
    """For each light its first map and how many it has."""

    def add(self, lines: Polylines, workers: int, scratch: Scratch) -> None:
        """Draw polylines into every map."""
        for view, start, size in zip(self.views, self.starts, self.sizes, strict=True):
            stride = coarseness(lines, view)
            screen = to_screen(lines, view, scratch, "light_screen", stride)
            ends = np.arange(len(lines.first), dtype=np.int64)
            first = (lines.first - ends) // stride + ends
            bands = into_bands(first, screen, int(size), 1.0, workers, scratch)
            far = np.float32(0.0 if view.perspective else view.far - view.near)
            kernel.fill(
                first, screen, bands.members, bands.begin, int(size), bands.rows, workers, far,
                np.float32(view.near), self.texels[start : start + size * size],
            )  # fmt: skip


def plan_maps(lights: tuple[Light, ...], bounds: NDArray[np.float64], scratch: Scratch) -> ShadowMaps | None:
    """Empty maps for the lights that want one, fitted to the box ``bounds`` (2, 3); None where none does."""
    views: list[View] = []
    owners = []
    for light in lights:
        before = len(views)
        if wants_map(light):
            size = light.shadow.size
            if isinstance(light, DirectionalLight):
                views.append(parallel_view(light.direction, size, bounds))
            else:
                views += point_views(light.position, size, bounds)
        owners.append((before, len(views) - before))
    if not views:
        return None
    sizes = np.array([view.width for view in views], np.int64)
    starts = np.concatenate([[0], np.cumsum(sizes**2)]).astype(np.int64)
    texels = scratch.take("texels", (int(starts[-1]), 2), np.float32)
    texels[:, 0] = np.inf
    texels[:, 1] = -np.inf
    return ShadowMaps(views, np.stack([view.pack() for view in views]), starts[:-1], sizes, texels, owners)


def coarseness(lines: Polylines, view: View) -> int:
    """How many pieces of a curve a map may draw as one line: a segment that turns by a radian then leaves the curve by
    at most half a texel. A cubic's chords are off by length · turn / 8, which falls with the square of their number."""
    nearest = view.near if view.perspective else 1.0
    texels = lines.segment * view.focal / nearest
    needed = 1
    while needed < lines.pieces and texels / (8 * needed * needed) > 0.5:
        needed *= 2
    return lines.pieces // needed


def wants_map(light: Any) -> bool:
    """Whether a light has a shadow map at all: one that is dark needs none."""
    return bool(light.shadow.model != "off" and light.intensity > 0 and any(light.colour))


def default_bias(view: View, bounds: NDArray[np.float64]) -> float:
    """Depth that a strand covers within one texel: nearer than that to the first strand nothing is shaded."""
    centre, radius = ball(bounds)
    depth = max(float(np.linalg.norm(centre - view.eye)), radius) if view.perspective else 1.0
    return depth / view.focal
