"""The linear picture of an exposure, onto which strands and solids are drawn.

Visibility is resolved before light is computed, so that hidden vertices are never shaded: the z-buffer holds the
segment in front of each sample, or fragments are sorted by depth and those behind opaque ones are left out.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .common.drawing import Drawing
from .common.kernels.keys import EMPTY, FIRST
from .common.scratch import Scratch
from .coverage.coverage import Coverage, Layer, Rows
from .coverage.kernels.resolve import CLOSED
from .coverage.kernels.width_profiles import add_to_zbuffer
from .film.aovs import Recorder
from .film.film import veil_strands
from .film.kernels import film
from .geometry.curves import Polylines
from .lighting.lighting import Lighting
from .shadows.vertex_shadows import VertexShadows
from .solids import triangles
from .solids.edges import ALL, PIXELS, Edges, find_edges
from .solids.kernels import visible
from .solids.solids import frames_of
from .strand_batches import StrandBatch
from .transmittance import Transmittance, draw_solids
from .zbuffer import raster

Shade = Callable[[Lighting, StrandBatch, NDArray[np.uint8], NDArray[np.float32] | None], NDArray[np.float32]]
"""Returns the radiance at marked vertices (see `strandcli.draw.renderer.Renderer.shade`)."""


class Exposed(NamedTuple):
    """One exposure, or the mean of several."""

    parts: Sequence[NDArray[np.float32]]
    """As `Canvas.parts`."""
    light: Lighting | None
    """How it was lit."""


@dataclass
class Canvas:
    """The picture so far: call `composite_sorted` once, or `rasterise` for each batch and then `finish`."""

    size: tuple[int, int]
    """Width and height, samples."""
    backdrop: NDArray[np.float32]
    """(height, width, 3) linear."""
    lighting: Lighting
    shadows: Sequence[VertexShadows]
    """One for each light whose shadow model shades vertices."""
    shade: Shade
    recorder: Recorder | None
    """Records AOVs, if the scene has any."""
    workers: int
    drawing: Drawing
    scratch: Scratch
    segments: int = 0
    """Number of segments drawn, for each band of rows that their strand comes to."""
    fragments: int = 0
    """Samples that show a strand; of sorted strands, all fragments, also those behind solids."""
    keys: NDArray[np.uint64] = field(init=False)
    """(height * width,) the z-buffer, with the solids from the beginning."""
    image: NDArray[np.float32] = field(init=False)
    """(height, width, 3) linear."""
    through: Transmittance | None = field(init=False, default=None)
    """Of a picture without background."""
    _base: int = 0
    """Number of the next batch's first vertex."""
    _batches: int = 0
    """Number of batches drawn."""

    def __post_init__(self) -> None:
        width, height = self.size
        self.keys = self.scratch.borrow("keys", width * height, np.uint64)
        if self.lighting.solids is not None:
            shown = self.scratch.borrow("triangles", width * height, np.int32)
            shown.fill(-1)
            self.lighting = replace(self.lighting, triangles=shown)
        clear(self.keys, self.size, self.lighting)
        if self.recorder is not None:
            self.recorder.solids(self.keys, self.lighting, self.scratch)
        self.drawing.lap("raster")
        self.image = self.scratch.borrow("image", (height, width, 3), np.float32)
        np.copyto(self.image, self.backdrop)
        if self.lighting.scene.image.has_alpha:
            self.through = Transmittance(self.lighting, self.size, self.scratch)
        self.drawing.lap("film")

    @property
    def parts(self) -> Sequence[NDArray[np.float32]]:
        """The image, and its transmittance if it has no background."""
        return (self.image,) if self.through is None else (self.image, self.through.image)

    def composite_sorted(self, bands: Iterable[tuple[StrandBatch, Rows]], coverage: Coverage) -> None:
        """Composite bands of rows, from top to bottom, each with the strands that come to it, over the solids, sorted
        by depth in each pixel."""
        light = self.lighting
        front = None if self.recorder is None else self.keys.copy()
        edges = None
        if light.solids is not None:
            edges = find_edges(self.keys, light.solids, light.view, self.size, self.scratch)
        self.drawing.lap("raster")
        for batch, rows in bands:
            self._band(batch, rows, coverage, edges, front)
            self._base += len(batch.lines.world)
            self.segments += batch.lines.segments
            del batch  # before the next is made
        if self.recorder is not None and front is not None:
            self.recorder.rest(front, light)
        self.fragments = coverage.fragments

    def _band(
        self, batch: StrandBatch, rows: Rows, coverage: Coverage, edges: Edges | None, front: NDArray[np.uint64] | None
    ) -> None:  # fmt: skip
        """Composite a band of rows; front: a z-buffer of the strands in front, for AOVs."""
        lines, screen, view = batch.lines, batch.screen, self.lighting.view
        self.scratch.borrow("colours", lines.world.shape, np.float32)  # the last that memory is taken for in turns
        self.scratch.let_go()
        for layer in coverage.layers(
            lines, screen, batch.widths, edges, self.workers, self.scratch, view.depth_slope, rows
        ):
            self.drawing.lap("raster")
            if edges is not None:
                self._behind(layer, edges)
            self._blend(layer, batch)
            if self.recorder is not None and front is not None:
                self.recorder.layer(layer, lines, screen, self._base, front)
            self.drawing.lap("film")
        if self.recorder is not None and front is not None:
            self.recorder.strands(lines, screen, front, self._base, batch.begin, view)

    def _behind(self, layer: Layer, edges: Edges) -> None:
        """Shade the solids in the rows of a layer, but where its strands hide them wholly."""
        rows, width = (layer.fragments.top, layer.fragments.bottom), self.size[0]
        begin, end = rows[0] * width, rows[1] * width
        here, hidden = edges.within(begin, end), layer.fragments.closed
        here.keys[hidden[here.pixels] == CLOSED] = EMPTY  # no light of theirs is seen
        hidden[here.pixels] = 1  # they are drawn by themselves
        draw = partial(draw_solids, self.lighting)
        draw(self.keys, self.image, hidden=hidden, rows=rows)
        here.composite(draw, self.image, self.backdrop)
        if self.through is not None:
            self.through.solids(self.keys, hidden=hidden, rows=rows)
            self.through.edges(edges, begin, end)

    def _blend(self, layer: Layer, batch: StrandBatch) -> None:
        """Shade the vertices of a layer, and blend it with the picture."""
        layer.blend(self._shade(batch, layer.marks), self.image)
        if batch.profiles is not None:
            layer.add_departures(batch.profiles, self.image)
        if self.through is not None:
            self.through.layer(layer, batch)

    def rasterise(self, batch: StrandBatch) -> None:
        """Draw a batch into the z-buffer, shade the vertices visible so far, and colour the samples that show them."""
        lines, screen = batch.lines, batch.screen
        raster.draw(
            lines, screen, batch.widths, self._base, self.size, self.workers, self.scratch, self.keys,
            self.lighting.view.depth_slope,
        )  # fmt: skip
        if self.recorder is not None:
            self.recorder.strands(lines, screen, self.keys, self._base, batch.begin, self.lighting.view)
        self.drawing.lap("raster")
        marks, seen = mark(self.keys, lines, self._base, self.scratch)
        colours = self._shade(batch, marks)
        film.colours(self.keys, self._base, screen, lines.per, lines.stride, colours, self.image)
        if batch.profiles is not None:
            add_to_zbuffer(self.keys, self._base, lines.per, lines.stride, batch.profiles, self.image)
        if self.through is not None:
            self.through.batch(self.keys, self._base, batch, marks)
        self.drawing.lap("film")
        self.fragments = seen
        self.segments += lines.segments
        self._base += len(lines.world)
        self._batches += 1

    def finish(self) -> None:
        """Shade the visible solids, after the last batch."""
        if self._batches > 1:  # a later batch may hide fragments counted in an earlier one
            self.fragments = int(np.count_nonzero((self.keys & np.uint64(0xFFFFFFFF)) < FIRST))
        draw_solids(self.lighting, self.keys, self.image)
        if self.through is not None:
            self.through.solids(self.keys)
        self.drawing.lap("shade")
        if self.recorder is not None:
            self.recorder.rest(self.keys, self.lighting)

    def _shade(self, batch: StrandBatch, marks: NDArray[np.uint8]) -> NDArray[np.float32]:
        """Return the radiance (V, 3) at the marked vertices."""
        visibility = None
        if self.shadows:
            visibility = self.scratch.borrow("visibility", (len(self.shadows), len(batch.lines.world)), np.float32)
            for row, shadows in zip(visibility, self.shadows, strict=True):
                shadows.visibility(batch.lines, marks, batch.screen, row)
            self.drawing.lap("shadow")
        colours = self.shade(self.lighting, batch, marks, visibility)
        thick = self.lighting.scene.image.haze
        if thick is not None:
            veil_strands(
                thick, self.lighting.view, self.backdrop, batch.screen, marks, colours, batch.profiles
            )  # fmt: skip
        self.drawing.lap("shade")
        return colours


