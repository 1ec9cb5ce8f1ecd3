"""Bytes that `plan` counts for the grid of strands that interact."""

from __future__ import annotations

import pytest

from strandcli.groom.blocks import arranged
from strandcli.groom.emit import emit
from strandcli.plan.grid import grid_bytes
from strandcli.simulate.rod.solver import RodSolver
from tests.simulate.test_grid import BALL, solver_of

TEXT = f"emitter: {{{BALL}, strands: 900}}\nrules: [gravity, interaction: {{density: 3000, cell: %s}}]"


def test_fine_cells_are_counted_as_the_solver_takes_them() -> None:
    """All but what arrays have in reserve, a fifth; parts of a ball reach other shares of its box
    than those of a head, by which bytes a cell were measured."""
    scene = solver_of(TEXT % 0.005).scene
    solver = RodSolver(scene, arranged(emit(scene.emitter, scene.seed)))  # as runs have them
    assert solver.grid is not None
    solver.advance(2)
    taken = (solver.grid._cells.nbytes + solver.grid.memory.nbytes) / 1.2
    assert grid_bytes(solver.scene, 900) == pytest.approx(taken, rel=0.25)


def test_usual_cells_and_scenes_without_the_rule_are_not_counted() -> None:
    assert grid_bytes(solver_of(TEXT % 0.05).scene, 900) == 0
    assert grid_bytes(solver_of(f"emitter: {{{BALL}, strands: 900}}\nrules: [gravity]").scene, 900) == 0
