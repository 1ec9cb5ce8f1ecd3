"""Where the frames of `strandcli render` come from: this process, or the workers of a cluster."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any, NamedTuple

from . import dask

if TYPE_CHECKING:
    from ..checkpoints import Checkpoints
    from ..frame import Frame
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
    from .. import pipeline

    return pipeline.render(
        scene, numbers, threads=threads, positions=motion.positions, keep_going=motion.keep_going,
        keep_positions=keep_positions, notify=progress.note, warn=warn, checkpoints=kept,
    )  # fmt: skip
