"""The axis of interaction: how fine its cells are, how many guides stand for the hair that is drawn, and how many
iterations a step may take.

Each is turned alone, everything else as the preset has it; those that are named, together. The reference has half of
the finest cell, twice the most guides and twice the most iterations of what is turned; two runs, each half as fine as
the next, show how well it is known. Twice the guides stand 1 / √2 as far apart. With fewer guides each stands for more
strands, `children.count`, so that all runs have the same hair.

What is seen of hair is where it is, not which strand is where: `elsewhere` is the share of all hair that is in another
cell of the preset's own size, which knows nothing of single strands. Beside it stand hairs at common roots, shares of
their length: `mean`, `median`, `p95` and `rms` of their root mean squares. What a run has of itself: `too_dense`, the
share of all hair beyond the density that the rule allows, in cells of the preset's own size; and the greatest of its
frames, by how much the densest cell of its own is denser than allowed (`denser`), depth in solids over the strands'
length (`penetration`).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from ...errors import UsageError
from ...groom.blocks import arranged
from ...groom.deforming import at_start
from ...groom.emit import emit
from ...scene.model import Scene
from ...simulate import solver_of
from ...simulate.grid.strands import extent_of
from ...simulate.rod.material import CELLS_ACROSS, require_between
from ..axes import Experiment, Request
from ..points import Limit, Parameters, Point, described, grid, limit
from ..settings import changed
from .experiment import MOST_ITERATIONS, NOISE, PLACES, frames_of
from .hairs import Array, Hairs, Ruler, elsewhere
from .runs import least, resample, warm

CELL, GUIDES, COUNT, ITERATIONS = "rules.interaction.cell", "emitter.strands", "children.count", "rod.iterations"
COARSER = (4, 2**1.5, 2, 2**0.5, 1)
"""Times the preset's own cell: cells to try. A preset's own may be as fine as its strands are apart, and finer ones
tell single strands."""
ITERATED = (1, 2, 4, 8)
"""Iterations to try. Two are usual, and more only where strands are pressed hard."""
MOST_COUNT = 10_000
"""Children of a guide that a preset may have."""
MOST_HAIRS = 4096
"""That are compared: the first ones."""
FRAMES = {"denser": "density_max", "penetration": "penetration_max"}
"""Errors of a run by the names that those of its frames have."""
NAMES = ("elsewhere", "mean", "too_dense", *FRAMES, "p95", "median", "rms")
"""All errors, those first that a table has room for."""


@dataclass(frozen=True)
class Turned:
    """What is turned together, against one reference: values by parameter, `COUNT` following from `GUIDES`."""

    name: str
    values: Mapping[str, tuple[Any, ...]]


class Found(NamedTuple):
    """Of a run."""

    hairs: Array
    """As `Hairs.led_by` returns them."""
    cells: list[Array]
    """In each frame, metres in cells."""
    own: dict[str, float | None]
    """Errors that need no other run; None of what it does not have."""


class Interaction(Experiment):
    """Runs of one preset."""

    axis = "interaction"
    metric, unit = "elsewhere", "of the hair or of its length"

    def __init__(self, request: Request) -> None:
        self.scene = scene = request.single
        self.name = request.name
        if scene.emitter.groom is not None:
            raise UsageError(
                f"{self.name}: has the strands of a file, and those that stand for others follow from that; "
                "--cells and --guides are for strands that are grown"
            )
        uses = [use.name for use in scene.rules]
        self.place = uses.index("interaction") if "interaction" in uses else None
        self.rule = None if self.place is None else scene.rules[self.place].parameters
        self.touching = "contact" in uses
        self.total = scene.emitter.strands * (scene.children.count if scene.children else 1)
        self._require(request)
        self.cell = self._own_cell()
        self.turned = self._turned(request)
        self.references = 3 * len(self.turned)
        self.title = f"{request.name}: hair against finer cells, more guides and more iterations"
        self.frames = frames_of(scene, request.span)
        finest = [self.finer(one)[-1] for one in self.turned]
        for parameters in (*self.settings(), *finest):
            made = self.scene_with(parameters)
            require_between(made, emit(made.emitter, made.seed, made.emitter.strands))
        most = max(finest, key=lambda parameters: parameters.get(GUIDES, 0))
        self.hairs = Hairs(self.scene_with(most), min(most.get(GUIDES, scene.emitter.strands), MOST_HAIRS))
        density = None if self.rule is None else self.rule.density
        self._ruler = Ruler(self.cell, density, float(self.hairs.lengths.max()) / 2)
        self._limits: dict[str, Limit] = {}
        self._finest: dict[str, Found] = {}
        self._runs: dict[tuple[Any, ...], tuple[Found, float]] = {}

    def _require(self, request: Request) -> None:
        """Raise `UsageError` for what cannot be studied of the preset."""
        if self.rule is None and (request.cells or request.iterations or not request.guides):
            raise UsageError(
                f"{self.name}: lists no rule interaction, whose cells are to be studied; add the rule, or study "
                "--guides alone"
            )
        if self.rule is not None and self.rule.density is None:
            raise UsageError(
                f"{self.name}: rule interaction has no density, so that each setting would find another; add "
                "--set rules.interaction.density=N"
            )
        if request.guides and self.touching:
            raise UsageError(
                f"{self.name}: by rule contact strands touch as they are simulated, whatever they stand for; "
                "--guides is for presets without it"
            )
        if request.guides and 2 * max(request.guides) > self.total:
            raise UsageError(
                f"--guides: the reference has twice the most, and {self.name} has {self.total:,} strands; name at most "
                f"{self.total // 2:,}"
            )
        if request.guides and self.total > MOST_COUNT * min(request.guides):
            raise UsageError(
                f"--guides: {min(request.guides):,} would stand for more than {MOST_COUNT:,} strands each of "
                f"the {self.total:,} of {self.name}; name at least {-(-self.total // MOST_COUNT):,}"
            )

    def _own_cell(self) -> float:
        """The preset's cell, or that which the solver chooses."""
        if self.rule is not None and self.rule.cell is not None:
            return float(self.rule.cell)
        scene = changed(self.scene, {"children": None})
        solver: Any = solver_of(scene)(scene, emit(scene.emitter, scene.seed))
        return extent_of(solver.positions) / CELLS_ACROSS if self.rule is None else float(solver.grid.cell)

    def _turned(self, request: Request) -> list[Turned]:
        """What is named, together; else each alone."""
        scene = self.scene
        given = {
            GUIDES: tuple(sorted(request.guides or ())), CELL: tuple(sorted(request.cells or (), reverse=True)),
            ITERATIONS: tuple(sorted(request.iterations or ())),
        }  # fmt: skip
        names = {CELL: "cells", GUIDES: "guides", ITERATIONS: "iterations"}
        named = {parameter: values for parameter, values in given.items() if values}
        if named:
            return [Turned(names[next(iter(named))] if len(named) == 1 else scene.solver, named)]
        widest = max(self.cell, float(emit(scene.emitter, scene.seed).lengths.max()))
        own = min(scene.emitter.strands, self.total // 2)
        usual: dict[str, tuple[Any, ...]] = {
            CELL: tuple(float(f"{self.cell * more:.3g}") for more in COARSER if self.cell * more <= widest),
            GUIDES: () if self.touching else tuple(sorted({max(own // part, 1) for part in (4, 2, 1)})),
            ITERATIONS: ITERATED,
        }
        return [Turned(names[parameter], {parameter: values}) for parameter, values in usual.items() if values]

    def settings(self) -> list[dict[str, Any]]:
        """All combinations of what is turned together."""
        return [self._standing(parameters) for one in self.turned for parameters in grid(one.values)]

    def _standing(self, parameters: Parameters) -> dict[str, Any]:
        """Settings with which their guides stand for all strands."""
        if GUIDES not in parameters:
            return dict(parameters)
        return {GUIDES: parameters[GUIDES], COUNT: round(self.total / parameters[GUIDES]), **parameters}

    def finer(self, one: Turned) -> list[dict[str, Any]]:
        """Settings of the runs that show how well the reference, the last, is known."""
        found = []
        for step in (2.0, 1.0, 0.5):
            parameters: dict[str, Any] = {}
            for parameter, values in one.values.items():
                if parameter == CELL:
                    parameters[parameter] = min(values) * step
                else:
                    most = MOST_ITERATIONS if parameter == ITERATIONS else self.total
                    parameters[parameter] = min(max(1, int(max(values) / step)), most)
            found.append(self._standing(parameters))
        return found

    def scene_with(self, parameters: Parameters) -> Scene:
        """The preset with settings."""
        paths = {CELL: f"rules.{self.place}.parameters.cell"}
        return changed(self.scene, {paths.get(path, path): value for path, value in parameters.items()})

    def prepare(self, step: Callable[[str], None]) -> dict[str, Any]:
        """Run the references, and two coarser ones of each."""
        told = {}
        for one in self.turned:
            runs: list[Found] = []
            for parameters in self.finer(one):
                found, seconds = self._runs[self._key(parameters)] = self._runs.get(self._key(parameters)) or self.run(
                    parameters
                )
                runs.append(found)
                step(f"reference {described(parameters)}: {seconds:.3g} s")
            apart = [errors_of(a, b)[self.metric] for a, b in pairwise(runs)]
            gaps = [math.inf if gap is None else gap for gap in apart]
            ratio = math.sqrt(2) if set(one.values) == {GUIDES} else 2.0
            self._limits[one.name], self._finest[one.name] = limit(gaps[0], gaps[1], NOISE, ratio), runs[-1]
            told[one.name] = {"parameters": parameters, "gaps": gaps, **asdict(self._limits[one.name])}
        return {
            "name": self.name, "frames": self.frames, "hairs": len(self.hairs.lengths), "cell": self.cell,
            "limits": told,
        }  # fmt: skip

    def margins(self) -> Mapping[str, float]:
        """How well each reference is known."""
        return {name: one.uncertainty for name, one in self._limits.items()}

    def measure(self, parameters: Parameters) -> Point:
        """One run, or what a reference has found already."""
        found, seconds = self._runs.get(self._key(parameters)) or least(lambda: self.run(parameters))
        turned = next(one for one in self.turned if set(one.values) == set(parameters) - {COUNT})
        sizes = {"cell": parameters[CELL]} if CELL in parameters else {}
        series = ""
        if GUIDES in parameters:
            sizes["spacing"] = math.sqrt(1 / parameters[GUIDES])
            series = f"{turned.name} {parameters[GUIDES]:,} guides" if CELL in parameters else ""
        return Point(
            parameters, seconds, errors_of(found, self._finest[turned.name]), turned.name, sizes, series=series
        )

    def _key(self, parameters: Parameters) -> tuple[Any, ...]:
        """What a run is known by: one of the preset's own settings is the same whatever is turned."""
        scene = self.scene
        own = self._standing({GUIDES: scene.emitter.strands, ITERATIONS: scene.rod.iterations, CELL: self.cell})
        return tuple({**own, **parameters}.values())

    def run(self, parameters: Parameters) -> tuple[Found, float]:
        """Return a run and the seconds that its steps took. Raises `UsageError` for cells that do not fit."""
        scene = self.scene_with(parameters)
        groom = at_start(scene, arranged(emit(scene.emitter, scene.seed)))
        worst: dict[str, float] = {}
        points, cells = [], []
        metres = groom.emitted(groom.lengths) * (self.total / groom.strands)
        try:
            solver, watch = warm(lambda: solver_of(scene)(scene, groom), 1 / (scene.time.fps * scene.time.substeps))
            for frame in self.frames:
                solver.advance(frame)
                points.append(resample(solver.particles(), PLACES))
                cells.append(self._ruler.metres(points[-1], metres))
                errors = solver.errors(frame)
                for name, of_frame in FRAMES.items():
                    value = errors.get(of_frame)
                    if value is not None and math.isfinite(value):
                        worst[name] = max(worst.get(name, 0.0), value)
        except UsageError as error:
            raise UsageError(f"{error}; the reference has half of the least of --cells") from None
        own: dict[str, float | None] = {name: worst.get(name) for name in FRAMES}
        if "denser" in worst:
            own["denser"] = max(worst["denser"] - 1, 0.0)
        if "penetration" in worst:
            own["penetration"] = worst["penetration"] / scene.emitter.length
        own["too_dense"] = self._ruler.too_dense(cells)
        return Found(self.hairs.led_by(groom.strands, np.array(points)), cells, own), watch.seconds


def errors_of(found: Found, finest: Found) -> dict[str, float | None]:
    """Return the errors of a run against the finest one."""
    error: dict[str, float | None] = {**dict.fromkeys(NAMES), **found.own}
    if np.isfinite(found.hairs).all() and np.isfinite(finest.hairs).all():
        each = np.sqrt(((found.hairs - finest.hairs) ** 2).sum(-1).mean((0, 2)))
        error["mean"], error["median"] = float(each.mean()), float(np.median(each))
        error["p95"], error["rms"] = float(np.percentile(each, 95)), float(np.sqrt((each**2).mean()))
        error["elsewhere"] = float(np.mean([elsewhere(*pair) for pair in zip(found.cells, finest.cells, strict=True)]))
    return error
