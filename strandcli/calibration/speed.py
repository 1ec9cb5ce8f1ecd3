"""How long a run will take here, and what a run tells of this machine's speed: the processor's time of its frames,
whatever else the machine does."""

from __future__ import annotations

import time
from collections.abc import Iterator
from typing import TYPE_CHECKING, NamedTuple

from ..plan.cost import frame_seconds, kind_of, run_seconds
from . import profile

if TYPE_CHECKING:
    from ..plan import Plan
    from ..run.frame import Frame
    from ..scene.model import Scene

WITHIN = 2.0
"""Times by which the figures may be off, on a machine that does nothing else."""
FEWEST = 2
"""Frames after the first, which loads kernels."""


class Foretold(NamedTuple):
    """Seconds of a run with kernels in the cache, and where they are from."""

    frame: float
    """A frame, of those that are drawn at once its share."""
    total: float
    threads: int
    within: float
    source: str


def foretell(plan: Plan, scene: Scene, known: profile.Profile, threads: int) -> Foretold:
    """Return the seconds of a run on so many threads."""
    factor, runs = known.of(kind_of(scene))
    frame, total = run_seconds(plan, scene, factor, threads)
    if runs:
        source = f"by {'the last run' if runs == 1 else f'{runs} runs'} of such scenes here"
    else:
        source = f"by a calibration of this machine on {known.measured}"
    return Foretold(frame, total, threads, WITHIN, source)


class Watch:
    """Counts frames and the processor's seconds of this process, of all threads, after the first frame."""

    def __init__(self) -> None:
        self.frames = 0
        self.seconds = 0.0
        self.running = True
        """Whether every frame of the film was drawn: others are simulated unseen, in time that belongs to none."""

    def over(self, frames: Iterator[Frame]) -> Iterator[Frame]:
        """Hand on frames, in their order."""
        began, last = None, None
        for frame in frames:
            now = time.process_time()
            if began is None:
                began = now
            else:
                self.frames += 1
                self.seconds = now - began
                self.running = self.running and last is not None and frame.number == last + 1
            last = frame.number
            yield frame


def learn(plan: Plan, scene: Scene, watch: Watch) -> None:
    """Refine this machine's profile, where there is one, by a run of a scene that has simulated and drawn all."""
    expected = frame_seconds(plan, scene)
    if watch.frames < FEWEST or not watch.running or expected <= 0 or (known := profile.read()) is None:
        return
    known.learn(kind_of(scene), watch.seconds / watch.frames / expected)
    profile.write(known)
