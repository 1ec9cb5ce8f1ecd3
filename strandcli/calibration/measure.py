"""The speed of this machine: a few frames of a shipped preset, by the processor's time of one thread."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

from ..plan.libraries import keep_mapped, mapped_bytes
from .profile import Profile, today

PRESET = "minimal"
SETTINGS: dict[str, Any] = {"image.size": [400, 300], "time.preroll": 0.0, "emitter.strands": 6000}
FRAMES = 8
REFERENCE = 0.039
"""Seconds of the fastest of these frames on the machine that `strandcli.plan.cost` is about."""


def measure(notify: Callable[[str], None] | None = None) -> Profile:
    """Return a profile that holds what was measured alone. Takes two seconds, and a minute where kernels are compiled
    first. What other programs do meanwhile is not counted. Keeps what libraries take of memory (`plan.libraries`), the
    most that is seen after a frame: the system may take back pages that have not been used for a while."""
    from .. import load
    from ..compiling import runtime
    from ..draw.common.drawing import ProcessorDrawing
    from ..draw.renderer import Renderer
    from ..run.frame_renderer import FrameRenderer
    from ..run.stages import RunOptions, SimulationStage

    class Timed(Renderer):
        clocked = ProcessorDrawing

    scene = load(PRESET, settings=SETTINGS)
    runtime.tell(notify)
    took, mapped = [], mapped_bytes()
    with runtime.thread_count(1):
        moved = SimulationStage(scene, range(1, FRAMES + 1), None, RunOptions())
        draw = FrameRenderer(moved, Timed)
        for number in range(1, FRAMES + 1):
            if notify is not None:
                notify(f"measuring: frame {number} of {FRAMES}")
            began = time.process_time()
            begun = moved.begin(number)
            simulated = time.process_time() - began
            seconds = draw(begun).report["seconds"]
            took.append(simulated + sum(value for stage, value in seconds.items() if stage != "simulate"))
            mapped = max(mapped, mapped_bytes())
    keep_mapped(mapped)
    return Profile(min(took) / REFERENCE, today())
