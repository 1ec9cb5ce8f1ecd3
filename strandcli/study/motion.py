"""The axis of motion: where a preset's strands are, against the limit that finer settings of the same solver converge
to.

Strands are compared at fixed physical times and at even shares of their length; the error is that of the median strand,
and those of the worst are reported beside. Every solver is measured against its own limit, because each moves another
matter. Cells of the rule interaction are varied where they are named.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from dataclasses import asdict, replace
from itertools import pairwise
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from ..errors import UsageError
from ..groom.emit import emit
from ..groom.record import Groom
from ..scene.model import Scene
from ..simulate import solver_of
from .points import CELL, Limit, Parameters, Point, described, grid, limit
from .sweep import STRANDS, Experiment, Request, changed, chosen_solvers

PLACES = 33
"""Points a strand that are compared."""
TIMES = 8
"""Frames that are compared, at the most."""
NOISE = 1e-6
"""Share of the length below which positions in single precision say nothing."""
MOST_ITERATIONS = 1000
"""That a preset may ask for."""
SPAN = 1.0
"""Seconds of the film that are run, at the most, the pre-roll not counted."""
SUBSTEPS = (1, 2, 4, 8)
"""Steps a frame to try."""
FEW = 2
"""Iterations a step to try beside the preset's own."""


class Motion(Experiment):
    """Runs of one preset."""

    axis = "motion"
    metric, unit = "median", "of the length"

    def __init__(self, request: Request) -> None:
        self.request = request
        self.scene = scene = with_fewer_guides(request.single, request.name, request.strands or STRANDS)
        self.title = f"{request.name}: positions against the limit of each solver"
        span = SPAN if request.span is None else request.span
        last = min(scene.time.frames, max(2, round(span * scene.time.fps) + 1))
        self.frames = sorted({round(frame) for frame in np.linspace(1, last, min(TIMES, last))})
        uses = [use.name for use in scene.rules]
        if request.cells and "interaction" not in uses:
            raise UsageError(f"--cells: {request.name} lists no rule interaction, whose cells they are")
        self._cell = f"rules.{uses.index('interaction')}.parameters.cell" if request.cells else ""
        refused = {name: self.refusal(name) for name in chosen_solvers(request)}
        self.absent = [{"solver": name, "why": f"not represented: {why}"} for name, why in refused.items() if why]
        self.solvers = [name for name, why in refused.items() if not why]
        self.references = 3 * len(self.solvers)
        self.limits: dict[str, Limit] = {}
        self.finest: dict[str, NDArray[np.float64]] = {}
        groom = self._groom(scene)
        self.lengths = groom.emitted(groom.lengths)

    def refusal(self, solver: str) -> str:
        """Why a solver cannot run the scene, or nothing: asked by handing it a single strand, or a file's."""
        scene = changed(self.scene, {"solver": solver})
        try:
            solver_of(scene)(scene, guides_of(scene, 1))
        except UsageError as error:
            return str(error)
        return ""

    def _groom(self, scene: Scene) -> Groom:
        return guides_of(scene, min(self.request.strands or STRANDS, scene.emitter.strands))

    def particles(self) -> tuple[int, ...]:
        """Counts to try: half the preset's segments, and its own number."""
        own = self.scene.emitter.particles
        few = own if "emitter.particles" in self.request.fixed else max(2, own // 2 + 1)
        return self.request.particles or tuple(sorted({few, own}))

    def substeps(self) -> tuple[int, ...]:
        """Steps a frame to try. Raises `UsageError` for a step in seconds that no frame can be divided into."""
        if self.request.steps is None:
            usual = (self.scene.time.substeps,) if "time.substeps" in self.request.fixed else SUBSTEPS
            return self.request.substeps or usual
        found = []
        for dt in self.request.steps:
            count = 1 / (self.scene.time.fps * dt)
            if round(count) < 1 or abs(count - round(count)) > 1e-6 * count:
                raise UsageError(f"--dt {dt:g}: is no whole part of a frame, 1/{self.scene.time.fps:g} s")
            found.append(round(count))
        return tuple(found)

    def iterations(self) -> tuple[int, ...]:
        """Iterations a step of rods to try: few, and as many as the preset allows."""
        own = self.scene.rod.iterations
        few = own if "rod.iterations" in self.request.fixed else FEW
        return self.request.iterations or tuple(sorted({few, own}))

    def settings(self) -> list[dict[str, Any]]:
        """Substeps, particles, of rods iterations, and cells where they are named."""
        out: list[dict[str, Any]] = []
        for name in self.solvers:
            choices: dict[str, Any] = {"solver": (name,), "emitter.particles": self.particles()}
            if name == "rod":
                choices["rod.iterations"] = self.iterations()
            if self.request.cells:
                choices[CELL] = self.request.cells
            out += grid({**choices, "time.substeps": self.substeps()})
        return out

    def finer(self, solver: str) -> list[dict[str, Any]]:
        """Settings of the runs that show the limit: the finest twice as fine as all that is tried, and two coarser."""
        steps, segments = 2 * max(self.substeps()), 2 * (max(self.particles()) - 1)
        most = min(MOST_ITERATIONS, 2 * max(self.iterations()))
        return [
            {
                "solver": solver, "emitter.particles": max(2, -(-segments // part) + 1),
                "time.substeps": max(1, steps // part), **({"rod.iterations": most} if solver == "rod" else {}),
                **({CELL: min(self.request.cells) * part / 2} if self.request.cells else {}),
            }
            for part in (4, 2, 1)
        ]  # fmt: skip

    def prepare(self, step: Callable[[str], None]) -> dict[str, Any]:
        """Find each solver's limit, and how well it is known."""
        reported: dict[str, Any] = {}
        for name in self.solvers:
            runs = []
            for parameters in self.finer(name):
                (strands, _), seconds = self.run(parameters)
                runs.append(strands)
                step(f"limit of {described(parameters)}: {seconds:.3g} s")
            gaps = [apart(a, b, self.lengths)[self.metric] for a, b in pairwise(runs)]
            gaps = [gap if np.isfinite(gap) else math.inf for gap in gaps]
            self.limits[name] = limit(gaps[0], gaps[1], NOISE)
            self.finest[name] = runs[-1]
            reported[name] = {"parameters": parameters, "gaps": gaps, **asdict(self.limits[name])}
        return {"name": self.request.name, "frames": self.frames, "limits": reported}

    def margins(self) -> Mapping[str, float]:
        """The uncertainty of each solver's limit."""
        return {name: one.uncertainty for name, one in self.limits.items()}

    def measure(self, parameters: Parameters) -> Point:
        """One run."""
        (strands, worst), seconds = least(lambda: self.run(parameters))
        error: dict[str, float | None] = dict.fromkeys(("median", "p95", "rms", "max"))
        finest = self.finest[parameters["solver"]]
        if np.isfinite(strands).all() and np.isfinite(finest).all():
            error.update(apart(strands, finest, self.lengths))
        dt = 1 / (self.scene.time.fps * parameters["time.substeps"])
        sizes = {"dt": dt, "segment": 1 / (parameters["emitter.particles"] - 1)}
        sizes |= {"cell": parameters[CELL]} if self._cell else {}
        return Point(parameters, seconds, {**error, **worst}, parameters["solver"], sizes)

    def run(self, parameters: Parameters) -> tuple[tuple[NDArray[np.float64], dict[str, float | None]], float]:
        """(T, strands, places, 3) metres at the frames that are compared, the greatest stretch and penetration as
        shares of the mean length, and the seconds that the steps took."""
        paths = {CELL: self._cell}
        scene = changed(self.scene, {paths.get(path, path): value for path, value in parameters.items()})
        groom = self._groom(scene)
        solver = warm(lambda: solver_of(scene)(scene, groom), 1 / (scene.time.fps * scene.time.substeps))
        found, seconds = [], 0.0
        worst: dict[str, float | None] = {"stretch": None, "penetration": None}
        for frame in self.frames:
            began = time.perf_counter()
            solver.advance(frame)
            seconds += time.perf_counter() - began
            found.append(resample(solver.particles(), PLACES))
            errors = solver.errors(frame)
            for name, value, unit in (
                ("stretch", errors["stretch_max"], 1.0),
                ("penetration", errors["penetration_max"], scene.emitter.length),
            ):
                if value is not None and np.isfinite(value):
                    worst[name] = max(worst[name] or 0.0, value / unit)
        return (np.array(found), worst), seconds


T = TypeVar("T")
Array = NDArray[np.float64]


def guides_of(scene: Scene, most: int | None = None) -> Groom:
    """What a scene simulates, at most the first so many of the strands that it grows."""
    if scene.emitter.groom is None:
        return emit(scene.emitter, scene.seed, most)
    from ..groom_file import guided

    return guided(scene).guides


def with_fewer_guides(scene: Scene, name: str, most: int) -> Scene:
    """A scene that simulates at most so many of the strands of its file, where it has one. Raises `UsageError` where
    nothing moves these."""
    given = scene.emitter.groom
    if given is None:
        return scene
    if not scene.guided:
        raise UsageError(f"{name}: nothing moves the strands of its file; list a rule, or study an --axis of pictures")
    if given.guides <= most:
        return scene
    from ..groom_file import completed

    emitter = replace(scene.emitter, groom=replace(given, guides=most), followers=None)
    return completed(replace(scene, emitter=emitter))


def warm(make: Callable[[], Any], dt: float) -> Any:
    """A solver. What has to be compiled is compiled by two steps of one that is thrown away."""
    solver = make()
    for i in range(2):
        solver.step((i + 1) * dt, dt)
    return make()


def least(run: Callable[[], tuple[T, float]], quick: float = 0.2, times: int = 3) -> tuple[T, float]:
    """What a run gives, with the least of its seconds: one that is quick is repeated, to be timed fairly."""
    found, seconds = run()
    while seconds < quick and times > 1:
        found, again = run()
        seconds = min(seconds, again)
        times -= 1
    return found, seconds


def follow(make: Callable[[], Any], dt: float, span: float, moving: bool) -> tuple[Array, Array, float]:
    """Run a solver from rest for a span of seconds in steps of ``dt``; returns times (T,), positions
    (T, strands, particles, 3), of every step where it is ``moving`` and else of the first and the last, and the seconds
    that the steps took, compiling not counted."""
    solver = warm(make, dt)
    steps, seconds = max(1, round(span / dt)), 0.0
    times, positions = [0.0], [solver.particles().astype(np.float64)]
    for i in range(steps):
        began = time.perf_counter()
        solver.step((i + 1) * dt, dt)
        seconds += time.perf_counter() - began
        if moving or i == steps - 1:
            times.append((i + 1) * dt)
            positions.append(solver.particles().astype(np.float64))
    return np.array(times), np.array(positions), seconds


def resample(strands: NDArray[np.floating], places: int) -> Array:
    """(..., particles, 3) -> (..., places, 3): points at even shares of each polyline's own length, both ends included.
    A strand of no length is repeated."""
    points = np.asarray(strands, np.float64)
    sizes = np.linalg.norm(np.diff(points, axis=-2), axis=-1)
    along = np.concatenate([np.zeros((*sizes.shape[:-1], 1)), np.cumsum(sizes, -1)], -1)
    goals = along[..., -1:] * np.linspace(0, 1, places)
    after = (along[..., None, 1:-1] <= goals[..., None]).sum(-1)  # the segment that each goal lies on
    start = np.take_along_axis(along, after, -1)
    size = np.take_along_axis(sizes, after, -1)
    share = np.clip((goals - start) / np.where(size > 0, size, 1.0), 0.0, 1.0)
    a = np.take_along_axis(points, after[..., None], -2)
    b = np.take_along_axis(points, after[..., None] + 1, -2)
    return np.asarray(a + share[..., None] * (b - a))


def apart(a: Array, b: Array, lengths: NDArray[np.floating]) -> dict[str, float]:
    """How far two sets of strands (T, strands, places, 3) are apart, as shares of each strand's length (strands,) in
    metres: ``median`` and ``p95`` over strands of each one's root mean square over places and times; ``rms`` over all,
    and the greatest distance of all, ``max``.

    Where strands meet solids, the least of differences decides to which side some fall; such motion has no limit. They
    show in p95 and max.
    """
    away = np.linalg.norm(a - b, axis=-1) / np.asarray(lengths, np.float64)[:, None]
    each = np.sqrt(np.mean(away**2, axis=(0, 2)))
    return {
        "median": float(np.median(each)), "p95": float(np.percentile(each, 95)),
        "rms": float(np.sqrt(np.mean(away**2))), "max": float(away.max()),
    }  # fmt: skip
