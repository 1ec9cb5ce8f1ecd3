"""`strandcli bench PRESET`: where a frame's time goes, and what each stage works on.

Frames are drawn one by one on all threads that are asked for, and written before the next begins, so that no stage
takes turns with another; to simulate is to move on to a frame, its errors looked at. The first is not counted, because
it compiles and fills caches.
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from .. import load
from ..compiling import runtime
from ..errors import UsageError
from ..plan import checked_plan
from ..scene.model import Scene
from .bench import Load, spread

Notify = Callable[[str], None]
Clock = Callable[[], float]
"""Tells seconds."""
Timed = list[tuple[dict[str, float], dict[str, int]]]
"""Seconds by stage and counts, of each frame."""
ELEMENTS: dict[str, tuple[str, Callable[[Mapping[str, int]], int]]] = {
    "simulate": ("particle and step", lambda c: c["particle_steps"]),
    "children": ("child's particle", lambda c: c["particles"]),
    "curves": ("segment", lambda c: c["segments"]),
    "shadow": ("segment and light", lambda c: c["segments"] * c["lights"]),
    "raster": ("fragment", lambda c: c["fragments"]),
    "shade": ("segment and light", lambda c: c["segments"] * c["lights"]),
    "film": ("sample", lambda c: c["samples"]),
    "write": ("byte", lambda c: c["bytes"]),
}
"""What a stage works on, and how many of these a frame has, from its counts."""


def run(
    preset: str, frames: int, size: tuple[int, int], threads: int | None, overrides: Sequence[str],
    notify: Notify | None, cpu: bool, changes: Mapping[str, Any],
) -> dict[str, Any]:  # fmt: skip
    """All figures of one sitting: ``stages`` has a row a stage (see `stage_row`), ``counts`` are those of the last
    frame; ``cpu``: in the processor's time of all threads, where other programs run meanwhile; ``changes``: settings by
    dotted path.

    Raises `UsageError` for a preset of several panels, or of fewer frames than are asked for."""
    scene = load(preset, overrides=overrides, settings={"image.size": list(size), **changes}, option="--set")
    if scene.panels:
        raise UsageError(f"{preset}: has {len(scene.panels)} panels, and bench times a single picture")
    if scene.time.frames < frames + 1:
        raise UsageError(
            f"{preset}: has {scene.time.frames} frames, and the first is not counted: use --frames "
            f"{scene.time.frames - 1} or fewer"
            if scene.time.frames > 1
            else f"{preset}: has one frame, which is not counted: add --set time.frames={frames + 1}"
        )
    checked_plan(scene, range(1, frames + 2))
    runtime.start(threads, notify)
    clock = time.process_time if cpu else time.perf_counter
    with runtime.thread_count(runtime.checked_threads(threads)):
        timed, busy = time_stages(scene, frames, clock, notify)
    seconds = [sum(one.values()) for one, _ in timed]
    return {
        "preset": preset, "size": list(size), "frames": frames,
        "threads": runtime.machine()["threads"] if threads is None else threads,
        "set": [*overrides, *(f"{path}={value}" for path, value in changes.items())], "clock": "cpu" if cpu else "wall",
        "compile_seconds": runtime.compile_seconds(), "stages": {name: stage_row(name, timed) for name in timed[-1][0]},
        "frame": {**spread(seconds), "fps": 1 / float(np.median(seconds))}, "counts": timed[-1][1], "busy": busy,
        "machine": runtime.machine(),
    }  # fmt: skip


def time_stages(
    scene: Scene, frames: int, clock: Clock, notify: Notify | None
) -> tuple[Timed, dict[str, float] | None]:
    """Seconds a stage and the counts of frames 2 to ``frames`` + 1, and how busy the machine was (`Load.since`)."""
    from ..compiling.service import service
    from ..draw.renderer import ProcessorRenderer, Renderer
    from ..output import png
    from ..output.files import write_pieces
    from ..run.frame import FrameRenderer
    from ..run.stages import RunOptions, SimulationStage

    numbers = range(1, frames + 2)
    timed: Timed = []
    load = Load()
    service.ahead(scene, None)
    try:
        moved = SimulationStage(scene, numbers, None, RunOptions(notify=notify))
        draw = FrameRenderer(moved, ProcessorRenderer if clock is time.process_time else Renderer)
        with tempfile.TemporaryDirectory(prefix="strandcli-bench-") as folder:
            for number in numbers:
                if notify is not None:
                    notify(f"drawing frame {number}")
                began = clock()
                begun = moved.begin(number)
                simulated_in = clock() - began
                particles = begun.frame.report["counts"]["particles"]
                frame = draw(begun)
                assert frame.image is not None
                began = clock()
                png.pixels_sha256(frame.image)
                write_pieces(Path(folder) / "frame.png", png.encode(frame.image))
                seconds = {**frame.report["seconds"], "simulate": simulated_in, "write": clock() - began}
                counts = frame.report["counts"]
                more = {  # which the renderer does not know
                    "guides": moved.groom.strands,
                    "particles_a_strand": particles // moved.groom.strands,
                    "particle_steps": particles * scene.time.substeps,
                    "bytes": frame.image.size,
                    "samples": int(np.prod(scene.image.drawn)) * scene.image.supersample**2,
                    "lights": len(scene.lights),
                }
                if number == 1:  # whose kernels other processes compile
                    load = Load()
                else:
                    timed.append((seconds, {**counts, **more}))
    finally:
        service.stop_ahead()
    return timed, load.since()


def stage_row(name: str, timed: Timed) -> dict[str, Any]:
    """A stage's milliseconds a frame; the element that it works on, their number in the last frame, and the fastest
    frame's nanoseconds each. None where nothing is counted."""
    seconds = np.array([one.get(name) or 0.0 for one, _ in timed])
    fastest = int(np.argmin(seconds))
    row: dict[str, Any] = {**spread(seconds), "element": None, "count": None, "element_ns": None}
    if name in ELEMENTS:
        element, count = ELEMENTS[name]
        if count(timed[fastest][1]):
            each = 1e9 * float(seconds[fastest]) / count(timed[fastest][1])
            row |= {"element": element, "count": count(timed[-1][1]), "element_ns": each}
    return row
