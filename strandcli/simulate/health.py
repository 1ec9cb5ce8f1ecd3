"""Bounds of a frame's errors, beyond which a run stops, and the message.

The bounds are far above the errors of a good run, and far below overflow.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..scene.specs import LARGEST
from . import blame

STRETCH_MOST = {"thesis": 100.0, "rod": 0.01}
"""Greatest error of a segment's length, as a share. The source's strands are tested if a preset lists elasticity; rules
after it may still stretch them. A rod's lengths are exact except for rounding, which is subtracted."""
RESIDUAL_MOST = 1.0
"""Greatest error after a solver's iterations, as a share of a segment's length."""
ROUNDING = float(np.sqrt(3.0) * np.finfo(np.float32).eps)
"""Error of a distance between two points in single precision, for each metre of their coordinates."""


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
    where = f"{scene.label}: frame {frame}" if scene.label else f"frame {frame}"
    if error["nonfinite"]:
        particles = solver.particles()
        bad = ~np.isfinite(particles).all(-1)
        strand = int(np.argmax(bad.any(1)))
        particle = int(np.argmax(bad[strand]))
        cause, remedy = blame.cause(solver, frame, strand) if simulated else GIVEN
        others = _others(int(bad.any(1).sum()))
        return Trouble(
            f"{where}: strand {strand}, particle {particle} is no longer finite{others}: {cause}; {remedy}",
            frame, strand, cause,
        )  # fmt: skip
    most = STRETCH_MOST[scene.solver]
    held = scene.solver != "thesis" or any(use.name == "elasticity" for use in scene.rules)
    if held and not error["stretch_max"] <= most:
        stretch = stretches(solver)
        strand = int(np.argmax(stretch))
        if not stretch[strand] <= most:
            cause, remedy = blame.cause(solver, frame, strand) if simulated else GIVEN
            return Trouble(
                f"{where}: strand {strand} is stretched by {100 * stretch[strand]:.3g} %, more than {100 * most:g} %"
                f"{_others(int((~(stretch <= most)).sum()))}: {cause}; {remedy}",
                frame, strand, cause,
            )  # fmt: skip
    residual = error.get("residual_max")
    if simulated and residual is not None and not residual <= RESIDUAL_MOST:
        each = solver.strand_residuals()
        strand = int(np.argmax(np.where(np.isnan(each), np.inf, each)))
        cause = "the constraint of constant lengths is violated"
        return Trouble(
            f"{where}: strand {strand} is off by {residual:.3g} of a segment's length after {scene.rod.iterations} "
            f"iterations{_others(int((~(each <= RESIDUAL_MOST)).sum()))}: {cause}; {blame.SMALLER_STEPS}, or a greater "
            "rod.iterations",
            frame, strand, cause,
        )  # fmt: skip
    return None


def interpenetration(solver: Any, frame: int, error: dict[str, Any]) -> str:
    """Say that strands with contact are closer than half of their thickness, if they are."""
    depth = error.get("strand_penetration_max")
    if depth is None or depth <= solver.contact.thickness / 2:
        return ""
    scene = solver.scene
    where = f"{scene.label}: frame {frame}" if scene.label else f"frame {frame}"
    if depth <= solver.contact.emitted:
        return (
            f"{where}: strands that are emitted closer than contact.thickness, {solver.contact.thickness:.2g} m, are "
            f"still {depth:.2g} m too close, and are led apart; with a longer time.preroll that is over before "
            "frame 1, and with a smaller emitter.jitter or contact.thickness there are fewer"
        )
    return (
        f"{where}: strands are {depth:.2g} m closer than contact.thickness, {solver.contact.thickness:.2g} m; "
        f"{blame.SMALLER_STEPS}, or a greater contact.iterations, or a smaller contact.thickness"
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


def _others(count: int) -> str:
    return f" (and {count - 1} more strands)" if count > 1 else ""
