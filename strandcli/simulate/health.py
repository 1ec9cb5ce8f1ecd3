"""Bounds of a frame's errors, beyond which a run stops, and the messages. The bounds are far above the errors of a good
run, and far below overflow."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..scene.specs import LARGEST

if TYPE_CHECKING:
    from .rod.solver import RodSolver

STRETCH_MOST = {"thesis": 100.0, "rod": 0.01}
"""Greatest error of a segment's length, as a share; of the source's strands where elasticity is listed."""
RESIDUAL_MOST = 1.0
"""Greatest error after a solver's iterations, as a share of a segment's length."""
ROUNDING = float(np.sqrt(3.0) * np.finfo(np.float32).eps)
"""Error of a distance between two points in single precision, for each metre of their coordinates."""


SMALLER_STEPS = "use more time.substeps"
GIVEN = ("its positions were given", "simulate it again")
"""Cause and remedy for positions that were not simulated in this run."""


class Trouble(NamedTuple):
    """The first error of a frame beyond its bound."""

    message: str
    frame: int
    strand: int
    cause: str
    """The rules' paths, or the constraint that is violated."""


def examine(solver: Any, frame: int, error: dict[str, Any], simulated: bool = True) -> Trouble | None:
    """Return the first error of a frame beyond its bound, or None; error: from `Solver.errors`. If the positions were
    given and not ``simulated``, no rules are named as the cause."""
    scene = solver.scene
    most = STRETCH_MOST[scene.solver]
    inextensible = scene.solver != "thesis" or any(use.name == "elasticity" for use in scene.rules)
    residual = error.get("residual_max")
    stretch = stretches(solver) if inextensible and not error["stretch_max"] <= most else np.zeros(1)
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
    cause, remedy = known or (cause_of(solver) if simulated else GIVEN)
    count = int(wrong.sum()) - 1
    more = f" (and {count} more strands)" if count > 0 else ""
    return Trouble(f"{_where(scene, frame)}strand {strand}{what}{more}: {cause}; {remedy}", frame, strand, cause)


def _where(scene: Any, frame: int) -> str:
    return f"{scene.label}: frame {frame}: " if scene.label else f"frame {frame}: "


def interpenetration(solver: Any, frame: int, error: dict[str, Any]) -> str:
    """Say that strands with contact are closer than half of their thickness, if they are."""
    depth = error.get("strand_penetration_max")
    if depth is None or depth <= solver.contact.thickness / 2:
        return ""
    return (
        f"{_where(solver.scene, frame)}strands are {depth:.2g} m closer than contact.thickness, "
        f"{solver.contact.thickness:.2g} m; where they are emitted so, a longer time.preroll leads them apart, else "
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
    strands were closer than their thickness, or than their roots allow, at its end, metres."""
    out: dict[str, float | None] = {}
    if solver.grid is not None and solver.grid.density is not None:
        out["density_max"] = solver.grid.found / solver.grid.density
    if solver.contact is not None:
        out["strand_penetration_max"] = solver.contact.penetration
    return out


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


def cause_of(solver: Any) -> tuple[str, str]:
    """Return the cause of a strand's divergence and a remedy, as texts."""
    scene = solver.scene
    if scene.solver != "thesis":
        return f"the solver {scene.solver} diverged", SMALLER_STEPS
    free = [use.path for use in scene.rules if use.name == "stiffness" and not use.parameters.clamp]
    milder = f"{free[0]}.clamp: true" if free else "weaker rules"
    return f"under the rules {', '.join(use.path for use in scene.rules)}", f"{SMALLER_STEPS}, or {milder}"
