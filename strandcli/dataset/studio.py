"""Strands that are made once and drawn from many sides."""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING

import numba
import numpy as np
from numpy.typing import NDArray

from ..cameras.pinhole import Floats, Pinhole
from ..constants import W
from ..draw.common.drawing import Drawing
from ..draw.renderer import Renderer, shadows_of_any_view
from ..run.stages import Notify, RunOptions, SimulationStage
from .layout import Cloud, Labels, labels_of

if TYPE_CHECKING:
    from ..draw.common.scratch import Scratch
    from ..draw.coverage.coverage import Coverage
    from ..scene.model import Scene

ROWS, POINTS = 16, 200_000
"""Points of a strand, and points in all, that strands are measured by, about."""
CLOUD = 20_000
"""Points of strands that a layout may write down, at most."""


class Studio:
    """The strands of a scene at a frame, with what drawing them keeps from view to view."""

    def __init__(self, scene: Scene, frame: int, notify: Notify | None, warn: Notify | None) -> None:
        """Simulate up to the frame. Raises `SimulationError` where that goes wrong."""
        self.scene = scene
        self._at = (frame - 1) / scene.time.fps
        self._stage = SimulationStage(scene, [frame], None, RunOptions(notify=notify, warn=warn))
        self._moved = self._stage.begin(frame)
        self._scratch: Scratch | None = None
        self._coverage: Coverage | None = None
        self._last: Renderer | None = None
        self.points = some_points(self._drawn())
        """(k, 3) metres: of every few strands some points, roots and tips among them."""

    @cached_property
    def cloud(self) -> Cloud:
        """The strands as a whole."""
        middle = 0.5 * (self.points.min(0) + self.points.max(0))
        radius = float(np.linalg.norm(self.points - middle, axis=1).max())
        return Cloud(self.points[:: -(-len(self.points) // CLOUD)], middle, max(radius, 1e-9))

    def draw(self, scene: Scene, view: Pinhole) -> tuple[Labels, Drawing]:
        """Picture and labels of a view; ``scene``: this one's, with the camera, light and colour of the view."""
        moved = self._moved
        renderer = self._renderer(scene)
        drawing = renderer.draw(moved.positions, moved.lengths, self._at, numba.get_num_threads())
        return labels_of(drawing.image, drawing.aovs, view), drawing

    def _drawn(self) -> NDArray[np.float32]:
        """(blocks, rows, 3 W): the strands that are drawn, children, followers and what is combed included."""
        moved, renderer = self._moved, self._renderer(self.scene)
        tones, ids = renderer.tones, renderer.ids
        if renderer.children is not None:
            tones, ids = renderer.children.select(moved.positions)
        nothing = Drawing(np.empty((0, 0, 3), np.uint8))
        strands = renderer.drawn.at(self.scene, self._at, moved.positions, moved.lengths, tones, ids, nothing)
        return strands.positions

    def _renderer(self, scene: Scene) -> Renderer:
        """A renderer of the strands in a scene, with memory that the one before it had; the same one where nothing but
        the camera is another, so that shadows stay."""
        stage, moved, last = self._stage, self._moved, self._last
        if last is not None and replace(scene, camera=last.scene.camera) == last.scene:
            last.scene = scene
            return last
        groom = stage.groom if moved.groom is None else moved.groom
        renderer = Renderer(scene, groom, stage.children, stage.combed)
        renderer.tones, renderer.ids = moved.tones, moved.ids
        renderer.keeps_light = shadows_of_any_view(scene)
        if self._scratch is not None:
            renderer.scratch = renderer.drawn.scratch = self._scratch
            if self._coverage is not None and self._coverage.size == renderer.size:
                renderer.coverage = self._coverage
        self._scratch, self._coverage, self._last = renderer.scratch, renderer.coverage, renderer
        return renderer


def some_points(positions: NDArray[np.float32]) -> Floats:
    """(k, 3) points of strands in blocks (blocks, rows + 1, 3 W): some rows, roots and tips among them, of so many
    strands that there are about `POINTS`."""
    blocks, rows, _ = positions.shape
    chosen = np.unique(np.linspace(1, rows - 1, min(ROWS, rows - 1)).astype(np.int64))
    step = min(max(blocks * W * len(chosen) // POINTS, 1), W)
    some = positions.reshape(blocks, rows, 3, W)[:, chosen, :, ::step]
    return some.transpose(0, 1, 3, 2).reshape(-1, 3).astype(np.float64)
