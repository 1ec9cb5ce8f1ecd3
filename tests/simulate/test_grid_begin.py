"""Strands that interact and begin inside each other."""

from __future__ import annotations

import numba
import numpy as np
import pytest
from numpy.typing import NDArray

from strand_kit import require_same_after_restart, scene_of
from strandcli.groom.emit import emit
from strandcli.groom.record import Groom
from strandcli.simulate.grid.overlap import REACH, offsets_of
from strandcli.simulate.rod.kernels.arrays import PACK
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


def widths(solver: RodSolver) -> NDArray[np.float64]:
    """Standard deviations of tips across, in cells."""
    found: NDArray[np.float64] = np.std(solver.particles()[:, -1, [0, 2]].astype(float), axis=0) / CELL
    return found


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
def test_strands_that_begin_inside_each_other_are_led_apart_without_a_jump(curled: str, steps: int) -> None:
    """In no frame any moves by .6 of a cell, however many steps it has, and then they come to rest; were all pressed
    apart at once, by three and a half (six and a half straight ones). Tips of straight strands fill the same room then,
    however many steps there were, those of coils up to a quarter more in steps of a frame; and roots are as dense as
    they were."""
    solver = bundle(24 * steps, curled)
    assert max(moves(solver, steps, 96)) < 0.6
    before = solver.particles()
    assert max(moves(solver, steps, 12)) < 0.35
    assert np.median(np.linalg.norm(solver.particles() - before, axis=2)[:, -1]) < 0.15 * CELL
    wanted = 2.4 if not curled else 1.85 if steps > 1 else 1.25 * 1.85
    assert widths(solver) == pytest.approx(wanted, rel=0.1)
    assert solver.grid is not None
    assert solver.grid.found > 10 * 1e4, "they cannot part at their roots"


def test_strands_that_coincide_part_in_all_directions_to_the_same_bits() -> None:
    """Each in a direction of its own, which no number of threads changes; a grid tells them not apart."""
    found: list[NDArray[np.float32]] = []
    threads = numba.get_num_threads()
    for count in (1, threads):
        numba.set_num_threads(count)
        solver = bundle(24, groom=alike())
        assert max(moves(solver, 1, 48)) < 1.2
        found.append(solver.particles())
    np.testing.assert_array_equal(*found)
    tips = found[0][:, -1, [0, 2]]
    assert np.std(tips, axis=0).min() > 0.01
    assert (np.abs(tips.mean(0)) < np.std(tips, axis=0) / 2).all()


def test_what_strands_hand_to_each_other_while_they_part_stays() -> None:
    solver = bundle(24)
    for frame in range(2, 16):
        solver.advance(frame)
        assert solver.errors(frame)["momentum_lost"] < 1e-5


@pytest.mark.parametrize("steps", [1, 10])
def test_thousands_in_one_line_are_led_apart_without_a_jump(steps: int) -> None:
    """A thousand times too dense; were all pressed apart within a second, by seven cells, and they would boil."""
    solver = bundle(24 * steps, groom=alike(3000), density=7500)
    assert max(moves(solver, steps, 96)) < 1
    assert widths(solver).min() > 5


def test_a_later_run_goes_on_from_a_checkpoint_while_strands_part() -> None:
    whole, half = bundle(24), bundle(24)
    require_same_after_restart(whole, half)
    assert half.grid is not None
    assert half.grid.overlap.roots is not None
    state = whole.state_arrays()
    with pytest.raises(ValueError, match="overlap"):
        half.check({**state, "free overlap": state["free overlap"][1:]}, 20)


def test_strands_that_are_hardly_too_dense_are_pressed_apart_at_once() -> None:
    """As those that have no density given, and those that a tie holds."""
    for rule in ("interaction", "interaction: {density: 1.0e+4, cell: 0.02}"):
        solver = solver_of(f"emitter: {{{BALL}, strands: 300}}\nrules: [{rule}]")
        assert solver.grid is not None
        solver.advance(2)
        assert solver.grid.overlap.started
        assert solver.grid.overlap.roots is None


def test_strands_are_beside_themselves_evenly() -> None:
    """Of 8 parts of a cell each has an eighth of them."""
    found = offsets_of(64).reshape(64, 3, PACK).transpose(0, 2, 1).reshape(-1, 3)
    assert np.abs(found).max() <= REACH
    assert np.abs(np.bincount((found > 0) @ [1, 2, 4], minlength=8) / len(found) - 1 / 8).max() < 0.02
