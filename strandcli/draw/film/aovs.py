"""Layers beside the picture (arbitrary output variables).

Each pixel describes the nearest surface of all its samples, seen through a pinhole at the frame's own time, regardless
of lens and shutter. With sorted strands, a sample shows the strand that contributes most of its light, whatever is in
front of or behind it, if at least `LEAST` of the light comes from strands; otherwise the solid or the background.
docs/pictures.md has the layers, their types and what they hold where nothing is.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..common.kernels.keys import EMPTY, FIRST, LOW, depths_of, identities_of
from ..common.scratch import Scratch
from ..coverage.coverage import Layer
from ..geometry.curves import Polylines
from ..lighting.lighting import Lighting
from ..shadows.shadow import map_arrays
from ..solids.edges import WHOLE, find_edges
from ..solids.solids import NONE
from ..view.camera import View
from .film import associated
from .kernels import aovs as kernel

NOTHING = -1
SOLID = -2
LEAST = 1 / 64
"""Least share of a sample's light from strands: about that of a strand .1 pixels wide across a corner."""

TINY = np.float32(1e-30)


class Recorder:
    """Gathers the layers of one frame while it is drawn: `strands` after each batch, then `rest`."""

    ids: NDArray[np.int32] | None = None
    """Number of each strand in the order of emission, or None if they are in this order."""

    def __init__(self, image: Any) -> None:
        """``image``: the scene's settings."""
        self._names: tuple[str, ...] = image.aovs
        self._samples: int = image.supersample
        width, height = image.drawn
        self._found: dict[str, NDArray[Any]] = {
            "strand_id": np.full((height, width), NOTHING, np.int32),
            "tangent": np.zeros((height, width, 3), np.float32),
            "orientation": np.full((height, width), -1, np.float32),
        }
        self._shares: NDArray[np.float32] | None = None

    def solids(self, keys: NDArray[np.uint64], lighting: Lighting, scratch: Scratch) -> None:
        """Record a z-buffer (samples · samples · height · width,) that holds nothing but solids."""
        if "solid" not in self._names:
            return
        height, width = self._found["strand_id"].shape
        k = self._samples
        there = (keys != EMPTY).astype(np.float32)
        if lighting.solids is not None:
            edges = find_edges(keys, lighting.solids, lighting.view, (width * k, height * k), scratch)
            there[edges.pixels] = edges.counts.sum(1) / WHOLE
        self._found["solid"] = there.reshape(height, k, width, k).mean((1, 3), dtype=np.float32)

    def layer(
        self, layer: Layer, lines: Polylines, screen: NDArray[np.float32], base: int, keys: NDArray[np.uint64]
    ) -> None:
        """Write the strand that contributes most to each sample of a layer to ``keys`` (samples · samples · height ·
        width,), which contain the solids, its first vertex with the number ``base``; call `strands` after the last
        layer."""
        if self._shares is None:
            self._shares = np.zeros(len(keys), np.float32)
        kernel.front(layer.fragments, len(lines.world), screen, base, np.float32(LEAST), keys, self._shares)

    def strands(
        self, lines: Polylines, screen: NDArray[np.float32], keys: NDArray[np.uint64], base: int, begin: int,
        view: View,
    ) -> None:  # fmt: skip
        """Record the strands of a batch that are in front in ``keys`` (samples · samples · height · width,); begin:
        number of the batch's first strand; base: number of its first vertex. Tangents are interpolated between those of
        vertices, which point from the previous vertex to the next."""
        key, spots = self._nearest(keys)
        number = (key & LOW).astype(np.int64) - base
        there = (key != EMPTY) & (number >= 0) & (number < len(lines.world) - 1)
        v, spots, each, world = number[there], spots[there], np.arange(np.count_nonzero(there)), lines.world
        strand = np.searchsorted(lines.first, v, side="right") - 1
        low, high = lines.first[strand], lines.first[strand + 1] - 1
        steps = screen[v + 1, :2] - screen[v, :2]
        axis = np.abs(steps).argmax(1)
        step, past = steps[each, axis], spots[each, axis] - screen[v, axis]
        t = np.clip(past / np.where(step == 0, np.float32(1), step), 0, 1)[:, None]
        before, after = (
            _unit(world[v + 1] - world[np.maximum(v - 1, low)]),
            _unit(world[np.minimum(v + 2, high)] - world[v]),
        )
        tangents = _unit(before + t * (after - before))
        x, y, z = np.stack([view.right, view.up, view.forward]).astype(np.float32) @ tangents.T
        right, up = _aside(spots, view).T * np.float32(view.perspective)
        # projected along the ray (right, up, 1): the derivative of (x, y) / z, times z
        angles = np.arctan2(y - up * z, x - right * z) % np.float32(np.pi)
        self._found["strand_id"][there] = begin + strand
        self._found["tangent"][there] = tangents
        self._found["orientation"][there] = np.where(angles < np.float32(np.pi), angles, np.float32(0))

    def rest(self, keys: NDArray[np.uint64], lighting: Lighting) -> None:
        """Record depth, mask, solids and, if wanted, shadow from a finished z-buffer."""
        view = lighting.view
        key, spots = self._nearest(keys)
        (height, width), k = key.shape, self._samples
        shares = (identities_of(keys) < FIRST).astype(np.float32) if self._shares is None else self._shares
        there = key != EMPTY
        number = depths_of(key.ravel()).reshape(key.shape)[there]
        far = 1 / number if view.perspective else view.near + (1 - number) * (view.far - view.near)
        depth = np.full(key.shape, np.inf, np.float32)
        depth[there] = far
        which = np.where(there & ((key & LOW) >= FIRST), (key & LOW).astype(np.int64) - int(FIRST), NOTHING)
        self._found["strand_id"][which >= 0] = SOLID
        self._found["depth"] = depth
        self._found["mask"] = shares.reshape(height, k, width, k).mean((1, 3), dtype=np.float32)
        if "shadow" in self._names:
            through = np.ones(key.shape, np.float32)
            sums = np.empty((len(far), 2), np.float32)
            aside = _aside(spots[there], view) * (far[:, None] if view.perspective else 1)
            points = view.eye + far[:, None] * view.forward + aside @ np.stack([view.right, view.up])
            kernel.sum_light(
                points.astype(np.float32), which[there], *lighting.at_points(), map_arrays(lighting.maps),
                lighting.solids or NONE, sums,
            )  # fmt: skip
            through[there] = np.divide(sums[:, 0], sums[:, 1], out=np.ones_like(far), where=sums[:, 1] > 0)
            self._found["shadow"] = through

    def _nearest(self, keys: NDArray[np.uint64]) -> tuple[NDArray[np.uint64], NDArray[np.float32]]:
        """Return the smallest key of each pixel's samples (height, width), and where on the screen that sample is."""
        (height, width), k = self._found["strand_id"].shape, self._samples
        samples = keys.reshape(height, k, width, k).transpose(0, 2, 1, 3).reshape(height, width, k * k)
        which = samples.argmin(2)
        y, x = np.mgrid[:height, :width] * k
        spots = np.stack([x + which % k, y + which // k], 2).astype(np.float32) + np.float32(0.5)
        return np.take_along_axis(samples, which[..., None], 2)[..., 0], spots

    def layers(self, image: NDArray[np.float32], through: NDArray[np.float32] | None = None) -> dict[str, NDArray[Any]]:
        """Return the requested layers; ``image`` is the linear picture in samples, ``through`` its transmittance where
        it has no background."""
        if self.ids is not None:
            ids = self._found["strand_id"]
            ids[ids >= 0] = self.ids[ids[ids >= 0]]
        if "linear" in self._names and through is not None:
            self._found["linear"] = associated(image, through, self._samples)
        elif "linear" in self._names:
            height, width, _ = image.shape
            k = self._samples
            mean = image.reshape(height // k, k, width // k, k, 3).mean((1, 3), dtype=np.float32)
            self._found["linear"] = np.where(np.isfinite(mean), mean, np.float32(0))
        return {name: self._found[name] for name in self._names}


def _aside(spots: NDArray[np.float32], view: View) -> NDArray[np.float32]:
    """Return how far places (n, 2) on the screen are to the right of the view's axis and above it, metres at a depth of
    one metre."""
    x, y = view.middle
    return (spots - np.array([x, y], np.float32)) * np.array([1 / view.focal, -1 / view.focal], np.float32)


def _unit(vectors: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return vectors (n, 3) scaled to length 1; 0 for zero vectors."""
    size = np.abs(vectors).max(1, keepdims=True)  # squares of very short vectors would underflow
    vectors = vectors / np.maximum(size, TINY)
    return np.asarray(vectors / np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), TINY))
