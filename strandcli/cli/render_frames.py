"""Where the frames of `strandcli render` come from, this process or the workers of a cluster, and what takes them."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from . import dask, positions

if TYPE_CHECKING:
    from ..output.frames import FrameWriter
    from ..output.positions import PositionCache
    from ..run.checkpoints import Checkpoints
    from ..run.frame import Frame
    from ..scene.model import Scene
    from .progress import Progress


class Motion(NamedTuple):
    """Where a run's motion comes from, whether it stops where that has gone wrong, and who draws."""

    positions: Any
    """Those of a cache, by frame number; None where the run simulates."""
    checkpoint: int | None
    """Frames between two checkpoints."""
    keep_going: bool
    dask: str | None
    """A cluster's address, or local; None: this process draws."""


def frames_of(
    scene: Scene, numbers: tuple[int, ...], motion: Motion, threads: int | None, kept: Checkpoints | None,
    progress: Progress, warn: Callable[[str], None], keep_positions: bool,
) -> Iterator[Frame]:  # fmt: skip
    """Frames as they are done."""
    if motion.dask is not None:
        return dask.frames(
            scene, numbers, motion.dask, motion.positions, threads, progress.note, warn,
            keep_going=motion.keep_going, checkpoints=kept,
        )  # fmt: skip
    from ..run import pipeline
    from ..run.first_frame import FirstFrame

    return pipeline.render(
        scene, numbers, threads=threads, positions=motion.positions, keep_going=motion.keep_going,
        keep_positions=keep_positions, notify=progress.note, warn=warn,
        checkpoints=FirstFrame(kept, progress.note),
    )  # fmt: skip


def frame_writer(
    folder: Path, numbers: tuple[int, ...], scene: Scene, cache: PositionCache | None, animate: tuple[str, ...],
    overwrite: bool, resume: bool, exr: bool,
) -> FrameWriter:  # fmt: skip
    """What takes the frames; refuses up front what would be refused later."""
    from ..output.frames import FrameWriter
    from ..output.report import FILE
    from ..run.fingerprint import fingerprint

    if "mp4" in animate:
        from ..output.video import ffmpeg

        ffmpeg()
    return FrameWriter(
        folder,
        numbers,
        picture_size(scene),
        overwrite=overwrite,
        resume=resume,
        scene=fingerprint(scene, *([] if cache is None else positions.other_motion(cache, scene))),
        also=[f"animation.{kind}" for kind in animate],
        own=[FILE],
        layers=scene.image.aovs,
        exr=exr,
    )


def picture_size(scene: Scene) -> tuple[int, int]:
    """Width and height of what is drawn; panels, their gaps and their labels included."""
    if not scene.panels:
        return scene.image.drawn
    import numpy as np

    from ..run.panels import join

    empty = [np.zeros((*panel.image.drawn[::-1], 3), np.uint8) for panel in scene.panels]
    height, width, _ = join(empty, [panel.label for panel in scene.panels]).shape
    return width, height
