"""Strands that interact and begin inside each other."""

from __future__ import annotations

import numpy as np
import pytest

from strand_kit import require_same_after_restart, scene_of
from strandcli.groom.emit import emit
from strandcli.groom.record import Groom
from strandcli.simulate.health import crowding
from strandcli.simulate.rod.solver import RodSolver
from tests.simulate.test_grid import BALL, solver_of

CELL = 0.02
CURLED = ", curl_turns: 6, curl_angle: 50"


def bundle(fps: int, curled: str = "", groom: Groom | None = None, density: float = 1e4) -> RodSolver:
    """300 strands, or as many as a groom has, from a disc of a tenth of a cell, twenty or thirty times too dense."""
    rest = "rest: shape, " if curled else "rest: straight, "
    scene = scene_of(
        f"solver: rod\nrod: {{{rest}radius: 1.0e-4, drag: 5}}\ntime: {{fps: {fps}}}\n"
        "emitter: {shape: {kind: disc, radius: 0.001}, "
        f"strands: {groom.strands if groom else 300}, particles: 12, length: 0.2, jitter: 2, "
        f"rotation: [180, 0, 0]{curled}}}\n"
        f"rules: [gravity, interaction: {{cell: {CELL}, density: {density}}}]"
    )
    return RodSolver(scene, groom or emit(scene.emitter, scene.seed))


def alike(count: int = 300) -> Groom:
    """Strands that are all in the very same place."""
    down = np.tile(np.array([0, -1, 0], np.float32), (count, 1))
    return Groom(np.zeros_like(down), down, np.full(count, 0.2, np.float32), np.zeros(count, np.float32))


def moves(solver: RodSolver, steps: int, frames: int) -> list[float]:
    """The greatest way of a particle in each 24th of a second, in cells."""
    found, before = [], solver.particles()
    for frame in range(frames):
        for step in range(steps):
            solver.step((frame * steps + step + 1) / (24 * steps), 1 / (24 * steps))
        after = solver.particles()
        found.append(float(np.linalg.norm(after - before, axis=2).max()) / CELL)
        before = after
    return found


@pytest.mark.parametrize("steps", [1, 10])
@pytest.mark.parametrize("curled", ["", CURLED])
def test_strands_that_begin_inside_each_other_part_without_a_jump_and_rest(curled: str, steps: int) -> None:
    """In no frame any moves by .6 of a cell, however many steps it has, and then they come to rest: the density that
    they are allowed is as much greater as they begin too dense."""
    solver = bundle(24 * steps, curled)
    assert max(moves(solver, steps, 96)) < 0.6
    before = solver.particles()
    assert max(moves(solver, steps, 12)) < 0.35
    assert np.median(np.linalg.norm(solver.particles() - before, axis=2)[:, -1]) < 0.15 * CELL
    assert solver.grid is not None
    assert "times as dense as density 10000 allows" in crowding(solver)


@pytest.mark.parametrize("steps", [1, 10])
def test_thousands_in_one_line_stay_finite_and_are_told(steps: int) -> None:
    solver = bundle(24 * steps, groom=alike(3000), density=7500)
    assert max(moves(solver, steps, 24)) < 1
    assert "spread their roots" in crowding(solver)


def test_a_later_run_goes_on_from_a_checkpoint_of_strands_that_began_too_dense() -> None:
    whole, half = bundle(24), bundle(24)
    require_same_after_restart(whole, half)
    assert half.grid is not None
    assert whole.grid is not None
    assert half.grid.density == whole.grid.density


def test_strands_that_are_hardly_too_dense_are_pressed_apart_at_once() -> None:
    """As those that have no density given, and those that a tie holds."""
    for rule in ("interaction", "interaction: {density: 1.0e+4, cell: 0.02}"):
        solver = solver_of(f"emitter: {{{BALL}, strands: 300}}\nrules: [{rule}]")
        solver.advance(2)
        assert crowding(solver) == ""
