"""Antialiased edges of solids for sorted strands, which may lie in front of, between and behind the solids.

A pixel whose solid differs from a neighbour's, which may be beside the picture, is resolved with 4×4 samples. The
solid in front becomes a fragment, sorted among those of strands, whose opacity is the share of the samples that show
it. The mean of the other samples is the background over which all fragments are composited. As with strands, partial
coverage is taken to be uncorrelated with position in the pixel. Creases of a box, and solids so small that they lie
between pixel centres, are not antialiased.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...solids import Solids
from ..common.scratch import Scratch
from ..view.camera import View
from .kernels import edge_pixels
from .kernels import edges as kernel
from .solids import frames_of

Shade = Callable[[NDArray[np.uint64], NDArray[np.float32], NDArray[np.float32]], None]


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
    spots: NDArray[np.float32]
    counts: NDArray[np.int64]
    """All solids in these pixels, as written by `kernels.edges.sample`."""

    def within(self, begin: int, end: int) -> Edges:
        """Return the edges in the pixels begin … end − 1, in the same arrays."""
        here = slice(*np.searchsorted(self.pixels, (begin, end)).tolist())
        return Edges(
            self.hides, self.pixels[here], self.depth[here], self.cover[here], self.light[here], self.keys[here],
            self.spots[here], self.counts[here],
        )  # fmt: skip

    def composite(self, shade: Shade, image: NDArray[np.float32], backdrop: NDArray[np.float32]) -> None:
        """Write what the edge pixels show behind the solid in front to the picture (height, width, 3), and set `light`.

        ``shade`` shades surfaces: z-buffer keys, a picture that contains the background, and the pixels' positions on
        the screen (pixels, 2). ``backdrop`` (height, width, 3).
        """
        behind = backdrop.reshape(-1, 3)[self.pixels]
        colours = np.ascontiguousarray(np.repeat(behind[:, None], kernel.SLOTS, 1))
        shade(self.keys.reshape(-1), colours, self.spots.reshape(-1, 2))
        image.reshape(-1, 3)[self.pixels] = behind
        kernel.composite(self.pixels, self.keys, self.counts, colours, self.light, image)


def find_edges(keys: NDArray[np.uint64], packed: Solids, view: View, size: tuple[int, int], scratch: Scratch) -> Edges:
    """Return the edges in a z-buffer of solids, ``keys`` (height * width,); size: width and height in pixels."""
    width, height = size
    hides = scratch.borrow("hides", len(keys), np.float32)
    kernel.depths(keys, hides)
    ends = scratch.borrow("ends", len(keys), np.uint8)
    frames, beside = frames_of(packed, view), np.empty(2 * (width + height), np.uint64)
    edge_pixels.look_outside(width, height, view.pack(), packed, frames, beside)
    edge_pixels.find(keys, beside, width, height, ends)
    found = edges_at(hides, np.flatnonzero(ends.view(bool)))
    kernel.sample(found.pixels, width, view.pack(), packed, frames, found.keys, found.spots, found.counts)
    kernel.part(found.pixels, found.keys, found.counts, hides, found.depth, found.cover)
    return found


def edges_at(hides: NDArray[np.float32], pixels: NDArray[np.int64]) -> Edges:
    """Return edges at these pixels, not yet filled."""
    count = len(pixels)
    return Edges(
        hides, pixels, np.zeros(count, np.float32), np.zeros(count, np.float32), np.zeros((count, 3), np.float32),
        np.zeros((count, kernel.SLOTS), np.uint64), np.zeros((count, kernel.SLOTS, 2), np.float32),
        np.zeros((count, kernel.SLOTS), np.int64),
    )  # fmt: skip
