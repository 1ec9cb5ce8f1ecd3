"""A run of strands that interact, and how far it is from another one.

What is seen of hair is where it is, not which strand is where: `elsewhere` is the share of all hair that is in another
cell of the preset's own size, which knows nothing of single strands. Beside it stand hairs at common roots, shares of
their length: `mean`, `median`, `p95` and `rms` of their root mean squares. The mean is of hairs that are guides and of
those that are not; the median would be that of the one or the other.

What a run has of itself, without another one: `too_dense`, the share of all hair that is beyond the density that the
rule allows, in cells of the preset's own size whatever those of the run; and the greatest of its frames, by how much
the densest cell of its own is denser than allowed (`denser`), depth in solids over the strands' length
(`penetration`), and momentum lost (`momentum`).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...errors import UsageError
from ...groom.arrange import arranged
from ...groom.deforming import at_start
from ...groom.emit import emit
from ...scene.model import Scene
from ...simulate import solver_of
from .contestants import warm_up
from .experiment import PLACES
from .hairs import Hairs, elsewhere, in_cells
from .resample import resample
from .watch import Stopwatch

Array = NDArray[np.float64]
FRAMES = {"denser": "density_max", "penetration": "penetration_max", "momentum": "momentum_lost"}
"""Errors of a run by the names that those of its frames have."""
NAMES = ("elsewhere", "mean", "too_dense", "denser", "penetration", "momentum", "p95", "median", "rms")
"""All of them, those first that a table has room for."""


class Found(NamedTuple):
    """Of a run."""

    hairs: Array
    """As `Hairs.led_by` returns them."""
    cells: list[Array]
    """In each frame, metres in cells."""
    own: dict[str, float | None]
    """Errors that need no other run; None of what it does not have."""


class Ruler:
    """Cells that all runs are measured in: their side, how much of the hair they may hold, and where they are."""

    def __init__(self, cell: float, density: float | None, total: int, away: float) -> None:
        """``density``: strands a square metre that are allowed, None where nothing is; ``total``: strands that the
        guides stand for; ``away``: metres that strands may go beyond where they are in the first frame."""
        self.cell, self.total, self._away = cell, total, away
        self._full = None if density is None else density * cell**3
        self._box: tuple[Array, tuple[int, ...]] | None = None

    def metres(self, points: Array, each: Array) -> Array:
        """Return the metres of strands in the cells. ``each`` (strands,): what each counts for. The box is that of the
        first strands that are measured."""
        if self._box is None:
            low, high = points.min((0, 1)) - self._away, points.max((0, 1)) + self._away
            counts = np.ceil((high - low) / self.cell).astype(int) + 2
            self._box = self.cell * np.floor(low / self.cell), tuple(counts.tolist())
        return in_cells(points, each, self.cell, *self._box)

    def too_dense(self, cells: Sequence[Array]) -> float | None:
        """Return the share of the hair that is more than cells may hold, the mean of all frames."""
        if self._full is None:
            return None
        return float(np.mean([np.maximum(one - self._full, 0).sum() / one.sum() for one in cells]))


def run(scene: Scene, frames: Sequence[int], ruler: Ruler, hairs: Hairs) -> tuple[Found, float]:
    """Return a run and the seconds that its steps took. Raises `UsageError` for cells that do not fit."""
    groom = at_start(scene, arranged(emit(scene.emitter, scene.seed)))
    kind = solver_of(scene)
    worst: dict[str, float] = {}
    try:
        warm_up(lambda: kind(scene, groom), 1 / (scene.time.fps * scene.time.substeps))
        solver: Any = kind(scene, groom)
        watch = Stopwatch(solver)
        points, cells = [], []
        metres = groom.emitted(groom.lengths) * (ruler.total / groom.strands)
        for frame in frames:
            solver.advance(frame)
            points.append(resample(solver.particles(), PLACES))
            cells.append(ruler.metres(points[-1], metres))
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
    own["too_dense"] = ruler.too_dense(cells)
    return Found(hairs.led_by(groom.strands, np.array(points)), cells, own), watch.seconds


def errors_of(found: Found, finest: Found) -> dict[str, float | None]:
    """Return the errors of a run against the finest one."""
    error: dict[str, float | None] = {**dict.fromkeys(NAMES), **found.own}
    if np.isfinite(found.hairs).all() and np.isfinite(finest.hairs).all():
        each = np.sqrt(((found.hairs - finest.hairs) ** 2).sum(-1).mean((0, 2)))
        error["mean"], error["median"] = float(each.mean()), float(np.median(each))
        error["p95"], error["rms"] = float(np.percentile(each, 95)), float(np.sqrt((each**2).mean()))
        error["elsewhere"] = float(np.mean([elsewhere(*pair) for pair in zip(found.cells, finest.cells, strict=True)]))
    return error
