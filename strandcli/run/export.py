"""Drawn strands, children among them, for other programs."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..compiling import runtime
from ..errors import UsageError
from ..scene.model import Scene

if TYPE_CHECKING:
    from ..exchange.strands import Strands
    from .stages import MovedStrands, Notify, Positions, SimulationStage


@dataclass(frozen=True, eq=False)
class DrawnFrame:
    """The strands of a frame, in the order of emission, metres, y up; an attribute ``width`` where they have one."""

    number: int
    strands: Strands


def drawn_strands(
    scene: Scene,
    frames: Sequence[int] | None = None,
    *,
    level: int | None = None,
    threads: int | None = None,
    positions: Positions | None = None,
    keep_going: bool = False,
    notify: Notify | None = None,
    warn: Notify | None = None,
) -> Iterator[DrawnFrame]:
    """Yield the strands that a picture of each frame shows, whatever the camera: all of them, each segment in
    2 ** ``level`` pieces; None: as the scene has it. Arguments else as for `strandcli.run.pipeline.render`.

    Raises `SimulationError` where a frame has gone wrong, and `UsageError` for a scene of several panels.
    """
    from .stages import RunOptions, SimulationStage

    if scene.panels:
        raise UsageError("a preset of several panels has several sets of strands; export one without")
    count = runtime.checked_threads(threads)
    runtime.tell(notify, warn)
    if scene.emitter.groom is not None:
        from ..groom_file import completed

        scene = completed(scene)
    scene = replace(scene, detail=None, camera=replace(scene.camera, shutter=0.0))
    wanted = sorted(set(frames if frames is not None else range(1, scene.time.frames + 1)))
    options = RunOptions(True, False, keep_going, notify, warn)
    with runtime.thread_count(count):
        moved = SimulationStage(scene, wanted, positions, options)
    exporter = _Exporter(scene, moved, level)
    for number in wanted:
        with runtime.thread_count(count):
            found = exporter.strands(moved.begin(number))
        yield DrawnFrame(number, found)


class _Exporter:
    """Makes strands of what a run hands on, with memory of its own."""

    def __init__(self, scene: Scene, moved: SimulationStage, level: int | None) -> None:
        from ..draw.common.scratch import Scratch
        from ..draw.drawn_strands import DrawnStrands
        from ..draw.exported import evenly_cut
        from ..groom.followers import Followers

        self.scene, self.scratch = scene, Scratch()
        self.children = moved.children
        groom = moved.children.groom if isinstance(moved.children, Followers) else moved.groom
        self.drawn = DrawnStrands(groom, moved.children, moved.combed, True, self.scratch, every=True)
        self.curves = evenly_cut(scene.curves, level)

    def strands(self, moved: MovedStrands) -> Strands:
        """The strands of a frame."""
        from ..draw.common.drawing import Drawing
        from ..draw.drawn_strands import DrawnStrands
        from ..draw.exported import polylines, widths_along
        from ..exchange.strands import Attribute, Source, Strands, even_offsets

        drawn, tones, ids = self.drawn, moved.tones, moved.ids
        if moved.groom is not None:
            drawn = DrawnStrands(moved.groom, None, None, True, self.scratch, every=True)
        if self.children is not None:
            tones, ids = self.children.select(moved.positions)
        at = (moved.frame.number - 1) / self.scene.time.fps
        found = drawn.at(
            self.scene, at, moved.positions, moved.lengths, tones, ids, Drawing(np.zeros((1, 1, 3), np.uint8))
        )
        lines = polylines(self.scene, found, self.curves, self.scratch)
        order = slice(None) if found.ids is None else np.argsort(found.ids, kind="stable")
        world: NDArray[np.float32] = lines.world.reshape(found.count, lines.per, 3)[order].copy()
        widths = widths_along(self.scene.material, found, lines)
        attributes = {} if widths is None else {"width": Attribute("point", widths[order].reshape(-1))}
        first = even_offsets(found.count, lines.per)
        return Strands(first, world.reshape(-1, 3), attributes, Source(unit=1.0, up="y"))
