"""Bounds of a frame's errors, beyond which a run stops, and the message: which rule makes a strand diverge.

The bounds are far above the errors of a good run, and far below overflow. Under the source's rules a strand does not
depend on others, so it is simulated again alone, which costs one block instead of thousands. The failing step runs as
plain Python, and the particle is examined after every rule.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..constants import W
from ..groom.emit import emit
from ..scene.specs import LARGEST
from .kernels.measure import carried
from .rod.kernels.arrays import PACK
from .rules import Moment, Pass, passes_of

if TYPE_CHECKING:
    from .rod.solver import RodSolver

STRETCH_MOST = {"thesis": 100.0, "rod": 0.01}
"""Greatest error of a segment's length, as a share. The source's strands are tested if a preset lists elasticity; rules
after it may still stretch them. A rod's lengths are exact except for rounding, which is subtracted."""
RESIDUAL_MOST = 1.0
"""Greatest error after a solver's iterations, as a share of a segment's length."""
ROUNDING = float(np.sqrt(3.0) * np.finfo(np.float32).eps)
"""Error of a distance between two points in single precision, for each metre of their coordinates."""


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
GIVEN = ("its positions were given", "simulate it again")
"""Cause and remedy for positions that were not simulated in this run."""


class Trouble(NamedTuple):
    """The first error of a frame beyond its bound."""

    message: str
    frame: int
    strand: int
    cause: str
    """The rule's path, or the constraint that is violated."""


def examine(solver: Any, frame: int, error: dict[str, Any], simulated: bool = True) -> Trouble | None:
    """Return the first error of a frame beyond its bound, or None; error: from `Solver.errors`. If the positions were
    given and not ``simulated``, no rule is named as the cause."""
    scene = solver.scene
    most = STRETCH_MOST[scene.solver]
    held = scene.solver != "thesis" or any(use.name == "elasticity" for use in scene.rules)
    residual = error.get("residual_max")
    stretch = stretches(solver) if held and not error["stretch_max"] <= most else np.zeros(1)
    known: tuple[str, str] | None = None
    if error["nonfinite"]:
        bad = ~np.isfinite(solver.particles()).all(-1)
        wrong = bad.any(1)
        strand = int(np.argmax(wrong))
        what = f", particle {int(np.argmax(bad[strand]))} is no longer finite"
    elif not stretch.max() <= most:
        wrong = ~(stretch <= most)
        strand = int(np.argmax(stretch))
        what = f" is stretched by {100 * stretch[strand]:.3g} %, more than {100 * most:g} %"
    elif simulated and residual is not None and not residual <= RESIDUAL_MOST:
        each = solver.strand_residuals()
        wrong = ~(each <= RESIDUAL_MOST)
        strand = int(np.argmax(np.where(np.isnan(each), np.inf, each)))
        what = f" is off by {residual:.3g} of a segment's length after {scene.rod.iterations} iterations"
        known = "the constraint of constant lengths is violated", f"{SMALLER_STEPS}, or a greater rod.iterations"
    else:
        return None
    cause, remedy = known or (cause_of(solver, frame, strand) if simulated else GIVEN)
    count = int(wrong.sum()) - 1
    others = f" (and {count} more strands)" if count > 0 else ""
    return Trouble(f"{_where(scene, frame)}strand {strand}{what}{others}: {cause}; {remedy}", frame, strand, cause)


def _where(scene: Any, frame: int) -> str:
    return f"{scene.label}: frame {frame}: " if scene.label else f"frame {frame}: "


def interpenetration(solver: Any, frame: int, error: dict[str, Any]) -> str:
    """Say that strands with contact are closer than half of their thickness, if they are."""
    depth = error.get("strand_penetration_max")
    if depth is None or depth <= solver.contact.thickness / 2:
        return ""
    where = _where(solver.scene, frame)
    if depth <= solver.contact.emitted:
        return (
            f"{where}strands that are emitted closer than contact.thickness, {solver.contact.thickness:.2g} m, are "
            f"still {depth:.2g} m too close, and are led apart; with a longer time.preroll that is over before "
            "frame 1, and with a smaller emitter.jitter or contact.thickness there are fewer"
        )
    return (
        f"{where}strands are {depth:.2g} m closer than contact.thickness, {solver.contact.thickness:.2g} m; "
        f"{SMALLER_STEPS}, or a greater contact.iterations, or a smaller contact.thickness"
    )


