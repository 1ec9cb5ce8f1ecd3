"""What takes the frames of `strandcli render`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from . import positions

if TYPE_CHECKING:
    from ..output.frames import FrameWriter
    from ..output.positions import PositionCache
    from ..scene.model import Scene


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
