"""The axis of interaction: how fine its cells are, how many guides stand for the hair that is drawn, and how many
iterations a step may take.

Each is turned alone, everything else as the preset has it; those that are named, together. The reference has half of
the finest cell, twice the most guides and twice the most iterations of what is turned; two runs, each half as fine as
the next, show how well it is known. Twice the guides stand 1 / √2 as far apart. With fewer guides each stands for more
strands, `children.count`, so that all runs have the same hair. What errors there are: `crowded_run`.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from ...errors import UsageError
from ...groom.emit import emit
from ...scene.model import Children, RuleUse, Scene
from ...simulate import solver_of
from ...simulate.grid.box import extent_of
from ...simulate.rod.material import CELLS_ACROSS, require_between
from ..axes import Axis, Request
from ..points import Knobs, Limit, Point, described, grid, limit
from . import crowded_run
from .crowded_run import Found, Ruler, errors_of
from .experiment import MOST_ITERATIONS, NOISE, SPAN, TIMES, with_knobs
from .hairs import Hairs
from .watch import least

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
QUICK = 0.2
"""Seconds below which a run is repeated, to be timed fairly."""


@dataclass(frozen=True)
class Turned:
    """What is turned together, against one reference; nothing of what stays."""

    name: str
    cells: tuple[float, ...] = ()
    guides: tuple[int, ...] = ()
    iterations: tuple[int, ...] = ()

    @property
    def knobs(self) -> set[str]:
        """Knobs of its settings."""
        found = {CELL: self.cells, GUIDES: self.guides, COUNT: self.guides, ITERATIONS: self.iterations}
        return {name for name, values in found.items() if values}


class Crowding:
    """Runs of one preset."""

    metric, unit = "elsewhere", "of the hair or of its length"
    absent: list[dict[str, str]]

    def __init__(self, request: Request) -> None:
        scene = request.scene
        assert scene is not None
        if scene.panels:
            raise UsageError(f"{request.name}: a preset of several panels; study the preset of one panel")
        if scene.emitter.groom is not None:
            raise UsageError(
                f"{request.name}: has the strands of a file, and those that stand for others follow from that; "
                "--cells and --guides are for strands that are grown"
            )
        self.scene, self.name, self.absent = scene, request.name, []
        self.use = next((use for use in scene.rules if use.name == "interaction"), None)
        self.total = scene.emitter.strands * (scene.children.count if scene.children else 1)
        self._require(request)
        self.cell = self._own_cell()
        self.turned = self._turned(request)
        self.title = f"{request.name}: hair against finer cells, more guides and more iterations"
        span = SPAN if request.span is None else request.span
        last = min(scene.time.frames, max(2, round(span * scene.time.fps) + 1))
        self.frames = sorted({round(f) for f in np.linspace(1, last, min(TIMES, last))})
        for knobs in (*self.settings(), *(self.finer(one)[-1] for one in self.turned)):
            made = self._scene(knobs)
            require_between(made, emit(made.emitter, made.seed, made.emitter.strands))
        most = max((self.finer(one)[-1] for one in self.turned), key=lambda knobs: knobs.get(GUIDES, 0))
        self.hairs = Hairs(self._scene(most), min(most.get(GUIDES, scene.emitter.strands), MOST_HAIRS))
        density = None if self.use is None else self.use.parameters.density
        self._ruler = Ruler(self.cell, density, self.total, float(self.hairs.lengths.max()) / 2)
        self._limits: dict[str, Limit] = {}
        self._finest: dict[str, Found] = {}
        self._runs: dict[tuple[Any, ...], tuple[Found, float]] = {}

    def _require(self, request: Request) -> None:
        """Raise `UsageError` for what cannot be studied of the preset."""
        if self.use is None and (request.cells or request.iterations or not request.guides):
            raise UsageError(
                f"{self.name}: lists no rule interaction, whose cells are to be studied; add the rule, or study "
                "--guides alone"
            )
        if self.use is not None and self.use.parameters.density is None:
            raise UsageError(
                f"{self.name}: rule interaction has no density, so that each setting would find another; add "
                "--set rules.interaction.density=N"
            )
        if request.guides and any(use.name == "contact" for use in self.scene.rules):
            raise UsageError(
                f"{self.name}: by rule contact strands touch as they are simulated, whatever they stand for; "
                "--guides is for presets without it"
            )

    def _own_cell(self) -> float:
        """The preset's cell, or that which the solver chooses."""
        given = None if self.use is None else self.use.parameters.cell
        if given is not None:
            return float(given)
        scene = dataclasses.replace(self.scene, children=None)
        solver = solver_of(scene)(scene, emit(scene.emitter, scene.seed))
        if self.use is None:
            return extent_of(solver.positions) / CELLS_ACROSS
        return float(solver.grid.cell)  # type: ignore[attr-defined]

    @property
    def references(self) -> int:
        """Three of each, each twice as fine as the one before."""
        return 3 * len(self.turned)

    def _turned(self, request: Request) -> list[Turned]:
        """What is named, together; else each alone."""
        cells = tuple(sorted(request.cells or (), reverse=True))
        iterations = tuple(sorted(request.iterations or ()))
        guides: tuple[int, ...] = self._guides(tuple(sorted(request.guides))) if request.guides else ()
        given = {"cells": cells, "guides": guides, "iterations": iterations}
        named = [name for name, values in given.items() if values]
        if named:
            return [Turned(named[0] if len(named) == 1 else self.scene.solver, cells, guides, iterations)]
        widest = max(self.cell, float(emit(self.scene.emitter, self.scene.seed).lengths.max()))
        usual = tuple(float(f"{self.cell * more:.3g}") for more in COARSER if self.cell * more <= widest)
        own = min(self.scene.emitter.strands, self.total // 2)
        touching = any(use.name == "contact" for use in self.scene.rules)
        fewer = tuple(sorted({max(own // part, 1) for part in (4, 2, 1)}))
        guides = () if touching else self._guides(fewer)
        each = Turned("cells", cells=usual), Turned("guides", guides=guides), Turned("iterations", iterations=ITERATED)
        return [one for one in each if one.knobs]

    def _guides(self, chosen: tuple[int, ...]) -> tuple[int, ...]:
        """Return numbers of guides to try. Raises `UsageError` for too many or too few."""
        if 2 * max(chosen) > self.total:
            raise UsageError(
                f"--guides: the reference has twice the most, and {self.name} has {self.total:,} strands; name at most "
                f"{self.total // 2:,}"
            )
        if self.total > MOST_COUNT * min(chosen):
            raise UsageError(
                f"--guides: {min(chosen):,} would stand for more than {MOST_COUNT:,} strands each of "
                f"the {self.total:,} of {self.name}; name at least {-(-self.total // MOST_COUNT):,}"
            )
        return chosen

    def settings(self) -> list[dict[str, Any]]:
        """All combinations of what is turned together."""
        found = []
        for one in self.turned:
            guides = [self._standing(count) for count in one.guides] or [{}]
            cells: list[dict[str, Any]] = [{CELL: cell} for cell in one.cells] or [{}]
            iterations: list[dict[str, Any]] = [{ITERATIONS: count} for count in one.iterations] or [{}]
            choices: dict[str, Any] = {"guides": guides, "cells": cells, "iterations": iterations}
            found += [{**it["guides"], **it["cells"], **it["iterations"]} for it in grid(choices)]
        return found

    def _standing(self, guides: int) -> dict[str, int]:
        """The settings with which so many guides stand for all strands."""
        return {GUIDES: guides, COUNT: round(self.total / guides)}

    def finer(self, one: Turned) -> list[dict[str, Any]]:
        """Settings of the runs that show how well the reference, the last, is known."""
        found = []
        for step in (2.0, 1.0, 0.5):
            knobs: dict[str, Any] = {}
            if one.guides:
                knobs |= self._standing(max(1, int(max(one.guides) / step)))
            if one.cells:
                knobs[CELL] = min(one.cells) * step
            if one.iterations:
                knobs[ITERATIONS] = min(max(1, int(max(one.iterations) / step)), MOST_ITERATIONS)
            found.append(knobs)
        return found

    def _scene(self, knobs: Knobs) -> Scene:
        scene = self.scene
        if GUIDES in knobs:
            children = dataclasses.replace(scene.children or Children(), count=knobs[COUNT])
            scene = dataclasses.replace(with_knobs(scene, {GUIDES: knobs[GUIDES]}), children=children)
        if ITERATIONS in knobs:
            scene = with_knobs(scene, {ITERATIONS: knobs[ITERATIONS]})
        if CELL in knobs:
            assert self.use is not None
            parameters = dataclasses.replace(self.use.parameters, cell=knobs[CELL])
            turned = RuleUse(self.use.name, parameters, self.use.path)
            scene = dataclasses.replace(scene, rules=tuple(turned if use is self.use else use for use in scene.rules))
        return scene

    def prepare(self, step: Callable[[str], None]) -> dict[str, Any]:
        """Run the references, and two coarser ones of each."""
        told = {}
        for one in self.turned:
            runs: list[Found] = []
            for knobs in self.finer(one):
                found, seconds = self._runs[self._key(knobs)] = self.run(knobs)
                runs.append(found)
                step(f"reference {described(knobs)}: {seconds:.3g} s")
            apart = [errors_of(a, b)[self.metric] for a, b in pairwise(runs)]
            gaps = [math.inf if gap is None else gap for gap in apart]
            ratio = 2.0 if one.cells or one.iterations else math.sqrt(2)
            self._limits[one.name], self._finest[one.name] = limit(gaps[0], gaps[1], NOISE, ratio), runs[-1]
            told[one.name] = {"knobs": knobs, "gaps": gaps, **dataclasses.asdict(self._limits[one.name])}
        return {
            "name": self.name, "frames": self.frames, "hairs": len(self.hairs.lengths), "cell": self.cell,
            "limits": told,
        }  # fmt: skip

    def margins(self) -> Mapping[str, float]:
        """How well each reference is known."""
        return {name: one.uncertainty for name, one in self._limits.items()}

    def measure(self, knobs: Knobs) -> Point:
        """One run."""
        found, seconds = self.run(knobs)
        if seconds < QUICK:
            found, seconds = least(lambda: crowded_run.run(self._scene(knobs), self.frames, self._ruler, self.hairs))
        turned = next(one for one in self.turned if one.knobs == set(knobs))
        sizes = {}
        if CELL in knobs:
            sizes["cell"] = knobs[CELL]
        if GUIDES in knobs:
            sizes["spacing"] = math.sqrt(1 / knobs[GUIDES])
        series = f"{turned.name} {knobs[GUIDES]:,} guides" if turned.cells and turned.guides else ""
        return Point(knobs, seconds, errors_of(found, self._finest[turned.name]), turned.name, sizes, series=series)

    def run(self, knobs: Knobs) -> tuple[Found, float]:
        """Return a run and its seconds; those of a reference that is known already. Raises `UsageError` for cells that
        do not fit."""
        known = self._runs.get(self._key(knobs))
        return known or crowded_run.run(self._scene(knobs), self.frames, self._ruler, self.hairs)

    def _key(self, knobs: Knobs) -> tuple[Any, ...]:
        """What a run is known by: one of the preset's own settings is the same whatever is turned."""
        own = {ITERATIONS: self.scene.rod.iterations, CELL: self.cell, **self._standing(self.scene.emitter.strands)}
        return tuple(({**own, **knobs}).values())


AXIS = Axis(
    name="interaction",
    doc="cells, guides and iterations of strands that interact, against finer ones",
    knobs=(CELL, GUIDES, COUNT, ITERATIONS),
    metric="elsewhere",
    of_preset=True,
    open=Crowding,
)
