"""What a run tells of this machine's speed: the processor's time of its frames, whatever else the machine does."""

from __future__ import annotations

import time
from collections.abc import Iterator
from typing import TYPE_CHECKING

from ..plan.cost import frame_seconds, kind_of
from . import profile

if TYPE_CHECKING:
    from ..plan import Plan
    from ..run.frame import Frame
    from ..scene.model import Scene

FEWEST = 2
"""Frames after the first, which loads kernels."""


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
