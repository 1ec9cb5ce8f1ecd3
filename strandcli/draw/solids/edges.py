"""The edges of solids under sorted strands: antialiased, with strands before, between and behind.

A pixel whose solid is another one than a neighbour's, or that lies at the picture's border, is seen by 4×4 samples. The
solid in front becomes a fragment of its own, sorted among those of strands, whose opacity is the share of the samples
that show it; what the others show, mixed, stays as what all fragments are laid over. As with strands, what covers a
pixel in part is taken to lie anywhere in it. Creases of a box, and solids so small that they lie between the middles of
pixels, are left as they are.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...solids import Solids
from ..common.scratch import Scratch
from ..view.camera import View
from .kernels import edges as kernel
from .solids import frames_of

Shade = Callable[[NDArray[np.uint64], NDArray[np.float32], NDArray[np.float32]], None]


@dataclass(frozen=True)
class Edges:
    """What solids hide, and the E pixels that one of them covers in part."""

    hides: NDArray[np.float32]
    """(height * width,) depth number of the solid that hides all that is behind it, 0 where there is none."""
    pixels: NDArray[np.int64]
    """(E,) in the order of rows."""
    depth: NDArray[np.float32]
    """(E,) depth number of the solid in front."""
    cover: NDArray[np.float32]
    """(E,) its share of the pixel."""
    light: NDArray[np.float32]
    """(E, 3) its radiance, once `lay` has been called."""
    keys: NDArray[np.uint64]
    spots: NDArray[np.float32]
    counts: NDArray[np.int64]
    """Of all solids there, as `kernels.edges.sample` leaves them."""

    def lay(self, shade: Shade, image: NDArray[np.float32], backdrop: NDArray[np.float32]) -> None:
        """Put what solids show at edges behind that in front into the picture (height, width, 3).

        ``shade`` lights surfaces: keys of a picture, the picture itself, which holds the background before, and
        its pixels' places on the screen (pixels, 2).
        """
        behind = backdrop.reshape(-1, 3)[self.pixels]
        colours = np.ascontiguousarray(np.repeat(behind[:, None], kernel.SLOTS, 1))
        shade(self.keys.reshape(-1), colours, self.spots.reshape(-1, 2))
        image.reshape(-1, 3)[self.pixels] = behind
        kernel.lay(self.pixels, self.keys, self.counts, colours, self.light, image)


def none(hides: NDArray[np.float32]) -> Edges:
    """No pixel that is covered in part."""
    return _edges(hides, np.zeros(0, np.int64))


def find_edges(
    keys: NDArray[np.uint64], packed: Solids, view: View, size: tuple[int, int], scratch: Scratch
) -> Edges:
    """The edges in a z-buffer of solids, (height * width,), packed by `strandcli.solids.pack`."""
    width, height = size
    hides = scratch.take("hides", len(keys), np.float32)
    kernel.depths(keys, hides)
    ends = scratch.take("ends", len(keys), np.uint8)
    begin = np.zeros(height + 1, np.int64)
    kernel.find(keys, width, height, ends, begin[1:])
    np.cumsum(begin, out=begin)
    found = _edges(hides, np.zeros(int(begin[-1]), np.int64))
    kernel.collect(ends, width, begin, found.pixels)
    kernel.sample(
        found.pixels, width, view.pack(), packed, frames_of(packed, view), found.keys, found.spots, found.counts
    )
    kernel.part(found.pixels, found.keys, found.counts, hides, found.depth, found.cover)
    return found


def _edges(hides: NDArray[np.float32], pixels: NDArray[np.int64]) -> Edges:
    count = len(pixels)
    return Edges(
        hides, pixels, np.zeros(count, np.float32), np.zeros(count, np.float32), np.zeros((count, 3), np.float32),
        np.zeros((count, kernel.SLOTS), np.uint64), np.zeros((count, kernel.SLOTS, 2), np.float32),
        np.zeros((count, kernel.SLOTS), np.int64),
    )  # fmt: skip
