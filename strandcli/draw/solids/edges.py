"""Antialiased edges of solids for sorted strands, which may lie in front of, between and behind the solids.

A pixel whose solid differs from a neighbour's, which may be beside the picture, is resolved with 4×4 samples. The
solid in front becomes a fragment, sorted among those of strands, whose opacity is the share of the samples that show
it. The mean of the other samples is the background over which all fragments are composited. As with strands, partial
coverage is taken to be uncorrelated with position in the pixel. Creases of a box, and solids so small that they lie
between pixel centres, are not antialiased.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...solids import Solids
from ..common.kernels.keys import EMPTY, FIRST, LOW, depths_of, identities_of
from ..common.scratch import Scratch
from ..view.camera import View
from .kernels import visible
from .solids import frames_of

Shade = Callable[[NDArray[np.uint64], NDArray[np.float32], NDArray[np.float32]], None]
SAMPLES = 4
"""Samples along each side of a pixel."""
WHOLE = SAMPLES * SAMPLES
SLOTS = 4
"""Solids that are distinguished within a pixel; further ones count as the last of them."""
ALL = np.zeros(0, np.int64)
PIXELS = np.zeros((0, 2), np.float32)
"""Stand for all solids, and the middles of pixels, where `kernels.visible.find` looks."""


@dataclass(frozen=True)
class Edges:
    """Occlusion by solids, and the E pixels that a solid covers in part."""

    hides: NDArray[np.float32]
    """(height * width,) depth number behind which solids cover the whole pixel, 0 where they do not."""
    pixels: NDArray[np.int64]
    """(E,) pixel numbers, row by row."""
    depth: NDArray[np.float32]
    """(E,) depth number of the solid in front."""
    cover: NDArray[np.float32]
    """(E,) its coverage of the pixel, 0 to 1."""
    light: NDArray[np.float32]
    """(E, 3) its radiance, after `composite`."""
    keys: NDArray[np.uint64]
    """(E, SLOTS) key of each solid at the mean place of the samples that show it; `EMPTY` in unused slots."""
    spots: NDArray[np.float32]
    """(E, SLOTS, 2) these places on the screen."""
    counts: NDArray[np.int64]
    """(E, SLOTS) the number of these samples."""

    def within(self, begin: int, end: int) -> Edges:
        """Return the edges in the pixels begin … end − 1, in the same arrays."""
        here = slice(*np.searchsorted(self.pixels, (begin, end)).tolist())
        names = ("pixels", "depth", "cover", "light", "keys", "spots", "counts")
        return replace(self, **{name: getattr(self, name)[here] for name in names})

    def composite(self, shade: Shade, image: NDArray[np.float32], backdrop: NDArray[np.float32]) -> None:
        """Write what the edge pixels show behind the solid in front to the picture (height, width, 3), and set `light`.

        ``shade`` shades surfaces: z-buffer keys, a picture that contains the background, and the pixels' positions on
        the screen (pixels, 2). ``backdrop`` (height, width, 3).
        """
        behind = backdrop.reshape(-1, 3)[self.pixels]
        colours = np.ascontiguousarray(np.repeat(behind[:, None], SLOTS, 1))
        shade(self.keys.reshape(-1), colours, self.spots.reshape(-1, 2))
        each, front = np.arange(len(self.pixels)), self.keys.argmin(1)
        self.light[:] = colours[each, front]
        shares = self.counts.astype(np.float32)
        left = np.float32(WHOLE) - shares.sum(1)
        covered = shares[each, front] == WHOLE  # a solid that all samples show is its own background
        shares[each[~covered], front[~covered]] = 0
        light = left[:, None] * behind
        for slot in range(SLOTS):
            light += shares[:, slot, None] * colours[:, slot]
        image.reshape(-1, 3)[self.pixels] = light / (left + shares.sum(1))[:, None]


def find_edges(keys: NDArray[np.uint64], packed: Solids, view: View, size: tuple[int, int], scratch: Scratch) -> Edges:
    """Return the edges in a z-buffer of solids, ``keys`` (height * width,); size: width and height in pixels."""
    width, height = size
    frames, numbers = frames_of(packed, view), view.pack()

    def seen(spots: NDArray[np.float32], only: NDArray[np.int64] = ALL) -> NDArray[np.uint64]:
        """The keys of solids at places (n, 2) of the screen."""
        found = np.empty(len(spots), np.uint64)
        if len(spots):
            visible.find(spots, only, width, numbers, packed, frames, found)
        return found

    hides = depths_of(keys, scratch.borrow("hides", len(keys), np.float32))
    pixels = _edge_pixels(keys, width, height, seen)
    middles = np.stack([pixels % width, pixels // width], 1).astype(np.float32)[:, None]
    at = (np.arange(SAMPLES, dtype=np.float32) + np.float32(0.5)) / np.float32(SAMPLES)
    samples = middles + np.stack([np.tile(at, SAMPLES), np.repeat(at, SAMPLES)], 1)
    found, spots, counts = _count_samples(seen(samples.reshape(-1, 2)).reshape(-1, WHOLE), samples)
    some = counts > 0
    # solids are convex, so the mean place shows the solid too, except for rounding
    there = seen(spots[some], ((found[some] & LOW) - FIRST).astype(np.int64))
    found[some] = np.where(there == EMPTY, found[some], there)
    front, each = found.argmin(1), np.arange(len(pixels))
    most = counts[each, front]
    depths = depths_of(found.reshape(-1)).reshape(found.shape)
    rest = np.where(some, depths, np.float32(np.inf))
    rest[each, front] = np.inf
    partly = most < WHOLE  # a solid that all samples show is the opaque background, as in the other pixels
    hides[pixels[partly]] = np.where(counts.sum(1) == WHOLE, rest.min(1), np.float32(0))[partly]
    cover = (most % WHOLE).astype(np.float32) / np.float32(WHOLE)
    light = np.zeros((len(pixels), 3), np.float32)
    return Edges(hides, pixels, depths[each, front], cover, light, found, spots, counts)


def _edge_pixels(keys: NDArray[np.uint64], width: int, height: int, seen: Callable[..., Any]) -> NDArray[np.int64]:
    """Return the numbers of the pixels whose solid differs from that of one of the four neighbours, which may be beside
    the picture."""
    x, y = np.arange(width) + 0.5, np.arange(height) + 0.5
    above, left = np.stack([x, np.full(width, -0.5)], 1), np.stack([np.full(height, -0.5), y], 1)
    below, right = above + np.array([0, height + 1]), left + np.array([width + 1, 0])
    beside = seen(np.concatenate([above, below, left, right]).astype(np.float32))
    sides = np.split(identities_of(beside), np.cumsum([width, width, height]))
    shown = np.empty((height + 2, width + 2), np.uint32)
    shown[1:-1, 1:-1] = identities_of(keys).reshape(height, width)
    shown[0, 1:-1], shown[-1, 1:-1], shown[1:-1, 0], shown[1:-1, -1] = sides
    across, down = shown[1:-1, 1:] != shown[1:-1, :-1], shown[1:, 1:-1] != shown[:-1, 1:-1]
    return np.flatnonzero(across[:, 1:] | across[:, :-1] | down[1:] | down[:-1])


def _count_samples(
    keys: NDArray[np.uint64], places: NDArray[np.float32]
) -> tuple[NDArray[np.uint64], NDArray[np.float32], NDArray[np.int64]]:
    """Return the solids that the samples of each pixel show: for each the least key, the mean place and the number of
    its samples, as in `Edges`. keys (E, WHOLE), places (E, WHOLE, 2): of all samples."""
    found = np.full((len(keys), SLOTS), EMPTY)
    spots, counts = np.zeros((len(keys), SLOTS, 2), np.float32), np.zeros((len(keys), SLOTS), np.int64)
    identities, left = identities_of(keys.reshape(-1)).reshape(keys.shape), keys != EMPTY
    some = np.arange(len(keys))
    for slot in range(SLOTS):
        some = some[left[some].any(1)]
        own = identities[some]
        here = left[some]
        if slot < SLOTS - 1:
            first = np.take_along_axis(own, here.argmax(1)[:, None], 1)
            here &= own == first
        found[some, slot] = np.where(here, keys[some], EMPTY).min(1)
        counts[some, slot] = here.sum(1)
        spots[some, slot] = np.where(here[..., None], places[some], np.float32(0)).cumsum(1, dtype=np.float32)[:, -1]
        left[some] &= ~here
    spots /= np.maximum(counts, 1).astype(np.float32)[..., None]
    return found, spots, counts
