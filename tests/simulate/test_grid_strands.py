"""Strands that interact: they part where they begin inside each other, come to rest, shelter each other from wind."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numba import njit

from mesh_kit import mesh, obj
from rod_kit import rod_of
from strand_kit import require_same_after_restart, scene_of
from strandcli.errors import UsageError
from strandcli.groom.emit import emit
from strandcli.groom.record import Groom
from strandcli.simulate.advice import depth
from strandcli.simulate.grid import strand_grid
from strandcli.simulate.grid.kernels import forces, records
from strandcli.simulate.grid.kernels.records import (
    LOW,
    SIZE,
)
from strandcli.simulate.health import crowding
from strandcli.simulate.rod.solver import RodSolver
from strandcli.study.stress import run as stress
from tests.simulate.test_grid import BALL, prepare, rows

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


@pytest.mark.parametrize(("curled", "steps"), [("", 1), (CURLED, 10)])
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


@pytest.mark.parametrize("steps", [1, pytest.param(10, marks=pytest.mark.long)])
def test_thousands_in_one_line_stay_finite_and_are_told(steps: int) -> None:
    solver = bundle(24 * steps, groom=alike(3000), density=7500)
    assert max(moves(solver, steps, 24)) < 1
    assert "spread their roots" in crowding(solver)


def test_a_later_run_goes_on_from_a_checkpoint_of_strands_that_began_too_dense() -> None:
    whole, half = bundle(24), bundle(24)
    require_same_after_restart(whole, half)
    assert half.grid.density == whole.grid.density


def test_strands_that_are_hardly_too_dense_are_pressed_apart_at_once() -> None:
    """As those that have no density given, and those that a tie holds."""
    for rule in ("interaction", "interaction: {density: 1.0e+4, cell: 0.02}"):
        solver = rod_of(f"emitter: {{{BALL}, strands: 300}}\nrules: [{rule}]")
        solver.advance(2)
        assert crowding(solver) == ""


@pytest.mark.parametrize(
    ("shape", "cell"), [("{kind: sphere, radius: 0.1}", 1e-3), ("{kind: disc, radius: 2000}", 0.05)]
)
def test_cells_as_large_as_is_said_are_few_enough(shape: str, cell: float) -> None:
    """And not twice as large as they have to be, where the groom is as flat as a sheet, too."""

    def begin(cell: float) -> None:
        rod_of(
            f"emitter: {{shape: {shape}, strands: 64, particles: 5, length: 0.2}}\n"
            f"rules: [interaction: {{cell: {cell}}}]"
        ).advance(2)

    with pytest.raises(UsageError, match="make them at least") as raised:
        begin(cell)
    enough = float(str(raised.value).rsplit(" ", 1)[1])
    begin(enough)
    with pytest.raises(UsageError, match="make them at least"):
        begin(enough / 2)


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


def test_a_brush_that_falls_does_not_boil() -> None:
    """Of strands that the grid pushes now here and now there, edges turn from frame to frame by hardly more than with
    Euler's method alone, `BY_EULER`; BDF2 alone would go on with every push, and turn them by twice as much."""
    solver, found = rod_of(BRUSH), []
    for frame in range(2, 32):
        before = rows(solver.state.edges, 1000)
        solver.advance(frame)
        if frame > 12:
            found.append(np.sqrt(((rows(solver.state.edges, 1000) - before) ** 2).sum(2).mean()))
    assert np.mean(found) < 1.4 * BY_EULER


@pytest.mark.parametrize("way", [(1.0, 0.0, 0.0), (0.0, 0.0, -1.0), (0.6, -0.8, 0.0)])
def test_wind_fades_exponentially_in_an_even_layer(way: tuple[float, float, float]) -> None:
    """exp(−n d s) after a way s, from where it has entered."""
    side, stop = 32, 0.05
    box, numbers = np.array([0, 0, 0, side, side, side, 0]), np.zeros(records.NUMBERS, np.float32)
    numbers[records.WIND : records.WIND + 3], numbers[records.STOP] = way, stop
    left, behind = np.empty((2, side**3), np.float32)
    sweep = njit(lambda *given: forces.shelter(*given))
    sweep(box, np.ones(side**3, np.float32), numbers, left, behind)
    cells, at = left.reshape(side, side, side), np.arange(side)  # z, y, x
    if way[2] < 0:
        assert cells[side - 1 - 10, 3, 4] == pytest.approx(np.exp(-stop * 10), rel=1e-3)
    elif way[1] == 0:
        np.testing.assert_allclose(cells[12, 12], np.exp(-stop * at), rtol=1e-3)
    else:  # enters through the top where that is nearer, and first-order differences blur where both meet
        ways = np.minimum(at / 0.6, (side - 1 - 12) / 0.8)
        np.testing.assert_allclose(cells[12, 12], np.exp(-stop * ways), rtol=0.15)


