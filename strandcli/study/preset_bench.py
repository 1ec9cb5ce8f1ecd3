"""`strandcli bench PRESET`: where a frame's time goes, what each stage works on, and how far it is from its bound.

Frames are drawn one by one on all threads that are asked for, and written before the next begins, so that no stage
takes turns with another; to simulate is to move on to a frame, its errors looked at. The first is not counted, because
it compiles and fills caches. Bounds (`bounds.loops`) are measured right after, on the same threads; each has the least
time of some runs, and so has each stage that it is compared with.
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import load, runtime
from ..errors import UsageError
from ..plan import checked_plan
from ..scene.model import Scene
from .bench import spread
from .bounds.arrays import MOST
from .bounds.loops import BOUNDS, LEAST, STAGES, Counts, Loop, make_deflate

Notify = Callable[[str], None]
Clock = Callable[[], float]
"""Tells seconds."""

RUNS = 5
"""Runs of a bound's loop, the least of which counts, after one that does not."""


def run(
    preset: str, frames: int = 3, size: tuple[int, int] = (800, 600), threads: int | None = None,
    quality: str = "preset", overrides: Sequence[str] = (), notify: Notify | None = None, cpu: bool = False,
    changes: Mapping[str, Any] | None = None,
) -> dict[str, Any]:  # fmt: skip
    """All figures of one sitting: ``stages`` has a row a stage (see `stage_row`), ``counts`` are those of the last
    frame; ``cpu``: in the processor's time of all threads, where other programs run meanwhile; ``changes``: settings by
    dotted path.

    Raises `UsageError` for a preset of several panels, or of fewer frames than are asked for."""
    settings: dict[str, Any] = {"image.size": list(size), **(changes or {})}
    if quality != "preset":
        settings["quality"] = quality
    scene = load(preset, overrides=overrides, settings=settings, option="--set")
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
        timed, image = time_frames(scene, frames, clock, notify)
        counts = timed[-1][1]
        bounds = measure_bounds(counts, image, clock, notify)
    seconds = [sum(each for each in one.values()) for one, _ in timed]
    return {
        "preset": preset,
        "size": list(size),
        "frames": frames,
        "threads": runtime.machine()["threads"] if threads is None else threads,
        "quality": quality,
        "set": [*overrides, *(f"{path}={value}" for path, value in (changes or {}).items())],
        "clock": "cpu" if cpu else "wall",
        "compile_seconds": runtime.compile_seconds(),
        "stages": {name: stage_row(name, timed, bounds) for name in timed[-1][0]},
        "frame": {**spread(seconds), "fps": 1 / float(np.median(seconds))},
        "counts": counts,
        "machine": runtime.machine(),
    }


def time_frames(
    scene: Scene, frames: int, clock: Clock, notify: Notify | None
) -> tuple[list[tuple[dict[str, float], Counts]], NDArray[np.uint8]]:
    """Seconds a stage and the counts of frames 2 to ``frames`` + 1, and the last picture."""
    from .. import compile_ahead
    from ..draw.counting import CountingRenderer, ProcessorRenderer
    from ..frame_renderer import FrameRenderer
    from ..output import png
    from ..output.files import write_pieces
    from ..stages import RunOptions, SimulationStage

    numbers = range(1, frames + 2)
    timed = []
    image = np.zeros((0, 0, 3), np.uint8)
    compile_ahead.begin(scene, None)
    try:
        moved = SimulationStage(scene, numbers, None, RunOptions(notify=notify))
        draw = FrameRenderer(moved, ProcessorRenderer if clock is time.process_time else CountingRenderer)
        with tempfile.TemporaryDirectory(prefix="strandcli-bench-") as folder:
            for number in numbers:
                if notify is not None:
                    notify(f"drawing frame {number}")
                began = clock()
                begun = moved.begin(number)
                simulated_in = clock() - began
                simulated = begun.frame.report["counts"]["particles"]
                frame = draw(begun)
                assert frame.image is not None
                image = frame.image
                began = clock()
                png.pixels_sha256(image)
                write_pieces(Path(folder) / "frame.png", png.encode(image))
                drawn = frame.report["seconds"]
                seconds = {**drawn, "simulate": simulated_in, "write": clock() - began}
                counts = complete(frame.report["counts"], scene, moved.groom.strands, simulated, image.size)
                if number > 1:
                    timed.append((seconds, counts))
    finally:
        compile_ahead.end()
    return timed, image


def complete(counts: Counts, scene: Scene, guides: int, particles: int, size: int) -> Counts:
    """A frame's counts with what the renderer does not know: simulated particles and steps, and bytes of the file."""
    return {
        **counts,
        "guides": guides,
        "particles_a_strand": particles // guides,
        "particle_steps": particles * scene.time.substeps,
        "children": counts["strands"] if counts.get("child_particles") else 0,
        "samples_a_side": scene.image.supersample,
        "bytes": size,
    }


def measure_bounds(
    counts: Counts, image: NDArray[np.uint8], clock: Clock, notify: Notify | None
) -> dict[str, dict[str, Any]]:
    """Of each bound that a frame with these counts has, what it does and its nanoseconds an element."""
    found = {}
    for name, bound in BOUNDS.items():
        count = bound.count(counts)
        if not count:
            continue
        if notify is not None:
            notify(f"bound: {name}")
        make = partial(make_deflate, image=image) if name == "deflate" else bound.make
        found[name] = {
            "loop": name,
            "element": bound.element,
            "bytes": bound.memory(counts),
            "operations": bound.operations(counts),
            "element_ns": 1e9 * least_seconds(make(counts, min(max(count, LEAST), MOST)), clock),
        }
    return found


def least_seconds(loop: Loop, clock: Clock) -> float:
    """Seconds an element of a loop's fastest run."""
    times = []
    for _ in range(RUNS + 1):
        began = clock()
        loop.run()
        times.append(clock() - began)
    return min(times[1:]) / loop.elements


def stage_row(
    name: str, timed: list[tuple[dict[str, float], Counts]], bounds: dict[str, dict[str, Any]]
) -> dict[str, Any]:
    """A stage's milliseconds a frame; the element that it works on, their number in the last frame, and the fastest
    frame's nanoseconds each; the least time that its bounds ask for, of the fastest frame, too, and the ratio to that.
    None where the stage has no bound."""
    seconds = np.array([one.get(name) or 0.0 for one, _ in timed])
    fastest = int(np.argmin(seconds))
    row: dict[str, Any] = {
        **spread(seconds), "element": None, "count": None, "element_ns": None, "bound_element_ns": None,
        "bound_ms": None, "ratio": None, "bounds": [],
    }  # fmt: skip
    mine = [bound for bound in STAGES.get(name, ()) if bound in bounds]
    if not mine:
        return row
    last = timed[-1][1]
    then = {bound: BOUNDS[bound].count(timed[fastest][1]) for bound in mine}
    bound_ms = 1e-6 * sum(then[bound] * bounds[bound]["element_ns"] for bound in mine)
    first = max(then[mine[0]], 1)
    return row | {
        "element": bounds[mine[0]]["element"],
        "count": BOUNDS[mine[0]].count(last),
        "element_ns": 1e9 * float(seconds[fastest]) / first,
        "bound_element_ns": 1e6 * bound_ms / first,
        "bound_ms": bound_ms,
        "ratio": 1e3 * float(seconds[fastest]) / bound_ms,
        "bounds": [{**bounds[bound], "count": BOUNDS[bound].count(last)} for bound in mine],
    }
