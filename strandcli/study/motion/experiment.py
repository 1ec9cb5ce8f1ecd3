"""The axis of motion: where a preset's strands are, against the limit that finer settings of the same solver lead to.

Strands are compared at fixed physical times and at even shares of their length; the error is that of the median strand,
and those of the worst are told beside. Every solver is measured against its own limit, because each moves another
matter; how far its limit is from that of the preset's own solver is told too.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Mapping
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import UsageError
from ...groom.record import Groom
from ...scene.model import Scene
from ...simulate.rod.material import rigidity
from ...simulate.rod.surroundings import gravity
from ..axes import STRANDS, Axis, Request, chosen_solvers
from ..points import Knobs, Limit, Point, described, grid, limit
from .contestants import CONTESTANTS, Contestant, warm_up
from .resample import apart, resample
from .strands import guides_of, with_fewer_guides
from .watch import Stopwatch, least

PLACES = 33
"""Points a strand that are compared."""
TIMES = 8
"""Frames that are compared, at the most."""
NOISE = 1e-6
"""Share of the length below which positions in single precision tell nothing."""
MOST_ITERATIONS = 1000
"""That a preset may ask for."""
SPAN = 1.0
"""Seconds of the film that are run, at the most, the pre-roll not counted."""


class Motion:
    """Runs of one preset."""

    metric, unit = "median", "of the length"

    def __init__(self, request: Request) -> None:
        scene = request.scene
        assert scene is not None
        if scene.panels:
            raise UsageError(f"{request.name}: a preset of several panels; study the preset of one panel")
        scene = with_fewer_guides(scene, request.name, request.strands or STRANDS)
        self.scene, self.request = scene, request
        self.title = f"{request.name}: positions against the limit of each solver"
        span = SPAN if request.span is None else request.span
        last = min(scene.time.frames, max(2, round(span * scene.time.fps) + 1))
        self.frames = sorted({round(f) for f in np.linspace(1, last, min(TIMES, last))})
        self.absent: list[dict[str, str]] = []
        self.contestants: list[Contestant] = []
        for name in chosen_solvers(request):
            why = CONTESTANTS[name].refuses(self._scene({"solver": name}))
            if why:
                self.absent.append({"solver": name, "why": f"not represented: {why}"})
            else:
                self.contestants.append(CONTESTANTS[name])
        self.limits: dict[str, Limit] = {}
        self.finest: dict[str, NDArray[np.float64]] = {}
        groom = self._groom(scene)
        self.lengths = groom.emitted(groom.lengths)

    @property
    def references(self) -> int:
        """Three a solver, each twice as fine as the one before."""
        return 3 * len(self.contestants)

    def _scene(self, knobs: Knobs) -> Scene:
        solver = CONTESTANTS[knobs["solver"]].scene_solver()
        return with_knobs(self.scene, {**knobs, "solver": solver})

    def _groom(self, scene: Scene) -> Groom:
        return guides_of(scene, min(self.request.strands or STRANDS, scene.emitter.strands))

    def particles(self) -> tuple[int, ...]:
        """Counts to try: half the preset's segments, and its own number."""
        own = self.scene.emitter.particles
        return self.request.particles or tuple(sorted({max(2, own // 2 + 1), own}))

    def substeps(self, one: Contestant) -> tuple[int, ...]:
        """Steps a frame to try. Raises `UsageError` for a step in seconds that no frame can be divided into."""
        if self.request.steps is None:
            return self.request.substeps or one.substeps
        found = []
        for dt in self.request.steps:
            count = 1 / (self.scene.time.fps * dt)
            if round(count) < 1 or abs(count - round(count)) > 1e-6 * count:
                raise UsageError(f"--dt {dt:g}: is no whole part of a frame, 1/{self.scene.time.fps:g} s")
            found.append(round(count))
        return tuple(found)

    def iterations(self, one: Contestant) -> tuple[int, ...]:
        """Iterations a step to try: few, and as many as the preset allows."""
        return self.request.iterations or tuple(sorted({*one.iterations[:-1], self.scene.rod.iterations}))

    def settings(self) -> list[dict[str, Any]]:
        """Substeps, particles, and iterations where a solver has them."""
        out: list[dict[str, Any]] = []
        for one in self.contestants:
            choices: dict[str, Any] = {"solver": (one.name,), "emitter.particles": self.particles()}
            if one.iterations:
                choices["rod.iterations"] = self.iterations(one)
            out += grid({**choices, "time.substeps": self.substeps(one)})
        return out

    def finer(self, one: Contestant) -> list[dict[str, Any]]:
        """Settings of the runs that show the limit: the finest twice as fine as all that is tried, and two coarser."""
        steps, segments = 2 * max(self.substeps(one)), 2 * (max(self.particles()) - 1)
        more: dict[str, Any] = {}
        if one.iterations:
            more["rod.iterations"] = min(MOST_ITERATIONS, 2 * max(self.iterations(one)))
        return [
            {
                "solver": one.name,
                "emitter.particles": max(2, -(-segments // part) + 1),
                "time.substeps": max(1, steps // part),
                **more,
            }
            for part in (4, 2, 1)
        ]

    def prepare(self, step: Callable[[str], None]) -> dict[str, Any]:
        """Find each solver's limit, and how well it is known."""
        told: dict[str, Any] = {}
        for one in self.contestants:
            runs = []
            for knobs in self.finer(one):
                (strands, _), seconds = self.run(knobs)
                runs.append(strands)
                step(f"limit of {described(knobs)}: {seconds:.3g} s")
            gaps = [apart(a, b, self.lengths)[self.metric] for a, b in pairwise(runs)]
            gaps = [gap if np.isfinite(gap) else math.inf for gap in gaps]
            self.limits[one.name] = limit(gaps[0], gaps[1], NOISE)
            self.finest[one.name] = runs[-1]
            told[one.name] = {"knobs": knobs, "gaps": gaps, **dataclasses.asdict(self.limits[one.name])}
        own = self.finest.get(self.scene.solver)
        for name, strands in self.finest.items():
            away = None if own is None else apart(strands, own, self.lengths)[self.metric]
            told[name]["from_own_solver"] = away if away is not None and np.isfinite(away) else None
        return {"name": self.request.name, "frames": self.frames, "limits": told, "bend": self.bend()}

    def bend(self) -> float | None:
        """Within what share of their length rods bend at their roots: 1 / √Γ, Γ = g L³ ρ A / B. Longer segments cannot
        show it. None without a rod, or without weight."""
        pull = float(np.linalg.norm(gravity(self.scene)))
        if pull == 0 or not any(one.iterations for one in self.contestants):
            return None
        return float(np.sqrt(rigidity(self.scene.rod) / (pull * np.mean(self.lengths, dtype=np.float64) ** 3)))

    def margins(self) -> Mapping[str, float]:
        """The uncertainty of each solver's limit."""
        return {name: one.uncertainty for name, one in self.limits.items()}

    def measure(self, knobs: Knobs) -> Point:
        """One run."""
        (strands, worst), seconds = least(lambda: self.run(knobs))
        error: dict[str, float | None] = dict.fromkeys(("median", "p95", "rms", "max"))
        finest = self.finest[knobs["solver"]]
        if np.isfinite(strands).all() and np.isfinite(finest).all():
            error.update(apart(strands, finest, self.lengths))
        dt = 1 / (self.scene.time.fps * knobs["time.substeps"])
        return Point(
            knobs=knobs,
            seconds=seconds,
            error={**error, **worst},
            solver=knobs["solver"],
            sizes={"dt": dt, "segment": 1 / (knobs["emitter.particles"] - 1)},
        )

    def run(self, knobs: Knobs) -> tuple[tuple[NDArray[np.float64], dict[str, float | None]], float]:
        """(T, strands, places, 3) metres at the frames that are compared, the greatest stretch and penetration as
        shares of the mean length, and the seconds that the steps took."""
        scene, contestant = self._scene(knobs), CONTESTANTS[knobs["solver"]]
        groom = self._groom(scene)
        warm_up(lambda: contestant.start(scene, groom), 1 / (scene.time.fps * scene.time.substeps))
        solver = contestant.start(scene, groom)
        watch = Stopwatch(solver)
        found = []
        worst: dict[str, float | None] = {"stretch": None, "penetration": None}
        for frame in self.frames:
            solver.advance(frame)
            found.append(resample(solver.particles(), PLACES))
            errors = solver.errors(frame)
            _raise(worst, "stretch", errors["stretch_max"], 1.0)
            _raise(worst, "penetration", errors["penetration_max"], scene.emitter.length)
        return (np.array(found), worst), watch.seconds


def _raise(worst: dict[str, float | None], name: str, value: float | None, unit: float) -> None:
    if value is not None and np.isfinite(value):
        worst[name] = max(worst[name] or 0.0, value / unit)


def with_knobs(scene: Scene, knobs: Knobs) -> Scene:
    """A scene with some settings changed, by dotted path through its mappings. The values are not validated."""
    for path, value in knobs.items():
        outer, _, leaf = path.rpartition(".")
        if outer:
            value = dataclasses.replace(getattr(scene, outer), **{leaf: value})
        scene = dataclasses.replace(scene, **{outer or leaf: value})
    return scene


AXIS = Axis(
    name="motion",
    doc="positions against each solver's own limit",
    knobs=("solver", "time.substeps", "emitter.particles", "rod.iterations"),
    metric="median",
    of_preset=True,
    open=Motion,
)