def test_a_strand_in_the_lee_bends_less() -> None:
    """Of a row of tufts along the wind the first takes the most of it, once they have come to rest."""
    text = (
        "rod: {rest: straight, drag: 5}\nemitter: {shape: {kind: plane, width: 0.4, depth: 0.02}, strands: 900, "
        "particles: 7, length: 0.15}\nchildren: {count: 100}\n"
        "rules: [gravity, wind: {strength: 2}%s]"
    )
    bent = {}
    for rule in ("", ", interaction: {friction: 0, cell: 0.02, density: 1.0e+9}"):
        solver = rod_of(text % rule)
        solver.advance(72)
        x = solver.particles()
        lean = x[:, -1, 0] - x[:, 0, 0]
        bent[rule] = (lean[x[:, 0, 0] < -0.19].mean(), lean[x[:, 0, 0] > 0.1].mean())
    (first, last), (fresh, lee) = bent.values()
    assert last == pytest.approx(first, rel=0.05)
    assert fresh > 0.7 * first
    assert lee < 0.6 * last


@pytest.mark.long  # in double precision, which nothing else asks the grid's kernels for
def test_what_is_too_heavy_to_follow_is_not_pushed_without_end() -> None:
    """Tips a million times as heavy in steps of ten seconds: pushes grew a hundred thousandfold each, to infinity."""
    name = "rod/dt=10/n=3/L=1e6/tip=1e6/start=folded/between=grid-fine/twist=sag-free"
    (verdict,) = stress.perform(stress.named(name))
    assert verdict.verdict == "pass", verdict.why


def test_room_is_what_a_mesh_leaves_of_cells_and_is_kept_while_it_stands_still(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Against distances of one point after the other; where strands are, and nowhere else."""
    (tmp_path / "ball.obj").write_bytes(obj(mesh("ball")))
    solver = rod_of(
        f"emitter: {{{BALL}, strands: 40}}\nsolids: [{{kind: mesh, file: {tmp_path / 'ball.obj'}, scale: 0.1}}]\n"
        "rules: [interaction: {cell: 0.03}, collision]"
    )
    crowd, (solid,) = solver.grid, solver.scene.solids
    prepare(solver)
    box = crowd.boxes[-1]
    low, size = box[LOW : LOW + 3], box[SIZE : SIZE + 3]
    z, y, x = np.meshgrid(*(crowd.cell * (low[c] + np.arange(size[c]) + 0.5) for c in (2, 1, 0)), indexing="ij")
    far = depth(np.stack([x, y, z], -1).reshape(-1, 3), solid, solver.scene.emitter).reshape(x.shape) / -crowd.cell
    beyond = 0.5 * np.maximum(1 - np.abs(far), 0) ** 2
    wanted = np.where(far > 0, 1 - beyond, np.where(far > -0.95, beyond, 0))
    wanted[~crowd.near] = 1
    assert 0 < crowd.near.sum() < crowd.near.size
    found = crowd.room.open.reshape(x.shape)
    inner = np.abs(far + 0.95) > 1e-4  # where it jumps rounding decides
    np.testing.assert_allclose(found[inner], wanted[inner], atol=1e-5)
    assert (found < 0.5).sum() > 20
    monkeypatch.setattr(strand_grid, "find_room", None)
    prepare(solver)
    np.testing.assert_array_equal(crowd.room.open.reshape(x.shape)[inner], found[inner])
    solver.surroundings._packed[-1][0, 0] += 0.01  # the ball moves
    with pytest.raises(TypeError, match="not callable"):
        prepare(solver)
