"""Errors of a frame of strands that act on each other, momentum that they lose or gain by that among them.

What strands hand to each other, by the grid of the rule interaction and by the rule contact, one gets and others lose.
So its sum over all strands, with what the emitter takes up at their roots, is nothing but rounding, unless a force is
wrong. It is measured where it acts: on the accelerations that the particles of rods are given. The wind that strands
take from those behind them is no momentum that others get, and is subtracted as cells have it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .kernels.measure import carried
from .rod.kernels.arrays import PACK

if TYPE_CHECKING:
    from .rod.solver import RodSolver


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
    the sizes of it and of the momentum that they have, both added up strand by strand: 0 where none has any."""
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
