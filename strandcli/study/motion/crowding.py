"""The axis of interaction: how fine its cells are, and how many guides stand for the hair that is drawn.

Both are turned alone or together, everything else stays as the preset has it. The reference has half of the finest cell
and twice the most guides; two runs, each half as fine as the next, show how well it is known. With fewer guides each
stands for more strands, `children.count`, so that all runs have the same hair.

Hairs are compared at common roots (`hairs`): those that the reference simulates. The error is the mean of their root
mean squares; the median would be that of hairs which are guides, or that of those which are not. Beside it stand how
much of the hair is in another cell of the preset's own size, which knows nothing of single strands, and by how much the
densest cell of a run is denser than allowed.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Mapping, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import UsageError
from ...groom.arrange import arranged
from ...groom.deforming import at_start
from ...groom.emit import emit
from ...scene.model import Children, RuleUse, Scene
from ...simulate import solver_of
from ...simulate.crowd_box import extent_of
from ...simulate.material import CELLS_ACROSS, require_between
from ..axes import Axis, Request
from ..points import Knobs, Limit, Point, described, grid, limit
from .contestants import warm_up
from .experiment import NOISE, PLACES, SPAN, TIMES, with_knobs
from .hairs import Hairs, elsewhere, in_cells
from .resample import resample
from .watch import Stopwatch, least

CELL, GUIDES, COUNT = "rules.interaction.cell", "emitter.strands", "children.count"
MOST_COUNT = 10_000
"""Children of a guide that a preset may have."""
MOST_HAIRS = 4096
"""That are compared: the first ones."""

Found = tuple[NDArray[np.float64], list[NDArray[np.float64]], float | None]
"""Of a run: hairs as `Hairs.led_by` returns them; in each frame, metres in cells; the greatest density over that
allowed."""


class Crowding:
    """Runs of one preset."""

    metric, unit = "mean", "of the length"
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
        if self.use is None and (request.cells or not request.guides):
            raise UsageError(
                f"{request.name}: lists no rule interaction, whose cells are to be studied; add the rule, or study "
                "--guides alone"
            )
        if self.use is not None and self.use.parameters.density is None:
            raise UsageError(
                f"{request.name}: rule interaction has no density, so that each setting would find another; add "
                "--set rules.interaction.density=N"
            )
        touching = next((use for use in scene.rules if use.name == "contact"), None)
        if touching is not None and not request.cells:
            raise UsageError(
                f"{request.name}: by rule contact strands touch as they are simulated, whatever they stand for; "
                "--guides is for presets without it"
            )
        self.cell = self._own_cell()
        both = not request.cells and not request.guides
        self.cells = self._cells(request.cells, both)
        self.guides = self._guides(request.guides, both and touching is None)
        self.title = f"{request.name}: hairs against finer cells and more guides"
        span = SPAN if request.span is None else request.span
        last = min(scene.time.frames, max(2, round(span * scene.time.fps) + 1))
        self.frames = sorted({round(f) for f in np.linspace(1, last, min(TIMES, last))})
        finest = self.finer()[-1]
        for knobs in (*self.settings(), finest):
            made = self._scene(knobs)
            require_between(made, emit(made.emitter, made.seed, made.emitter.strands))
        self.most = finest.get(GUIDES, scene.emitter.strands)
        self.hairs = Hairs(self._scene(finest), min(self.most, MOST_HAIRS))
        self._box: tuple[NDArray[np.float64], tuple[int, ...]] | None = None
        self._limit = Limit(math.inf, None, False)

    @property
    def references(self) -> int:
        """Three, each twice as fine as the one before."""
        return 3

    def _own_cell(self) -> float:
        """The preset's cell, or that which the solver chooses."""
        given = None if self.use is None else self.use.parameters.cell
        if given is not None:
            return float(given)
        scene = dataclasses.replace(self.scene, children=None)
        solver = solver_of(scene)(scene, emit(scene.emitter, scene.seed))
        if self.use is None:
            return extent_of(solver.positions) / CELLS_ACROSS
        return float(solver.crowd.cell)  # type: ignore[attr-defined]

    def _cells(self, given: Sequence[float] | None, usual: bool) -> tuple[float, ...]:
        """Cells to try, coarse ones first: the preset's own, and up to twice that; none where they stay."""
        if given is None and not usual:
            return ()
        return tuple(sorted(given or (float(f"{self.cell * more:.3g}") for more in (2, 2**0.5, 1)), reverse=True))

    def _guides(self, given: Sequence[int] | None, usual: bool) -> tuple[int, ...]:
        """Numbers of guides to try, few first: a quarter of the preset's own, half of that and all, of as many as
        leave the reference its own; none where they stay."""
        if given is None and not usual:
            return ()
        own = min(self.scene.emitter.strands, self.total // 2)
        chosen = tuple(sorted(given or {max(own // part, 1) for part in (4, 2, 1)}))
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
        """All combinations."""
        cells: list[dict[str, Any]] = [{CELL: cell} for cell in self.cells] or [{}]
        guides = [self._standing(count) for count in self.guides] or [{}]
        return [{**one["guides"], **one["cells"]} for one in grid({"guides": guides, "cells": cells})]  # type: ignore[dict-item]

    def _standing(self, guides: int) -> dict[str, int]:
        """The settings with which so many guides stand for all strands."""
        return {GUIDES: guides, COUNT: round(self.total / guides)}

    def finer(self) -> list[dict[str, Any]]:
        """Settings of the runs that show how well the reference, the last, is known."""
        found = []
        for step in (2.0, 1.0, 0.5):
            knobs: dict[str, Any] = {}
            if self.guides:
                knobs |= self._standing(max(1, int(max(self.guides) / step)))
            if self.cells:
                knobs[CELL] = min(self.cells) * step
            found.append(knobs)
        return found

    def _scene(self, knobs: Knobs) -> Scene:
        scene = self.scene
        if GUIDES in knobs:
            children = dataclasses.replace(scene.children or Children(), count=knobs[COUNT])
            scene = dataclasses.replace(with_knobs(scene, {GUIDES: knobs[GUIDES]}), children=children)
        if CELL in knobs:
            assert self.use is not None
            parameters = dataclasses.replace(self.use.parameters, cell=knobs[CELL])
            turned = RuleUse(self.use.name, parameters, self.use.path)
            scene = dataclasses.replace(scene, rules=tuple(turned if use is self.use else use for use in scene.rules))
        return scene

    def prepare(self, step: Callable[[str], None]) -> dict[str, Any]:
        """Run the reference, and two coarser ones."""
        runs: list[Found] = []
        for knobs in self.finer():
            found, seconds = self.run(knobs)
            runs.append(found)
            step(f"reference {described(knobs)}: {seconds:.3g} s")
        apart = [self._apart(a, b)[self.metric] for a, b in pairwise(runs)]
        gaps = [math.inf if gap is None else gap for gap in apart]
        self._limit, self._finest = limit(gaps[0], gaps[1], NOISE), runs[-1]
        told = {"knobs": knobs, "gaps": gaps, **dataclasses.asdict(self._limit)}
        return {
            "name": self.name, "frames": self.frames, "hairs": len(self.hairs.lengths), "cell": self.cell,
            "limits": {self.scene.solver: told},
        }  # fmt: skip

    def margins(self) -> Mapping[str, float]:
        """How well the reference is known."""
        return {self.scene.solver: self._limit.uncertainty}

    def measure(self, knobs: Knobs) -> Point:
        """One run."""
        found, seconds = least(lambda: self.run(knobs))
        sizes = {}
        if CELL in knobs:
            sizes["cell"] = knobs[CELL]
        if GUIDES in knobs:
            sizes["spacing"] = math.sqrt(1 / knobs[GUIDES])
        both = bool(self.cells and self.guides)
        series = f"{self.scene.solver} {knobs[GUIDES]:,} guides" if both else ""
        return Point(knobs, seconds, self._apart(found, self._finest), self.scene.solver, sizes, series=series)

    def _apart(self, found: Found, finest: Found) -> dict[str, float | None]:
        """The errors of a run."""
        error: dict[str, float | None] = dict.fromkeys(("mean", "median", "p95", "rms", "elsewhere", "denser"))
        if np.isfinite(found[0]).all() and np.isfinite(finest[0]).all():
            each = np.sqrt(((found[0] - finest[0]) ** 2).sum(-1).mean((0, 2)))
            error["mean"], error["median"] = float(each.mean()), float(np.median(each))
            error["p95"], error["rms"] = float(np.percentile(each, 95)), float(np.sqrt((each**2).mean()))
            error["elsewhere"] = float(np.mean([elsewhere(*pair) for pair in zip(found[1], finest[1], strict=True)]))
        if found[2] is not None:
            error["denser"] = max(found[2] - 1, 0.0)
        return error

    def run(self, knobs: Knobs) -> tuple[Found, float]:
        """A run and the seconds that its steps took. Raises `UsageError` for cells that do not fit."""
        scene = self._scene(knobs)
        groom = at_start(scene, arranged(emit(scene.emitter, scene.seed)))
        kind = solver_of(scene)
        try:
            warm_up(lambda: kind(scene, groom), 1 / (scene.time.fps * scene.time.substeps))
            solver: Any = kind(scene, groom)
            watch = Stopwatch(solver)
            points, cells, density = [], [], None
            metres = groom.emitted(groom.lengths) * (self.total / groom.strands)
            for frame in self.frames:
                solver.advance(frame)
                now = resample(solver.particles(), PLACES)
                points.append(now)
                cells.append(in_cells(now, metres, self.cell, *self._in_box(now)))
                found = solver.errors(frame).get("density_max")
                density = found if density is None else max(density, found)
        except UsageError as error:
            raise UsageError(f"{error}; the reference has half of the least of --cells") from None
        hairs = self.hairs.led_by(groom.strands, np.array(points))
        return (hairs, cells, density), watch.seconds

    def _in_box(self, points: NDArray[np.float64]) -> tuple[NDArray[np.float64], tuple[int, ...]]:
        """The box of cells that hair is counted in: that of the first frame, with a strand's length about it."""
        if self._box is None:
            away = float(self.hairs.lengths.max()) / 2
            low, high = points.min((0, 1)) - away, points.max((0, 1)) + away
            counts = np.ceil((high - low) / self.cell).astype(int) + 2
            self._box = self.cell * np.floor(low / self.cell), tuple(counts.tolist())
        return self._box


AXIS = Axis(
    name="interaction",
    doc="cells and guides of strands that interact, against finer ones",
    knobs=(CELL, GUIDES, COUNT),
    metric="mean",
    of_preset=True,
    open=Crowding,
)
