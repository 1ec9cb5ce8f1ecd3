"""Simulation of strands: two solvers, the source's rules, contact, and the errors of a frame."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ..scene.model import Scene
    from .solver import Solver


def solver_of(scene: Scene) -> type[Solver]:
    """Return the class of a scene's solver; import no other."""
    if scene.emitter.groom is not None and scene.emitter.followers is None:
        from .still import StillSolver

        return StillSolver
    if scene.solver == "rod":
        from .rod.solver import RodSolver

        return RodSolver
    from .thesis.solver import ThesisSolver

    return ThesisSolver
