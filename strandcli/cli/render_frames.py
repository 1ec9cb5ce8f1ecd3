"""Where the frames of `strandcli render` come from: this process, or the workers of a cluster."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

from ..calibration.speed import Watch, learn
from ..plan.libraries import keep_mapped
from . import dask

if TYPE_CHECKING:
    from ..plan import Plan
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
    watch: Watch
    """Of the processor's time."""


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

    found = pipeline.render(
        scene, numbers, threads=threads, positions=motion.positions, keep_going=motion.keep_going,
        keep_positions=keep_positions, notify=progress.note, warn=warn,
        checkpoints=FirstFrame(kept, progress.note),
    )  # fmt: skip
    return motion.watch.over(found)


def learn_speed(plan: Plan, scene: Scene, data: Mapping[str, Any], motion: Motion) -> None:
    """Refine what is known of this machine's speed by a run that has drawn all itself, unless it compiled kernels; and
    of what libraries take, more of which compiling maps."""
    if motion.dask is None and data.get("frames") and not data.get("compile_seconds"):
        keep_mapped()
    here = motion.dask is None and motion.positions is None
    if here and data.get("status") == "complete" and not data.get("compile_seconds"):
        learn(plan, scene, motion.watch)
