"""Occupancy maps (Sintorn & Assarsson 2009) as a foil of the resolver `sorted`; presets cannot ask for it.

On a GPU they do without lists of fragments and without sorting. Here both ways get the same lists, unsorted, and each
is timed by itself: what is left of the comparison is what the approximation saves of sorting, and its error. On a CPU
it saves nothing: of `portrait` (`strandcli study portrait --axis coverage --threads 2`: 2,000 strands, 223,348
fragments, 2.45 GHz) sorting the lists and laying them over the picture takes 2.1 ms, occupancy 4.6 ms with 128 slices
and 3.8 ms with 32; it is 2.8 % off the sorted picture, where that is 3.6 % off 16×16 samples and occupancy 4.5 %. More
slices do not help, because what it assumes is that all strands of a pixel are as opaque.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...draw.coverage.coverage import Coverage, Layer
from ..kernels import occupancy as kernel
from .subject import LinearRenderer

SLICES, SLABS = 128, 4
"""The paper's."""


@dataclass
class _Layer:
    """A layer that is laid over the picture by occupancy."""

    sorted: Layer
    screen: NDArray[np.float32]
    owner: _Coverage

    @property
    def marks(self) -> NDArray[np.uint8]:
        return self.sorted.marks

    @property
    def top(self) -> int:
        return self.sorted.top

    def compose(self, colours: NDArray[np.float32], image: NDArray[np.float32]) -> None:
        """Both ways, timed; the picture has the foil's."""
        begin, place, weight, along = fragments_of(self.sorted, image.shape[1])
        alpha, depth = np.empty_like(weight), np.empty_like(weight)
        stride, owner = self.sorted.stride, self.owner
        kernel.undo(begin, place, weight, along, stride, self.screen, alpha, depth)
        rows = slice(self.top, self.sorted.bottom)
        exact = image[rows].reshape(-1, 3).copy()
        began = time.perf_counter()
        kernel.in_order(begin, place, alpha, along, depth, stride, colours, self.sorted.light, exact)
        middle = time.perf_counter()
        foil = image[rows].reshape(-1, 3)
        kernel.by_occupancy(begin, place, alpha, along, depth, owner.slices, owner.slabs, stride, colours,
                            self.sorted.light, foil)
        owner.seconds[-1] += middle - began, time.perf_counter() - middle

    def round_off(self, body: Any, image: NDArray[np.float32]) -> None:
        """Wide strands are left flat."""


class _Coverage(Coverage):
    slices, slabs = SLICES, SLABS

    def __init__(self, *args: Any) -> None:
        super().__init__(*args)
        self.seconds: list[NDArray[np.float64]] = []
        """Of each picture."""

    def layers(self, lines: Any, screen: Any, *rest: Any) -> Iterator[Any]:
        self.seconds.append(np.zeros(2))
        for layer in super().layers(lines, screen, *rest):
            yield _Layer(layer, screen, self)


class OccupancyRenderer(LinearRenderer):
    """Draws with occupancy maps in place of sorting. `seconds` (2,): what sorting the fragments of a picture and
    laying them over it took, and what occupancy took, at the least."""

    def take_over(self, slices: int, slabs: int) -> None:
        """Resolve with so many slices, a multiple of the number of slabs."""
        self.coverage = _Coverage(self.size, self.scene.material.opacity, None)
        self.coverage.slices, self.coverage.slabs = slices, slabs

    @property
    def seconds(self) -> NDArray[np.float64]:
        assert isinstance(self.coverage, _Coverage)
        return np.min(self.coverage.seconds, 0)


def fragments_of(
    layer: Layer, width: int
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float32], NDArray[np.float32]]:
    """Pixel after pixel, each from front to back: where pixels begin (P + 1,), then of each fragment the lit vertex
    before it, its share of the pixel's light, and its place from that vertex to the next."""
    counts = np.empty((layer.bottom - layer.top) * width, np.int64)
    kernel.counted(layer.kept, layer.top, layer.bottom, width, counts)
    first = np.concatenate([[0], np.cumsum(counts)])
    size = int(first[-1])
    place, weight, along = np.empty(size, np.int64), np.empty(size, np.float32), np.empty(size, np.float32)
    kernel.listed(
        layer.begin, layer.kept, layer.place, layer.weight, layer.along, layer.top, layer.bottom, width, first, place,
        weight, along,
    )  # fmt: skip
    return first, place, weight, along
