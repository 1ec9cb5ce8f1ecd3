"""Finds the rule that threw a strand off: runs the strand's history again alone, and its last step rule by rule.

A strand under the source's rules does not depend on the others, so its history alone is cheap: one block instead of
thousands. The step that spoils it is then taken as plain Python, and after every rule the particle is looked at.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..constants import W
from ..groom.emit import emit
from ..groom.record import Groom
from .rules import Moment, Pass, passes_of

SMALLER_STEPS = "use more time.substeps"
REMEDIES = {
    "gravity": "a smaller {path}.acceleration",
    "wind": "a smaller {path}.strength",
    "stiffness": "{path}.clamp: true",
    "collision": "elasticity after it",
    "elasticity": "no more of what pulls at it",
    "emitter_motion": "a slower motion of the emitter",
}
UNKNOWN = "{path} comes from elsewhere: what it adds has to shrink with the step"
MOST_STEPS = 20_000
"""Steps of history that are run again at the most; a failure after more is reported without its rule."""


def cause(solver: Any, frame: int, strand: int) -> tuple[str, str]:
    """What threw a strand off at a frame, and what may help, in words."""
    scene = solver.scene
    if scene.solver != "thesis":
        return f"the solver {scene.solver} lost it", f"{SMALLER_STEPS}, or rod.precision: double"
    path, name = guilty(solver, frame, strand)
    if not path:
        return f"under the rules {', '.join(use.name for use in scene.rules)}", f"{SMALLER_STEPS}, or weaker ones"
    own = name in REMEDIES
    remedy = (REMEDIES[name] if own else UNKNOWN).format(path=path)
    return f"thrown off by rule {path}", f"{SMALLER_STEPS}, or {remedy}" if own else f"{SMALLER_STEPS}; {remedy}"


def guilty(solver: Any, frame: int, strand: int) -> tuple[str, str]:
    """Path and name of the rule that spoils a strand first: that makes a coordinate not finite, or else moves it
    furthest in the step after which it is stretched most. ("", "") where that cannot be told."""
    scene = solver.scene
    time = scene.time
    before = round(time.preroll * time.fps * time.substeps)
    steps = before + (frame - 1) * time.substeps
    if not 0 < steps <= MOST_STEPS:
        return "", ""
    alone = type(solver)(scene, one_of(emit(scene.emitter, scene.seed, strand + 1), strand))
    dt = 1.0 / (time.fps * time.substeps)
    kept = None
    worst = 0.0
    for j in range(steps):
        past = np.array(alone.positions)
        at = (j + 1 - before) * dt
        alone.step(at, dt)
        stretch = _stretch(alone)
        if not np.isfinite(alone.positions).all():
            kept = past, at
            break
        if stretch > worst:
            worst, kept = stretch, (past, at)
    if kept is None:
        return "", ""
    with np.errstate(all="ignore"):
        return _slowly(kept[0][0], alone.rest[0], alone.lengths[0], passes_of(scene), Moment(kept[1], dt, scene))


def one_of(groom: Groom, strand: int) -> Groom:
    """A groom of one strand of another."""
    one = slice(strand, strand + 1)
    return replace(
        groom,
        roots=groom.roots[one],
        directions=groom.directions[one],
        lengths=groom.lengths[one],
        tones=groom.tones[one],
    )


def _stretch(solver: Any) -> float:
    x = solver.particles()[0].astype(np.float64)
    edges = np.linalg.norm(np.diff(x, axis=0), axis=1)
    return float(np.abs(edges / float(solver.lengths[0, 0]) - 1).max())


def _slowly(
    block: NDArray[np.float32], rest: NDArray[np.float32], length: NDArray[np.float32], passes: Any, moment: Moment
) -> tuple[str, str]:
    """One step of a block, rule by rule as `compose` fuses them, all in plain Python; lanes are alike, the first one is
    looked at."""
    rows = np.array(block)
    arrays = [one.prepare(moment) for _, one in passes]
    lane = [0, W, 2 * W]
    furthest, culprit = 0.0, ("", "")
    for (use, one), p in zip(passes, arrays, strict=True):
        if one.stage == "root":
            one.function(rows[0], rows[1], rest[0], rest[1], p)
            if not np.isfinite(rows[:2]).all():
                return use.path, use.name
    for i in range(1, len(rows) - 1):
        for (use, one), p in zip(passes, arrays, strict=True):
            if one.stage == "root":
                continue
            past = rows[i + 1, lane].astype(np.float64)
            try:
                _apply(one, rows, length, p, i)
            except (ValueError, ArithmeticError):  # what is NaN when compiled, such as the root of a negative number
                return use.path, use.name
            now = rows[i + 1, lane].astype(np.float64)
            if not np.isfinite(now).all():
                return use.path, use.name
            way = float(np.linalg.norm(now - past))
            if way > furthest:
                furthest, culprit = way, (use.path, use.name)
    return culprit


def _apply(one: Pass, rows: NDArray[np.float32], length: NDArray[np.float32], p: Any, i: int) -> None:
    """One pass on particle i."""
    if one.stage == "particle":
        one.function(rows[i + 1], rows[i], rows[i - 1], rows[1], length, p, i, len(rows) - 1)
        return
    a, b, c = (tuple(rows[row, [0, W, 2 * W]]) for row in (i + 1, i, i - 1))
    place = one.function(a, b, c, length[0], tuple((p[i] if one.per_particle else p)[: one.numbers]))
    for axis in range(3):
        rows[i + 1, axis * W : (axis + 1) * W] = place[axis]
