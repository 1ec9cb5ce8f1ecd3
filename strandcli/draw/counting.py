"""A renderer that also counts what each stage of a frame works on, for `strandcli bench PRESET`.

Counting takes time that no stage is charged with: the clock of the `Drawing` stands still meanwhile. A plain `Renderer`
counts none of this.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .canvas import Canvas
from .common.drawing import Drawing, ProcessorDrawing
from .common.kernels.keys import EMPTY, FIRST, LOW
from .common.scratch import Scratch
from .coverage.coverage import Coverage, Layer
from .geometry.curves import Polylines
from .lighting.lighting import Lighting
from .renderer import Renderer
from .shadows.shadow import ShadowMaps
from .shadows.strands_in_map import project
from .strand_batches import StrandBatch, StrandBatches, Strands
from .zbuffer.kernels.lines import count_samples

Counts = dict[str, int]


@contextmanager
def unclocked(drawing: Drawing) -> Iterator[None]:
    """What is done inside is charged to no stage."""
    began = drawing.now()
    yield
    drawing.clock += drawing.now() - began


class CountingRenderer(Renderer):
    """Draws the same pictures. The counts of a `Drawing` have besides those of `Renderer`, summed over exposures:

    ``child_particles``; ``vertices`` of polylines and ``strand_vertices_in_maps``; ``map_layers`` and ``map_numbers``
    of opacity maps; ``map_texels``, samples of min/max maps that lines pass through;
    ``fragments_found`` and ``fragments_blended`` of sorted strands; ``line_samples`` that lines pass through and
    ``strand_samples`` that show one, of the z-buffer; ``lit_vertices``; ``solid_samples``; ``samples`` of the picture;
    ``lights`` and ``lights_with_maps``.
    """

    def __init__(self, *args: Any, **named: Any) -> None:
        super().__init__(*args, **named)
        self.work: Counts = {}
        if self.coverage is not None:
            self.coverage = _CountingCoverage(self.size, self.scene.material.opacity, self)

    def count(self, name: str, number: int) -> None:
        """Add to a count."""
        self.work[name] = self.work.get(name, 0) + number

    def draw(self, *args: Any, **named: Any) -> Drawing:
        """As `Renderer.draw`, with the counts."""
        self.work = {}
        drawing = super().draw(*args, **named)
        drawing.counts |= self.work
        return drawing

    def shade(
        self, lighting: Lighting, batch: StrandBatch, marks: NDArray[np.uint8], visibility: NDArray[np.float32] | None
    ) -> NDArray[np.float32]:
        """As `Renderer.shade`; counts the vertices that are lit."""
        with unclocked(self._drawing):
            self.count("lit_vertices", int(np.count_nonzero(marks)))
            if self.coverage is None:
                self.count("vertices", len(batch.lines.world))
                self.count("line_samples", samples_of(batch.lines.first, batch.screen, self.size))
        return super().shade(lighting, batch, marks, visibility)

    def _fill_maps(self, maps: ShadowMaps, batches: StrandBatches, lines: Polylines | None, workers: int) -> None:
        super()._fill_maps(maps, batches, lines, workers)
        self._drawing.lap("shadow")
        with unclocked(self._drawing):
            for polylines in batches.lines() if lines is None else (lines,):
                for name, number in count_in_maps(maps, polylines, self.scratch).items():
                    self.count(name, number)
            self.count("map_numbers", 0 if maps.stacks is None else len(maps.stacks))
            self.work["map_layers"] = max(maps.layers)

    def _note_counts(self, strands: Strands, canvas: Canvas) -> None:
        super()._note_counts(strands, canvas)
        with unclocked(self._drawing):
            if self.children is not None:
                self.count("child_particles", strands.count * (strands.positions.shape[1] - 1))
            if self.coverage is None:
                self.count("strand_samples", canvas.fragments)
            else:
                self.count("fragments_found", canvas.fragments)
                self.count("vertices", canvas.segments + self._drawing.counts["strands"])
            solid = (canvas.keys != EMPTY) & ((canvas.keys & LOW) >= FIRST)
            self.count("solid_samples", int(np.count_nonzero(solid)))
            self.count("samples", len(canvas.keys))
            self.work["lights"] = len(self.scene.lights)
            maps = canvas.lighting.maps
            self.work["lights_with_maps"] = 0 if maps is None else sum(number > 0 for _, number in maps.owners)


class ProcessorRenderer(CountingRenderer):
    """A `CountingRenderer` whose times are those of the processor."""

    clocked = ProcessorDrawing


class _CountingCoverage(Coverage):
    """Counts the fragments that are blended with the picture."""

    def __init__(self, size: tuple[int, int], opacity: float, renderer: CountingRenderer) -> None:
        super().__init__(size, opacity)
        self._renderer = renderer

    def layers(self, *args: Any, **named: Any) -> Iterator[Layer]:
        """As `Coverage.layers`."""
        for layer in super().layers(*args, **named):
            with unclocked(self._renderer._drawing):
                self._renderer.count("fragments_blended", int(layer.fragments.counts.sum(dtype=np.int64)))
            yield layer


def count_in_maps(maps: ShadowMaps, lines: Polylines, scratch: Scratch) -> Counts:
    """Return what the polylines draw into maps: ``strand_vertices_in_maps`` and ``map_texels``."""
    found = {"strand_vertices_in_maps": 0, "map_texels": 0}
    simple = maps.simplified(lines, scratch)
    for number, view in enumerate(maps.views):
        first, screen = project(simple if maps.layers[number] else lines, view, scratch)
        size = int(maps.sizes[number])
        found["strand_vertices_in_maps"] += len(screen)
        if not maps.layers[number]:
            found["map_texels"] += samples_of(first, screen, (size,) * 2)
    return found


def samples_of(first: NDArray[np.int64], screen: NDArray[np.float32], size: tuple[int, int]) -> int:
    """Return through how many samples of a buffer the middle lines of projected strands pass."""
    counts = np.zeros(len(first) - 1, np.int64)
    count_samples(first, screen, *size, counts)
    return int(counts.sum())