def clear(keys: NDArray[np.uint64], size: tuple[int, int], lighting: Lighting) -> None:
    """Clear a z-buffer (height * width,) and draw the solids into it, and into `Lighting.triangles` where it has
    any."""
    if lighting.solids is None:
        keys.fill(EMPTY)
    else:
        view = lighting.view
        frames = frames_of(lighting.solids, view)
        found = triangles.surfaces(lighting.solids, view)
        by_rays = frames.copy()
        by_rays[[one.number for one in found]] = 0
        if by_rays.any():
            visible.find(PIXELS, ALL, size[0], view.pack(), lighting.solids, by_rays, keys)
        else:
            keys.fill(EMPTY)
        for one in found:
            triangles.draw(one, frames[one.number], view, size, keys, lighting.triangles)


def mark(keys: NDArray[np.uint64], lines: Polylines, base: int, scratch: Scratch) -> tuple[NDArray[np.uint8], int]:
    """Return marks (V,), not 0 at the lit vertices that the z-buffer shows, and the number of samples that show these
    strands; base: number of their first vertex in the keys."""
    marks = scratch.borrow("marks", len(lines.world), np.uint8)
    marks.fill(0)
    listed = scratch.borrow("listed", (3, film.PART), np.int32)
    return marks, film.mark(keys, base, len(lines.world), lines.per, lines.stride, listed, marks)
