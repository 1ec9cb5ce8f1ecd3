"""Short and stiff strands that solids press in steps as long as their fall: steps in parts."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from rod_kit import each_step, rod_of
from strand_kit import scene_of
from strandcli.groom.record import Groom
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
) -> RodSolver:
    """24 strands clamped downward at a share of their length above a floor; ``weight``: over their stiffness; ``more``:
    of the rod."""
    radius = 0.002 * length
    young = 4 * 1000 * 9.81 * length**3 / weight / radius**2
    return rod_of(
        f"rod: {{rest: straight, density: 1000, radius: {radius:g}, young: {young:.6g}, "
        f"drag: 5, friction: 0.2, root: {root}, {more}}}\ntime: {{fps: {RATE}}}\n"
        f"emitter: {{shape: {{kind: disc, radius: {0.2 * length:g}}}, strands: 24, particles: 26, length: {length}, "
        f"jitter: 20, rotation: [180, 0, 0]{keys}}}\n" + around.format(height=-height * length),
    )


def tips(solver: RodSolver) -> NDArray[np.float64]:
    """(strands, 3), about the roots."""
    particles = solver.particles().astype(float)
    found: NDArray[np.float64] = particles[:, -1] - particles[:, 0]
    return found


def motion_in_the_last_second(solver: RodSolver, seconds: int) -> float:
    """Root mean square of how far tips move in a frame, about their roots, metres."""
    seen = []
    for _ in each_step(solver, RATE, seconds * RATE):
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
    for _ in each_step(solver, RATE, 3 * RATE):
        found.append(tips(solver)[-1, 0])
    return np.array(found)


def test_strands_beside_them_go_on_as_alone() -> None:
    """Parts are Euler's, which would take most of their swing."""
    alone = swing(False)
    assert np.ptp(alone[-RATE:]) > 0.3
    np.testing.assert_allclose(swing(True), alone, atol=2e-3)
