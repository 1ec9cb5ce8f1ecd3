"""Strands that those around push otherwise than before: they take that step by Euler's method, and come to rest."""

from __future__ import annotations

import numpy as np

from strandcli.simulate.grid.kernels.nodes import CHANGE, SLIGHT
from tests.simulate.test_grid import BALL, rows, solver_of

FPS = 30
BY_EULER = 0.121
"""Root mean square by which edges of `BRUSH` turn from frame 12 to 31, in a frame, where Euler's method makes every
step: as measured with a solver all of whose steps were that method's. BDF2 with it where pushes change gives .158."""
BRUSH = """
time: {fps: 30}
emitter: {shape: {kind: sphere, radius: 1}, strands: 1000, particles: 15, length: 0.9, jitter: 4}
solids: [{kind: sphere, radius: 1}]
rules: [gravity, collision, interaction: {}]
"""


def test_they_are_those_whose_push_changes_much() -> None:
    """A twin in NumPy, of strands whose particles are the grid's nodes."""
    solver = solver_of(
        f"time: {{fps: {FPS}}}\nemitter: {{{BALL}, strands: 400}}\n"
        "rules: [gravity, interaction: {cell: 0.03, density: 4000}]"
    )
    assert solver.grid is not None
    pushed, shares = solver.grid.strands.pushed, []
    for frame in range(2, 12):
        past, v = rows(pushed, 400), rows(solver.state.velocity, 400)
        solver.advance(frame)
        changed = ((rows(pushed, 400) - past) ** 2).sum((1, 2))
        speed = ((v - v[:, -1:]) ** 2).sum((1, 2))
        margins = changed / (CHANGE**2 * (past**2).sum((1, 2)) + 1e-30), changed / (FPS * SLIGHT) ** 2 / (speed + 1e-30)
        least = np.minimum(*margins)
        marked = solver.state.jolted.reshape(-1)[:400] > 0
        clear = np.abs(least - 1) > 1e-3
        np.testing.assert_array_equal(marked[clear], (least > 1)[clear], f"frame {frame}")
        shares.append(marked.mean())
    assert 0.05 < np.mean(shares) < 0.95


def test_a_brush_that_falls_does_not_boil() -> None:
    """Of strands that the grid pushes now here and now there, edges turn from frame to frame by hardly more than with
    Euler's method alone, `BY_EULER`; BDF2 alone would go on with every push, and turn them by twice as much."""
    solver, found = solver_of(BRUSH), []
    for frame in range(2, 32):
        before = rows(solver.state.edges, 1000)
        solver.advance(frame)
        if frame > 12:
            found.append(np.sqrt(((rows(solver.state.edges, 1000) - before) ** 2).sum(2).mean()))
    assert np.mean(found) < 1.4 * BY_EULER
