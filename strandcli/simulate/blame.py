"""Search for the rule that makes a strand diverge: the strand is simulated again alone, and its last step rule by rule.

Under the source's rules a strand does not depend on others, so this costs one block instead of thousands. The failing
step runs as plain Python, and the particle is examined after every rule.
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
UNKNOWN = "{path} is another package's rule: the displacement that it adds must shrink with the step"
MOST_STEPS = 20_000
"""Greatest number of steps to simulate again; a failure after more is reported without its rule."""


def cause(solver: Any, frame: int, strand: int) -> tuple[str, str]:
    """Return the cause of a strand's divergence at a frame and a remedy, as texts."""
    scene = solver.scene
    if scene.solver != "thesis":
        return f"the solver {scene.solver} diverged", SMALLER_STEPS
    path, name = diverging_rule(solver, frame, strand)
    if not path:
        return f"under the rules {', '.join(use.name for use in scene.rules)}", f"{SMALLER_STEPS}, or weaker ones"
    own = name in REMEDIES
    remedy = (REMEDIES[name] if own else UNKNOWN).format(path=path)
    return f"rule {path} makes it diverge", f"{SMALLER_STEPS}, or {remedy}" if own else f"{SMALLER_STEPS}; {remedy}"


def diverging_rule(solver: Any, frame: int, strand: int) -> tuple[str, str]:
    """Return path and name of the first rule that makes a coordinate not finite, or else of the one that moves the
    strand farthest in the step after which it is stretched most; ("", "") if it cannot be determined."""
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
        return _rule_by_rule(kept[0][0], alone.rest[0], alone.lengths[0], passes_of(scene), Moment(kept[1], dt, scene))


def one_of(groom: Groom, strand: int) -> Groom:
    """Return a groom of one strand of another groom."""
    one = slice(strand, strand + 1)
    return replace(
        groom,
        roots=groom.roots[one],
        directions=groom.directions[one],
        lengths=groom.lengths[one],
        tones=groom.tones[one],
        bend=None if groom.bend is None else groom.bend._replace(inward=groom.bend.inward[one]),
        phases=None if groom.phases is None else groom.phases[one],
    )


def _stretch(solver: Any) -> float:
    x = solver.particles()[0].astype(np.float64)
    edges = np.linalg.norm(np.diff(x, axis=0), axis=1)
    return float(np.abs(edges / float(solver.lengths[0, 0]) - 1).max())


def _rule_by_rule(
    block: NDArray[np.float32], rest: NDArray[np.float32], length: NDArray[np.float32], passes: Any, moment: Moment
) -> tuple[str, str]:
    """Run one step of a block rule by rule, in the order of `compose`, as plain Python; return path and name of the
    rule as `diverging_rule`. All lanes are equal; the first one is examined."""
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
            except (ValueError, ArithmeticError):  # NaN in compiled code, such as the square root of a negative number
                return use.path, use.name
            now = rows[i + 1, lane].astype(np.float64)
            if not np.isfinite(now).all():
                return use.path, use.name
            way = float(np.linalg.norm(now - past))
            if way > furthest:
                furthest, culprit = way, (use.path, use.name)
    return culprit


def _apply(one: Pass, rows: NDArray[np.float32], length: NDArray[np.float32], p: Any, i: int) -> None:
    """Run one pass on particle i."""
    if one.stage == "particle":
        one.function(rows[i + 1], rows[i], rows[i - 1], rows[1], length, p, i, len(rows) - 1)
        return
    a, b, c = (tuple(rows[row, [0, W, 2 * W]]) for row in (i + 1, i, i - 1))
    place = one.function(a, b, c, length[0], tuple((p[i] if one.per_particle else p)[: one.numbers]))
    for axis in range(3):
        rows[i + 1, axis * W : (axis + 1) * W] = place[axis]
