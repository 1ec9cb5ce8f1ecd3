"""What a run hands on for every frame, and the second stage of one: strands that have been moved are drawn."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from ..draw.renderer import Renderer
    from ..groom.record import Groom
    from .stages import MovedStrands, SimulationStage


@dataclass
class Frame:
    """One finished frame."""

    number: int
    image: NDArray[np.uint8] | None
    """(height, width, 3) sRGB, or (height, width, 4) with straight alpha where `image.background` is none; None where
    nothing was drawn."""
    positions: NDArray[np.float32] | None
    """(strands, particles, 3) metres, where they were asked for."""
    report: dict[str, Any]
    """Seconds a stage, counts and errors, as in report.json."""
    aovs: dict[str, NDArray[Any]] = field(default_factory=dict)
    """Layers that ``image.aovs`` asks for, by name: (height, width) or (height, width, 3); see `draw.aovs`."""


class FrameRenderer:
    """Draws frames, with memory of its own."""

    def __init__(self, moved: SimulationStage, kind: type[Renderer] | None = None) -> None:
        """``kind``: of the renderer, if not `Renderer` itself."""
        from ..draw.renderer import Renderer

        self._scene, self._fps = moved.scene, moved.scene.time.fps
        self._renderer = (kind or Renderer)(moved.scene, moved.groom, moved.children, moved.combed)
        self._first = self._renderer

    def __call__(self, moved: MovedStrands) -> Frame:
        """The frame with its picture."""
        import numba

        frame = moved.frame
        at = (frame.number - 1) / self._fps
        self._renderer = self._first if moved.groom is None else self._of_groom(moved.groom)
        if self._scene.camera.views:
            from ..cameras.read import at_frame

            self._renderer.scene = at_frame(self._scene, frame.number)
        self._renderer.tones = moved.tones
        self._renderer.ids = moved.ids
        drawing = self._renderer.draw(moved.positions, moved.lengths, at, numba.get_num_threads(), moved.before)
        frame.image = drawing.image
        frame.aovs = drawing.aovs
        frame.report["threads"] = numba.get_num_threads()
        frame.report["seconds"] |= drawing.seconds
        frame.report["counts"] |= drawing.counts
        frame.report["error"]["curve_px_max"] = drawing.curve_px_max
        if drawing.follow_stretch_max is not None:
            frame.report["error"]["follow_stretch_max"] = drawing.follow_stretch_max
        return frame

    def _of_groom(self, groom: Groom) -> Renderer:
        """A renderer of other strands of a file, with the memory of the first one."""
        assert groom.points is not None
        first, scene = self._first, self._scene
        emitter = replace(scene.emitter, strands=groom.strands, particles=groom.points.shape[1] - 1)
        found = type(first)(replace(scene, emitter=emitter), groom)
        found.scratch = found.drawn.scratch = first.scratch
        found.coverage = first.coverage
        return found
