"""What a picture lets through of what it is put over, where it has no background.

A picture is linear in its background: light + transmittance · background, of each pixel. The transmittance is what the
same strands and solids give without any light before a white background. It is drawn with the kernels that draw the
light, so all that hides a part of the background counts: strands, solids, their edges, how they fade, haze.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .common.kernels.keys import EMPTY, FIRST, LOW
from .common.scratch import Scratch
from .coverage.coverage import Layer
from .film.film import veil_solids, veil_strands
from .film.kernels import film
from .lighting.lighting import NO_SPOTS, NOT_HIDDEN, Lighting
from .solids.edges import Edges
from .strand_batches import StrandBatch


def draw_solids(
    lighting: Lighting, keys: NDArray[np.uint64], image: NDArray[np.float32],
    spots: NDArray[np.float32] = NO_SPOTS, hidden: NDArray[np.uint8] = NOT_HIDDEN, rows: tuple[int, int] | None = None,
) -> None:  # fmt: skip
    """Shade solids with `Lighting.shade_surfaces`, and apply haze if there is any."""
    thick = lighting.scene.image.haze
    top, bottom = rows or (0, len(image))
    behind = None if thick is None else image[top:bottom].copy()
    if lighting.like is not None and not lighting.fades:
        blacken(keys, image, hidden, (top, bottom))
    else:
        lighting.shade_surfaces(keys, image, spots, hidden, rows)
    if thick is not None and behind is not None:
        here = slice(top * image.shape[1], bottom * image.shape[1])
        veil_solids(thick, lighting.view, behind, keys[here], image[top:bottom], hidden[here])


def blacken(
    keys: NDArray[np.uint64], image: NDArray[np.float32], hidden: NDArray[np.uint8], rows: tuple[int, int]
) -> None:
    """Blacken the pixels that show a solid: what `shade_surfaces` does without light where none fades."""
    width = image.shape[1]
    here = slice(rows[0] * width, rows[1] * width)
    there = (keys[here] != EMPTY) & ((keys[here] & LOW) >= FIRST)
    if len(hidden):
        there &= hidden[here] == 0
    image.reshape(-1, 3)[here][there] = 0


class Transmittance:
    """The transmittance of a picture so far: call its methods as those of `Canvas` draw the light."""

    def __init__(self, lighting: Lighting, size: tuple[int, int], scratch: Scratch) -> None:
        """``size``: width and height, samples."""
        self.lighting = lighting.without_light()
        self.image: NDArray[np.float32] = scratch.borrow("transmittance", (size[1], size[0], 3), np.float32)
        """(height, width, 3), alike in the channels."""
        self.image.fill(1)
        self._white = np.broadcast_to(np.float32(1), self.image.shape)
        self._edge_light = self._veils = np.zeros((0, 3), np.float32)

    def solids(self, keys: NDArray[np.uint64], **where: Any) -> None:
        """Draw the solids of a z-buffer; where: as in `draw_solids`."""
        draw_solids(self.lighting, keys, self.image, **where)

    def edges(self, edges: Edges, begin: int, end: int) -> None:
        """Draw the edges of solids in the pixels begin … end − 1."""
        if len(self._edge_light) != len(edges.light):
            self._edge_light = np.zeros_like(edges.light)
        here = replace(edges, light=self._edge_light).within(begin, end)
        here.composite(partial(draw_solids, self.lighting), self.image, self._white)

    def layer(self, layer: Layer, batch: StrandBatch) -> None:
        """Draw the strands of a layer, and the solids at whose edges it has fragments."""
        light = self._edge_light if len(layer.light) else layer.light
        replace(layer, light=light).blend(self._veil(batch, layer.marks), self.image)

    def batch(self, keys: NDArray[np.uint64], base: int, batch: StrandBatch, marks: NDArray[np.uint8]) -> None:
        """Draw the strands of a batch that a z-buffer shows; base: number of their first vertex in the keys."""
        lines = batch.lines
        film.colours(keys, base, batch.screen, lines.per, lines.stride, self._veil(batch, marks), self.image)

    def _veil(self, batch: StrandBatch, marks: NDArray[np.uint8]) -> NDArray[np.float32]:
        """Return what haze lets through (V, 3) of the background before the vertices with marks."""
        if len(self._veils) != len(batch.lines.world):
            self._veils = np.zeros((len(batch.lines.world), 3), np.float32)  # pages that nothing reads take no memory
        thick = self.lighting.scene.image.haze
        if thick is not None:
            self._veils[marks != 0] = 0
            white = np.ones((1, 1, 3), np.float32)
            veil_strands(thick, self.lighting.view, white, batch.screen, marks, self._veils, None)
        return self._veils
