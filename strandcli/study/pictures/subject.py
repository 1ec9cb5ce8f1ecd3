"""A preset's frame as something to be measured: strands moved once, then drawn at any setting, in linear light."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...draw.common.drawing import ProcessorDrawing
from ...draw.common.scratch import Scratch
from ...draw.geometry.spacing import spacing_at, spacing_of
from ...draw.renderer import Renderer
from ...draw.view.camera import View, camera_view
from ...errors import SimulationError, UsageError
from ...groom.children import Children
from ...groom.combed import Combed
from ...groom.emit import emit
from ...plan import checked_plan
from ...scene.model import Scene
from ..sweep import Request, changed

STRANDS = 2000
"""Of a preset, where not said otherwise."""
PIXELS = 30_000
"""Of a picture, about, where not said otherwise."""
DRAWS = 3
"""Times that a setting is drawn; a stage takes the least of its times."""


@dataclass
class Picture:
    """One picture in linear light, and what it took."""

    image: NDArray[np.float64]
    """(height, width, 3), exposure not applied."""
    seconds: dict[str, float]
    """By stage."""
    counts: dict[str, int]
    pixels: NDArray[np.uint8] | None = None
    """(height, width, 3) sRGB, as it would be written."""

    aovs: dict[str, NDArray[Any]] = field(default_factory=dict)
    """Layers that the scene asks for."""


class LinearRenderer(Renderer):
    """Keeps the picture as it is before exposure and encoding."""

    def develop(self, image: NDArray[np.float32], *rest: Any) -> Any:
        width, height = self.scene.image.drawn
        samples = image.shape[0] // height
        self.linear = (
            image.reshape(height, samples, width, samples, 3).mean((1, 3), dtype=np.float64) if samples else None
        )
        return super().develop(image, *rest)


class Subject:
    """The first strands that a preset draws at one frame: those that are simulated, or their children.

    Children are grown once; whatever is drawn of them afterwards is drawn as if they had been simulated.

    Lines of no width, a sample wide whatever the sampling, have no finer picture to be compared with: such strands are
    given the width in metres that the preset draws them with in the middle of the groom, at the size studied.
    """

    of_processor = False
    """Whether seconds are the processor's, of all threads, and not those of the clock."""

    def __init__(self, request: Request) -> None:
        scene = request.single
        if scene.emitter.groom is not None:
            raise UsageError(
                f"{request.name}: axes of pictures draw strands that are grown, and this preset has those of a file "
                "(emitter.groom); study its motion, without --axis"
            )
        self.all_strands = scene.drawn_strands
        strands = min(request.strands or STRANDS, self.all_strands)
        share = min(1.0, math.sqrt(PIXELS / math.prod(scene.image.size)))
        small = tuple(max(1, round(side * share)) for side in scene.image.size)
        scene = changed(scene, {"image.size": request.size or small})
        drawn = changed(scene, {"children": None, "emitter.strands": strands})
        self._guiding = drawn if scene.children is None else scene
        self.name, self.frame = request.name, request.frame
        if self.frame > scene.time.frames:
            raise UsageError(f"--frame {self.frame}: the film of {self.name} has {scene.time.frames} frames")
        checked_plan(self._guiding, (self.frame,))
        self.at = (self.frame - 1) / scene.time.fps
        self.groom = emit(drawn.emitter, drawn.seed)
        self.scene = drawn
        self.positions: NDArray[np.float32] = np.empty(0, np.float32)
        self.lengths: NDArray[np.float32] = np.empty(0, np.float32)
        self.widened = scene.material.width == 0
        self._joined: NDArray[np.float32] | None = None

    def move(self) -> None:
        """Simulate up to the frame, once. Raises `SimulationError` where strands cannot
        be drawn."""
        from ...simulate import solver_of

        if self.positions.size:
            return
        scene = self._guiding
        guides = self.groom if scene.children is None else emit(scene.emitter, scene.seed)
        solver = solver_of(scene)(scene, guides)
        solver.advance(self.frame)
        if not np.isfinite(solver.particles()).all():
            raise SimulationError(f"{self.name}: at frame {self.frame} strands are no longer finite; study another")
        self.positions, self.lengths = solver.positions, solver.lengths
        if scene.children is not None:
            children, strands = Children(scene, guides), self.groom.strands
            tones, ids = children.select(solver.positions)
            first = np.argsort(ids)[:strands]
            self.groom = dataclasses.replace(self.groom, tones=tones[first])
            self.positions, self.lengths = children.grow(
                solver.positions, solver.lengths, self.at, ids[first], Scratch()
            )
        if self.scene.emitter.tie is not None:
            combed = Combed(self.scene, self.groom)
            self._joined = combed.join(self.positions, self.at, self.groom.strands, Scratch())
        if self.widened:
            view = self.view(self.scene)
            low, high = self.bounds()
            depth = max(float(((low + high) / 2 - view.eye) @ view.forward), view.near) if view.perspective else 1.0
            width = depth / view.focal / self.scene.image.supersample
            self.scene = changed(self.scene, {"material.width": width, "material.taper": 0.0})

    def whole(self) -> tuple[NDArray[np.float32], NDArray[np.float32] | None]:
        """Positions (blocks, rows, 3 W) and segment lengths (blocks, W) as they are drawn: of tied strands with what is
        combed, whose segments differ, so that there are no lengths."""
        return (self.positions, self.lengths) if self._joined is None else (self._joined, None)

    def spacing(self) -> float:
        """Metres from strand to strand: of the groom."""
        return spacing_of(self.whole()[0], self.groom.strands)

    def spacing_at(self, points: NDArray[np.float64], own: NDArray[np.int64]) -> NDArray[np.float64]:
        """The same at points (P, 3) on the strands ``own`` (P,)."""
        return spacing_at(self.whole()[0], self.groom.strands, points.astype(np.float32), own)

    def points(self) -> NDArray[np.float64]:
        """(strands, particles + 1, 3) metres: the row before the root, then the particles."""
        from ...groom.blocks import unpack

        return np.asarray(unpack(self.whole()[0], self.groom.strands), np.float64)

    def bounds(self) -> NDArray[np.float64]:
        """(2, 3) box of the strands."""
        points = self.points()[:, 1:]
        return np.stack([points.min((0, 1)), points.max((0, 1))])

    def view(self, scene: Scene) -> View:
        """The camera of a scene at the frame, in its picture's own pixels."""
        return camera_view(scene.camera, self.at, *scene.image.size, self.bounds())

    def draw(self, scene: Scene, draws: int = DRAWS, renderer: LinearRenderer | None = None) -> Picture:
        """Draw a scene with the subject's strands; ``renderer`` stands in for the usual one of the scene."""
        import numba

        renderer = renderer or LinearRenderer(scene, self.groom)
        if self.of_processor:
            renderer.clocked = ProcessorDrawing
        seconds: dict[str, float] = {}
        for _ in range(draws):
            drawing = renderer.draw(self.positions, self.lengths, self.at, numba.get_num_threads())
            for stage, took in drawing.seconds.items():
                seconds[stage] = min(took, seconds.get(stage, math.inf))
        assert renderer.linear is not None
        return Picture(renderer.linear, seconds, dict(drawing.counts), drawing.image, drawing.aovs)
