"""`strandcli bench`: where a frame's time goes, with the errors that it buys, of the preset `headline`.

Times of stages are medians over frames after a first one that is not counted: it compiles and fills caches. Where
frames are drawn at once (`run.ordered_map`), a stage takes the time of one frame on its share of the threads, by the
clock on the wall. So more figures stand on their own: `steps` (the solver asked for), `rules` (six rules and two
spheres) and `lines` (one-pixel lines with colours into a z-buffer).
"""

from __future__ import annotations

import os
import sys
import tempfile
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .. import load
from ..compiling import runtime
from ..output.report import peak_rss_bytes
from ..plan import checked_plan
from ..scene.model import Scene

if TYPE_CHECKING:
    from ..simulate.solver import Solver

Notify = Callable[[str], None]

GROWTH = {
    "strands": tuple((strands, 10) for strands in (1_000, 10_000, 100_000, 1_000_000)),
    "particles": tuple(
        (max(100_000 // particles, 512), particles) for particles in (5, 10, 20, 21, 50, 100, 200, 500, 1_000)
    ),
}
"""Strands and particles a strand that `time_growth` measures, by what grows."""
PARTICLE_STEPS = 5_000_000
"""What is timed of each size, in 5 to 50 steps: those of a thousand strands are over before a processor is awake."""
FEWEST = 10
"""Particles from which on their exponent is fitted: of fewer, much of the cost is that of the strand itself."""


def run(
    settings: Mapping[str, Any], frames: int, size: tuple[int, int], threads: int | None = None,
    overrides: Sequence[str] = (), notify: Notify | None = None,
) -> dict[str, Any]:  # fmt: skip
    """All figures of one sitting. ``settings``, by path, have ``emitter.strands``, ``emitter.particles`` and
    ``solver``; ``overrides`` change the rest, as after ``--set``, but not what `rules` and
    `lines` time."""
    strands, particles = settings["emitter.strands"], settings["emitter.particles"]
    settings = {**settings, "image.size": list(size), "time.frames": max(frames + 1, 2)}
    scene = load("headline", overrides=overrides, settings=settings, option="--set")
    checked_plan(scene, range(1, frames + 2))
    runtime.start(threads, notify)
    timed = time_frames(scene, frames, threads, notify)
    if notify is not None:
        notify("one loop alone: steps, rules, lines")
    stages = {name: spread(values) for name, values in timed["seconds"].items()}
    counts = timed["counts"]
    at_once = runtime.machine()["threads"] // timed["share"]
    return {
        "strands": strands, "particles": particles, "size": list(size), "frames": frames,
        "threads": runtime.machine()["threads"], "set": list(overrides), "compile_seconds": runtime.compile_seconds(),
        "frames_at_once": at_once, "stages": stages,
        "frame": {"median_ms": timed["frame_ms"], "fps": 1e3 / timed["frame_ms"]},
        "counts": {name: counts[name] for name in ("segments", "fragments", "fragment_bytes") if name in counts},
        "particle_step_ns": 1e6 * stages["simulate"]["median_ms"] / (strands * particles) / at_once,
        "error": timed["error"], "busy": timed["busy"],
        "steps": time_steps(settings["solver"], strands, particles, 20, overrides),
        "rules": time_rules(strands, particles), "lines": time_lines(strands, 37, *size),
        "peak_rss_bytes": peak_rss_bytes(), "machine": runtime.machine(),
    }  # fmt: skip


def time_frames(scene: Scene, frames: int, threads: int | None, notify: Notify | None) -> dict[str, Any]:
    """Seconds a stage and the time from frame to frame, PNG files included, which are written meanwhile."""
    from ..output.frames import FrameWriter
    from ..run import pipeline
    from ..run.panels import merged

    numbers = range(1, frames + 2)
    seconds: dict[str, list[float]] = {}
    ends = []
    errors = []
    counts: dict[str, int] = {}
    share, load = sys.maxsize, Load()
    with tempfile.TemporaryDirectory(prefix="strandcli-bench-") as folder:
        with FrameWriter(Path(folder), numbers, scene.image.drawn) as writer:
            for frame in pipeline.render(scene, numbers, threads=threads, notify=notify):
                assert frame.image is not None
                writer.submit(frame.number, frame.image)
                ends.append(time.perf_counter())
                counts = frame.report["counts"]
                share = min(share, frame.report["threads"])  # the last frames may have more
                errors.append(frame.report["error"])
                if frame.number == 1:  # whose kernels other processes compile
                    load = Load()
                else:
                    for name, value in frame.report["seconds"].items():
                        seconds.setdefault(name, []).append(value)
        ends[-1] = time.perf_counter()  # the last files were still being written
        seconds["write"] = [one.seconds for one in writer.written.values() if one.frame > 1 and one.seconds is not None]
    frame_ms = 1e3 * (ends[-1] - ends[0]) / frames
    return {
        "seconds": seconds, "counts": counts, "error": merged(errors, max), "frame_ms": frame_ms, "share": share,
        "busy": load.since(),
    }  # fmt: skip


def time_rules(strands: int, particles: int, repeats: int = 40) -> dict[str, float]:
    """The six rules with two spheres, nothing else: nanoseconds a particle and step."""
    from ..groom.emit import emit
    from ..simulate.thesis.solver import ThesisSolver

    scene = load("headline", settings={"emitter.strands": strands, "emitter.particles": particles})
    solver = ThesisSolver(scene, emit(scene.emitter, scene.seed))
    took = median_seconds(lambda j: solver.step(j / 60, 1 / 60), repeats)
    return {"ms": 1e3 * took, "particle_step_ns": 1e9 * took / (strands * particles)}


def time_growth(solver: str, overrides: Sequence[str] = (), notify: Notify | None = None) -> dict[str, Any]:
    """How the cost of a particle and step grows with strands, of 10 particles each, and with the particles of a strand,
    at 100,000 of them or more: the scene `headline`, simulated and not drawn, once strands have fallen into place.
    ``growth`` has a row a size, ``exponents`` what `exponent` tells of a step's cost by the strands, and of a strand's
    by its particles."""
    rows: list[dict[str, float]] = []
    exponents: dict[str, float | None] = {}
    load = Load()
    for grows, sizes in GROWTH.items():
        mine = []
        for strands, particles in sizes:
            if notify is not None:
                notify(f"{strands:,} strands x {particles:,} particles")
            repeats = min(max(PARTICLE_STEPS // (strands * particles), 5), 50)
            steps = time_steps(solver, strands, particles, repeats, overrides)
            mine.append({"strands": strands, "particles": particles, **steps})
        rows += mine
        fitted = [row for row in mine if grows == "strands" or row["particles"] >= FEWEST]
        costs = [row["particle_step_ns"] * row[grows] for row in fitted]
        exponents[grows] = exponent([row[grows] for row in fitted], costs)
    return {"growth": rows, "exponents": exponents, "busy": load.since()}


def exponent(sizes: Sequence[float], costs: Sequence[float]) -> float | None:
    """The p of cost = c · size ** p, by least squares of logarithms: 1 is linear. None for fewer than two sizes."""
    if len(set(sizes)) < 2:
        return None
    return float(np.polyfit(np.log(sizes), np.log(costs), 1)[0])


def time_steps(
    solver: str, strands: int, particles: int, repeats: int, overrides: Sequence[str] = ()
) -> dict[str, float]:
    """The scene `headline`, simulated and not drawn, once strands have fallen into place: milliseconds a step,
    nanoseconds a particle and step."""
    settings = {"emitter.strands": strands, "emitter.particles": particles, "solver": solver}
    one = at_first_frame(load("headline", overrides=overrides, settings=settings, option="--set"))
    took = median_seconds(lambda j: one.advance(j + 2), repeats)
    return {"ms": 1e3 * took, "particle_step_ns": 1e9 * took / (strands * particles)}


def at_first_frame(scene: Scene) -> Solver:
    """A scene's solver, brought there."""
    from ..groom.blocks import arranged
    from ..groom.emit import emit
    from ..simulate import solver_of

    one = solver_of(scene)(scene, arranged(emit(scene.emitter, scene.seed)))
    one.advance(1)
    return one


def time_lines(strands: int, points: int, width: int, height: int, repeats: int = 9) -> dict[str, float]:
    """A ball of drooping polylines into a z-buffer with a colour at every vertex: milliseconds a frame."""
    import numba

    from ..draw.common.kernels.keys import EMPTY
    from ..draw.common.scratch import Scratch
    from ..draw.film.kernels import film
    from ..draw.geometry.curves import Polylines
    from ..draw.zbuffer import raster

    screen, colours = drooping(strands, points, width, height)
    first = np.arange(strands + 1, dtype=np.int64) * points
    lines = Polylines(first, screen)
    keys = np.empty(width * height, np.uint64)
    image = np.zeros((height, width, 3), np.float32)
    scratch = Scratch()
    workers = numba.get_num_threads()

    def draw(_: int) -> None:
        keys.fill(EMPTY)
        raster.draw(lines, screen, None, 0, (width, height), workers, scratch, keys)
        film.colours(keys, 0, screen, 0, 1, colours, image)

    took = median_seconds(draw, repeats)
    segments = strands * (points - 1)
    fragments = count_fragments(screen, points)
    return {
        "segments": segments, "fragments": fragments, "ms": 1e3 * took, "segment_ns": 1e9 * took / segments,
        "fragment_ns": 1e9 * took / fragments,
    }  # fmt: skip


def drooping(strands: int, points: int, width: int, height: int) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Polylines on the screen (strands * points, 3), x and y in pixels and inverse depth, and colours of that shape."""
    rng = np.random.default_rng(0)
    angle = rng.uniform(0, 2 * np.pi, strands)[:, None]
    radius = np.sqrt(rng.uniform(0, 1, strands))[:, None] * height * 0.2
    t = np.linspace(0, 1, points)
    sway = rng.normal(size=(strands, 1)) * 5 * np.sin(6 * t)
    screen = np.empty((strands, points, 3), np.float32)
    screen[..., 0] = width / 2 + radius * np.cos(angle) + np.cos(angle) * t * height * 0.15 + sway
    screen[..., 1] = height * 0.4 + radius * np.sin(angle) + np.sin(angle) * t * height * 0.1 + t**2 * height * 0.25
    screen[..., 2] = 1 / (rng.uniform(1, 2, strands)[:, None] + 0.1 * t)
    return screen.reshape(-1, 3), rng.uniform(0, 1, (strands * points, 3)).astype(np.float32)


def count_fragments(screen: NDArray[np.float32], points: int) -> int:
    """Pixels that lines touch before any is hidden: one for each started pixel of a segment's longer axis."""
    steps = np.diff(screen.reshape(-1, points, 3)[..., :2], axis=1)
    return int((np.abs(steps).max(-1).astype(np.int64) + 1).sum())


def median_seconds(call: Callable[[int], None], repeats: int) -> float:
    """Median time of a call, whose number it is handed, after one that does not count."""
    times = []
    for j in range(repeats + 1):
        began = time.perf_counter()
        call(j)
        times.append(time.perf_counter() - began)
    return float(np.median(times[1:]))


def spread(seconds: Iterable[float]) -> dict[str, float]:
    """Median, least and greatest, in milliseconds."""
    values = 1e3 * np.array(list(seconds))
    return {"median_ms": float(np.median(values)), "min_ms": float(values.min()), "max_ms": float(values.max())}


OTHERS, STOLEN = 0.1, 0.02
"""Shares from which on times are not those of an idle machine."""
IDLE, WAIT, STEAL = 3, 4, 7
"""Columns of a processor in /proc/stat."""


def busy_words(busy: Mapping[str, float] | None) -> str:
    """A warning of what `Load.since` tells; "" for an idle machine."""
    if busy is None:
        return ""
    found = [f"other programs took {100 * busy['others']:.0f} %"] if busy["others"] > OTHERS else []
    found += [f"the host took {100 * busy['stolen']:.0f} %"] if busy["stolen"] > STOLEN else []
    return f"the machine was busy: {' and '.join(found)} of its processors' time" if found else ""


class Load:
    """Watches the processors from when it is made."""

    def __init__(self) -> None:
        self._began = _columns(), time.process_time()

    def since(self) -> dict[str, float] | None:
        """Shares of their time since then: that ``others`` took, and that a virtual machine's host had ``stolen``; None
        where the system does not tell."""
        (before, own_before), (now, own) = self._began, (_columns(), time.process_time())
        if before is None or now is None:
            return None
        spent = [b - a for a, b in zip(before, now, strict=True)]
        whole = max(1, sum(spent))
        working = whole - spent[IDLE] - spent[WAIT] - spent[STEAL]
        mine = (own - own_before) * os.sysconf("SC_CLK_TCK")
        return {"others": max(0.0, working - mine) / whole, "stolen": spent[STEAL] / whole}


def _columns() -> list[int] | None:
    """Ticks of what the processors that this process may use have done, by column; None where Linux is not there."""
    try:
        with open("/proc/stat", encoding="ascii") as file:
            lines = [line.split() for line in file if line.startswith("cpu") and line[3].isdigit()]
        mine = {f"cpu{number}" for number in os.sched_getaffinity(0)}
        rows = [[int(one) for one in words[1 : STEAL + 2]] for words in lines if words[0] in mine]
    except (OSError, ValueError, AttributeError):
        return None
    return [sum(column) for column in zip(*rows, strict=True)] or None
