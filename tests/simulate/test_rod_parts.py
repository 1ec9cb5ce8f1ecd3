"""Short and stiff strands that solids press in steps as long as their fall: steps in parts."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from strand_kit import scene_of
from strandcli.groom.emit import emit
from strandcli.groom.record import Groom
from strandcli.simulate.rod.kernels.arrays import PACK
from strandcli.simulate.rod.solver import RodSolver
from tests.simulate.test_rod_rest import STILL, rms

RATE = 24
FLOOR = "rules: [gravity, collision]\nsolids: [{{kind: plane, position: [0, {height}, 0]}}]\n"
MOVING = (
    "rules: [emitter_motion, gravity, collision]\nsolids: [{{kind: plane, position: [0, {height}, 0], keys: "
    "[{{time: 0, position: [0, {height}, 0], ease: linear}}, {{time: 10, position: [1, {height}, 0]}}]}}]\n"
)


def above_a_floor(
    length: float,
    weight: float,
    height: float,
    root: str = "clamped",
    around: str = FLOOR,
    keys: str = "",
    more: str = "damping: 0.01",
    double: bool = False,
) -> RodSolver:
    """24 strands clamped downward at a share of their length above a floor; ``weight``: over their stiffness; ``more``:
    of the rod; ``double``: in double precision."""
    radius = 0.002 * length
    young = 4 * 1000 * 9.81 * length**3 / weight / radius**2
    scene = scene_of(
        f"solver: rod\nrod: {{rest: straight, density: 1000, radius: {radius:g}, young: {young:.6g}, "
        f"drag: 5, friction: 0.2, root: {root}, {more}}}\ntime: {{fps: {RATE}}}\n"
        f"emitter: {{shape: {{kind: disc, radius: {0.2 * length:g}}}, strands: 24, particles: 26, length: {length}, "
        f"jitter: 20, rotation: [180, 0, 0]{keys}}}\n" + around.format(height=-height * length)
    )
    return RodSolver(scene, emit(scene.emitter, scene.seed), double)


def tips(solver: RodSolver) -> NDArray[np.float64]:
    """(strands, 3), about the roots."""
    particles = solver.particles().astype(float)
    found: NDArray[np.float64] = particles[:, -1] - particles[:, 0]
    return found


def motion_in_the_last_second(solver: RodSolver, seconds: int) -> float:
    """Root mean square of how far tips move in a frame, about their roots, metres."""
    seen = []
    for i in range(seconds * RATE):
        solver.step((i + 1) / RATE, 1 / RATE)
        seen.append(tips(solver))
    return rms(np.linalg.norm(np.diff(seen[-RATE:], axis=0), axis=-1))


@pytest.mark.parametrize("root", ["clamped", "hinged"])
@pytest.mark.parametrize("height", [0.3, 0.6])
@pytest.mark.parametrize("weight", [3, 10])
@pytest.mark.parametrize("length", [0.01, 0.02, 0.05])
def test_stiff_strands_rest_that_fall_as_far_in_a_step_as_they_are_long(
    length: float, weight: float, height: float, root: str
) -> None:
    """Without parts, tips move by up to the strand's length and more in a frame, for ever."""
    assert motion_in_the_last_second(above_a_floor(length, weight, height, root), 8) < STILL


def test_they_rest_on_a_floor_that_moves_with_them() -> None:
    keys = ", keys: [{time: 0, rotation: [180, 0, 0], ease: linear}, {time: 10, rotation: [180, 0, 0], "
    solver = above_a_floor(0.02, 3, 0.6, around=MOVING, keys=keys + "position: [1, 0, 0]}]")
    assert motion_in_the_last_second(solver, 8) < STILL


def swing(beside: bool) -> NDArray[np.float64]:
    """(steps,) how far the tip of a long strand swings, ``beside`` such as solids lead astray at first."""
    scene = scene_of(
        f"solver: rod\nrod: {{rest: straight, drag: 0, damping: 0}}\ntime: {{fps: {RATE}}}\n"
        "emitter: {strands: 16, particles: 10, length: 0.3}\nrules: [gravity, collision]\n"
        "solids: [{kind: plane, position: [0, -0.003, 0]}]\n"
    )
    roots, ways, lengths = np.zeros((16, 3)), np.tile([0.05, -1.0, 0.0], (16, 1)), np.full(16, 0.01)
    roots[:, 0] = 0.02 * np.arange(16)
    long = np.arange(16) >= (8 if beside else 0)
    roots[long, 1], ways[long], lengths[long] = 1.0, [1.0, -0.2, 0.0], 0.3
    ways /= np.linalg.norm(ways, axis=1)[:, None]
    single = (one.astype(np.float32) for one in (roots, ways, lengths, np.zeros(16)))
    solver = RodSolver(scene, Groom(*single))
    found = []
    for i in range(3 * RATE):
        solver.step((i + 1) / RATE, 1 / RATE)
        found.append(tips(solver)[-1, 0])
    return np.array(found)


def test_strands_beside_them_go_on_as_alone() -> None:
    """Parts are Euler's, which would take most of their swing."""
    alone = swing(False)
    assert np.ptp(alone[-RATE:]) > 0.3
    np.testing.assert_allclose(swing(True), alone, atol=2e-3)


SHORT = 1e-9
"""Seconds of a step before the one that is made in parts: before the first one strands are put out of solids."""


def begun(solver: RodSolver, speed: float = 0.0) -> RodSolver:
    """The solver after a step of next to no time, with a speed along x and without forces of contact."""
    solver.step(SHORT, SHORT)
    for rows in (solver.state.velocity, solver.state.before, solver.state.ahead):
        rows[..., :PACK], rows[..., PACK:] = speed, 0
    solver.state.force[...] = 0
    return solver


def by_edges(solver: RodSolver) -> NDArray[np.float64]:
    """`tips` by the edges, in double precision."""
    rows = solver.state.edges.sum(1).reshape(-1, 3, PACK) * solver.material.lengths[:, None]
    return np.asarray(rows.transpose(0, 2, 1).reshape(-1, 3)[: solver.strands])


SPEED = 0.2
ALONG = (
    f"rules: [emitter_motion, gravity, collision, wind: {{{{strength: {SPEED}, direction: [1, 0, 0]}}}}]\n"
    "solids: [{{kind: plane, position: [0, {height}, 0], keys: [{{time: 0, position: [0, {height}, 0], ease: linear}}, "
    f"{{{{time: 10, position: [{10 * SPEED}, {{height}}, 0]}}}}]}}}}]\n"
)


def test_strands_whose_roots_floor_and_air_move_alike_move_as_those_at_rest() -> None:
    """Parts are made about roots, with velocities relative to these: otherwise no strand would move alike. Of many,
    rounding decides in how many parts they are moved."""
    keys = ", keys: [{time: 0, rotation: [180, 0, 0], ease: linear}, {time: 10, rotation: [180, 0, 0], "
    keys += f"position: [{10 * SPEED}, 0, 0]}}]"
    still = begun(above_a_floor(0.02, 0.03, 0.6, double=True))
    moving = begun(above_a_floor(0.02, 0.03, 0.6, "clamped", ALONG, keys, double=True), SPEED)
    for i in range(3):
        for solver in (still, moving):
            solver.step(SHORT + (i + 1) / RATE, 1 / RATE)
        off = np.linalg.norm(by_edges(moving) - by_edges(still), axis=1)
        assert (off < 1e-6).sum() >= 8