def crowding(solver: Any) -> str:
    """Say that strands that interact begin too dense for the density that their preset allows, if they do."""
    grid = getattr(solver, "grid", None)
    if grid is None or grid.given_density is None or not grid.density > grid.given_density:
        return ""
    return (
        f"{grid.where}: strands begin up to {grid.density / grid.given_density:.2g} times as dense as density "
        f"{grid.given_density:g} allows, and could not part; they may stay as dense as {grid.density:.2g}; spread "
        "their roots, or give that density"
    )


def errors_between_strands(solver: RodSolver) -> dict[str, float | None]:
    """Return the errors that a ``solver`` has by its rules. ``density_max``, where strands interact: the greatest
    density when the last step began, over the one allowed; ``strand_penetration_max``, with contact: by how much
    strands were closer than their thickness, or than their roots allow, at its end, metres; with either,
    `momentum_lost`."""
    out: dict[str, float | None] = {}
    grid, contact = solver.grid, solver.contact
    if grid is not None and grid.density is not None:
        out["density_max"] = grid.found / grid.density
    if contact is not None:
        out["strand_penetration_max"] = contact.penetration
    return out if grid is None and contact is None else {**out, "momentum_lost": momentum_lost(solver)}


def momentum_lost(solver: RodSolver) -> float:
    """Return the size of the sum of all that strands of a ``solver`` have handed to each other in the last frame, over
    the sizes of it and of the momentum that they have, both added up strand by strand: 0 where none has any.

    What strands hand to each other, by the rules interaction and contact, one gets and others lose. So its sum, with
    what the emitter takes up at their roots, is nothing but rounding, unless a force is wrong. It is measured where it
    acts: on the accelerations of particles. The wind that strands take from those behind them is no momentum that
    others get, and is subtracted as cells have it."""
    total, size = np.zeros(3), 0.0
    each, metres = 1.0, np.zeros((len(solver.state.edges), PACK))
    metres.reshape(-1)[: solver.strands] = solver.lengths.reshape(-1)[: solver.strands]
    if solver.grid is not None:
        each = solver.grid.stands_for
        total, size = solver.grid.momentum()
    if solver.contact is not None:
        total = total + each * solver.contact.handed[:3]
        size += each * float(solver.contact.handed[3])
    speeds = np.empty(metres.shape, solver.state.velocity.dtype)
    carried(solver.state.velocity, solver.mass, speeds)
    size += each * float((metres * speeds).sum())
    return float(np.linalg.norm(total)) / size if size > 0 else 0.0


def stretches(solver: Any) -> NDArray[np.float64]:
    """Return (strands,) the greatest error of a segment's length as a share of it, less the rounding of coordinates."""
    x = solver.particles().astype(np.float64)
    length = solver.rest_lengths()[:, None].astype(np.float64)
    with np.errstate(invalid="ignore", over="ignore"):
        off = np.abs(np.linalg.norm(np.diff(x, axis=1), axis=2) - length) - ROUNDING * np.abs(x).max((1, 2))[:, None]
        return np.asarray((off / length).max(1))


def drawable(solver: Any) -> NDArray[np.bool_]:
    """Return (strands,) whether strands can be drawn: finite, and so small that squares do not overflow in single
    precision."""
    particles = solver.particles()
    with np.errstate(invalid="ignore"):
        return np.asarray((np.abs(particles) <= LARGEST).all((1, 2)))


def cause_of(solver: Any, frame: int, strand: int) -> tuple[str, str]:
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
    alone = type(solver)(scene, emit(scene.emitter, scene.seed, strand + 1).of([strand]))
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


def _stretch(solver: Any) -> float:
    x = solver.particles()[0].astype(np.float64)
    edges = np.linalg.norm(np.diff(x, axis=0), axis=1)
    return float(np.abs(edges / float(solver.lengths[0, 0]) - 1).max())


def _rule_by_rule(
    block: NDArray[np.float32], rest: NDArray[np.float32], length: NDArray[np.float32], passes: Any, moment: Moment
) -> tuple[str, str]:
    """Run one step of a block rule by rule, in the order of a composed step, as plain Python; return path and name of
    the rule as `diverging_rule`. All lanes are equal; the first one is examined."""
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
