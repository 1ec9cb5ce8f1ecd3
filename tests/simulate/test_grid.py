"""Strands that interact: density, pressure, friction and shelter, against twins, closed forms and sums that stay."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numba import njit
from numpy.typing import NDArray

from rod_kit import rod_of
from strand_kit import scene_of
from strandcli.errors import UsageError
from strandcli.scene import SceneError
from strandcli.simulate.grid.kernels import pressure as grid_pressure
from strandcli.simulate.grid.kernels.records import LOW, MASS, SIZE, Room
from strandcli.simulate.grid.strand_grid import Moment
from strandcli.simulate.rod.kernels.arrays import PACK
from strandcli.simulate.rod.solver import RodSolver

BALL = "shape: {kind: sphere, radius: 0.1}, particles: 6, length: 0.2, jitter: 40"
CALM = (0.0, 0.0, 0.0)


def rows(packed: NDArray[Any], strands: int) -> NDArray[np.float64]:
    """(strands, N, 3) of what lies in packs."""
    wide = packed.reshape(*packed.shape[:2], 3, PACK).transpose(0, 3, 1, 2).astype(np.float64)
    return wide.reshape(-1, packed.shape[1], 3)[:strands]


def prepare(solver: RodSolver, dt: float = 1 / 60, wind: tuple[float, float, float] = CALM) -> None:
    moment = Moment(dt, wind, CALM, solver.surroundings.packed())
    solver.grid.prepare(solver.state, solver.mass, np.zeros_like(solver.drive.roots), moment)


def spread(solver: RodSolver) -> dict[tuple[int, ...], NDArray[np.float64]]:
    """Metres and momentum of cells by their numbers: a twin of the grid in plain Python."""
    crowd = solver.grid
    x = np.concatenate([solver.positions[:, 1:].reshape(len(solver.positions), -1, 3, 128)], 0).astype(np.float64)
    x = x.transpose(0, 3, 1, 2).reshape(-1, x.shape[1], 3)[: solver.strands]
    v = np.concatenate([np.zeros((solver.strands, 1, 3)), rows(solver.state.velocity, solver.strands)], 1)
    lengths = np.linalg.norm(np.diff(x, axis=1), axis=2)
    several = len(crowd.samples.first) // lengths.shape[1]
    found: dict[tuple[int, ...], NDArray[np.float64]] = {}
    for strand in range(solver.strands):
        for j in range(lengths.shape[1]):
            for t in (np.arange(several) + 0.5) / several:
                at = (x[strand, j] + t * (x[strand, j + 1] - x[strand, j])) / crowd.cell - 0.5
                u = v[strand, j] + t * (v[strand, j + 1] - v[strand, j])
                low = np.floor(at)
                for corner in np.ndindex(2, 2, 2):
                    share = np.prod(np.where(corner, at - low, 1 - (at - low)))
                    mass = share * lengths[strand, j] / several
                    key = tuple((low + corner).astype(int).tolist())
                    found[key] = found.get(key, np.zeros(4)) + mass * np.append(1, u)
    return found


@pytest.mark.parametrize("cell", [0.03, 0.015])
def test_segments_are_spread_over_the_cells_around_them(cell: float) -> None:
    solver = rod_of(f"emitter: {{{BALL}, strands: 40}}\nrules: [interaction: {{cell: {cell}}}]")
    solver.state.velocity[...] = np.random.default_rng(0).normal(size=solver.state.velocity.shape)
    prepare(solver)
    assert len(solver.grid.samples.first) == 5 * np.ceil(0.04 / cell)
    box, grid = solver.grid.boxes[-1], solver.grid.grid
    twin = np.zeros((*box[SIZE : SIZE + 3], 4))
    for key, values in spread(solver).items():
        twin[tuple(np.array(key) - box[LOW : LOW + 3])] = values
    np.testing.assert_allclose(grid[:4].T, twin.transpose(2, 1, 0, 3).reshape(-1, 4), atol=2e-6)
    assert grid[MASS].sum() == pytest.approx(40 * 0.2, rel=1e-5)


def test_friction_alone_never_adds_energy() -> None:
    """However long the step; of a velocity that all share nothing is lost."""
    solver = rod_of(f"emitter: {{{BALL}, strands: 200}}\nrules: [interaction: {{friction: 1, cell: 0.05}}]")
    crowd, state, mass = solver.grid, solver.state, solver.mass[None, :, None]
    crowd.samples.mass[crowd.samples.first == 0] = 0
    solver.mass[0] = 0.5
    state.velocity[...] = np.random.default_rng(2).normal(size=state.velocity.shape)
    prepare(solver, 1.0)
    crowd.density = 1.01 * crowd.found  # no pressure
    before = rows(state.velocity, 200)
    prepare(solver, 1.0)
    after = before + rows(state.acceleration, 200)
    assert (mass * after**2).sum() <= (mass * before**2).sum()


def test_what_strands_get_others_lose() -> None:
    """By friction and pressure, of free particles for a second: momentum stays to 1e-5 of what each gets in all steps,
    and energy falls."""
    text = f"emitter: {{{BALL}, strands: 300}}\nrules: [interaction: {{friction: 0.3, cell: 0.03, density: 2000}}]"
    solver = rod_of(text)
    crowd, state, dt = solver.grid, solver.state, 1 / 60
    crowd.samples.mass[crowd.samples.first == 0] = 0
    solver.mass[0] = 0.5  # the emitter would take up what goes to the roots
    state.velocity[...] = np.random.default_rng(1).normal(scale=0.1, size=state.velocity.shape)
    mass = solver.mass[None, :, None].astype(float)
    begin, sizes, energies, densest = (mass * rows(state.velocity, 300)).sum((0, 1)), 0.0, [], 0.0
    for _ in range(60):
        prepare(solver, dt)
        densest = max(densest, crowd.found / 2000)
        state.velocity[...] += dt * state.acceleration
        sizes += np.linalg.norm((mass * dt * rows(state.acceleration, 300)).sum(1), axis=1).sum()
        energies.append((mass * rows(state.velocity, 300) ** 2).sum())
    change = (mass * rows(state.velocity, 300)).sum((0, 1)) - begin
    assert np.linalg.norm(change) < 1e-5 * sizes
    assert densest > 1.5, "pressure had nothing to do"
    assert energies[-1] < 0.5 * energies[0]


PLATE = """
rod: {rest: straight, radius: 1.0e-4, young: 1.0e+5, drag: 5, friction: 0}
time: {fps: 30}
emitter: {shape: {kind: plane, width: 0.1, depth: 0.1}, strands: 1600, particles: 9, length: 0.1}
solids:
- {kind: box, size: [0.02, 0.3, 0.3], position: [0.07, 0.17, 0],
   keys: [{time: 0, position: [0.07, 0.17, 0]}, {time: 1, position: [0.035, 0.17, 0]}]}
rules: [collision%s]
"""


def test_a_pressed_layer_holds_as_many_strands_a_square_metre_as_allowed() -> None:
    """Without pressure they pile up before the plate, twice as dense and more."""
    solver = rod_of(PLATE % ", interaction: {density: 240000, cell: 0.01}")
    solver.advance(91)
    assert solver.errors(91)["density_max"] < 1.05  # type: ignore[operator]
    assert solver.errors(91)["penetration_max"] < 1e-6  # type: ignore[operator]
    alone = rod_of(PLATE % ", interaction: {density: 1.0e+9, friction: 0, cell: 0.01}")
    alone.advance(91)
    assert alone.errors(91)["density_max"] * 1e9 > 1.4 * 240000  # type: ignore[operator]


@pytest.mark.parametrize("wide", [16, 32, 48])
def test_pressure_solves_the_complementarity_problem(wide: int) -> None:
    """Where solids leave a part of some cells, each face counts as far as it is open."""
    box = np.array([0, 0, 0, wide, 9, 7, 0])
    rng = np.random.default_rng(3)
    excess = rng.normal(scale=0.3, size=wide * 9 * 7).astype(np.float32)
    own = np.where(rng.random(len(excess)) > 0.2, rng.uniform(0.3, 1, len(excess)), 0).astype(np.float32)
    apertures = np.pad(own.reshape(7, 9, wide), 1, constant_values=1)
    around = sum(np.roll(apertures, shift, axis) for axis in range(3) for shift in (-1, 1))[1:-1, 1:-1, 1:-1].ravel()
    faces, pressure = (own / np.maximum(around, 1e-6)).astype(np.float32), np.zeros_like(own)
    over = np.where(own > 0, excess / np.maximum(own, 1e-6), 0).astype(np.float32)
    room = Room(own**2, own, faces, over, pressure, pressure, pressure)
    work = np.zeros(grid_pressure.work_shape(wide, 9, 7), np.float32), np.empty((2, 7 + 2, 9 + 2), np.bool_)
    sweep = njit(lambda *given: grid_pressure.relax(*given))
    for _ in range(20):
        sweep(box, room, np.ones((7, 9), np.bool_), *work, pressure)
    p = np.pad(pressure.reshape(7, 9, wide), 1)
    left = np.zeros((7, 9, wide))
    for axis in range(3):
        for shift in (-1, 1):
            there = np.roll(p, shift, axis)[1:-1, 1:-1, 1:-1]
            passes = (apertures * np.roll(apertures, shift, axis))[1:-1, 1:-1, 1:-1]
            left += passes * (p[1:-1, 1:-1, 1:-1] - there)
    left -= excess.reshape(left.shape)
    inner, mine = apertures[1:-1, 1:-1, 1:-1] > 0, pressure.reshape(left.shape)
    assert mine.min() == mine[~inner].max() == 0 < (mine > 0).sum() - 100
    held = inner & (faces.reshape(left.shape) > 0)
    assert left[held].min() > -1e-4
    assert np.abs(left[held & (mine > 0)]).max() < 1e-4


@pytest.mark.parametrize(
    ("rule", "message"),
    [
        ("cell: 1.0e-5", "less than a strand's thickness of 7e-05 m"),
        ("cell: 3", "larger than the groom, which is 0.588 m wide"),
        ("cell: 5.0e-4", "less than a 64th of a segment of 0.05 m"),
        ("cell: 0.001", "more than 4,000,000; make them at least 0.00"),
        ("density: 0", "density: must be a number above 0"),
        ("friction: 1.5", "friction: must be a number of at least 0 and of at most 1"),
    ],
)
def test_bad_input_is_refused_by_name(rule: str, message: str) -> None:
    def start() -> None:
        rod_of(
            "emitter: {shape: {kind: sphere, radius: 0.1}, strands: 64, particles: 5, length: 0.2}\n"
            f"rules: [interaction: {{{rule}}}]"
        ).advance(2)

    with pytest.raises((UsageError, SceneError), match=message) as raised:
        start()
    assert "\n" not in str(raised.value)


def test_it_is_refused_twice_and_by_the_source_s_solver() -> None:
    with pytest.raises(SceneError, match="list interaction once"):
        scene_of("solver: rod\nrules: [interaction: {}, interaction: {}]")
    with pytest.raises(SceneError, match="does not apply this rule, for its strands have no velocity"):
        scene_of("rules: [interaction: {}]")


def test_nothing_of_it_is_there_where_it_is_not_listed() -> None:
    solver = rod_of(f"emitter: {{{BALL}, strands: 40}}\nrules: [gravity]")
    assert solver.grid is None
    assert len(solver.state.acceleration) == 1
    assert "density_max" not in solver.errors(1)


def test_one_strand_of_an_emitter_a_thousand_kilometres_wide() -> None:
    solver = rod_of(
        "emitter: {shape: {kind: disc, radius: 1.0e+6}, strands: 1, particles: 5, length: 1000}\n"
        "rules: [gravity, interaction: {}]"
    )
    solver.advance(3)
    assert solver.errors(3)["nonfinite"] == 0
