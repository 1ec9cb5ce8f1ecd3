"""Bending that keeps a set: springback by the limit and no further, and what is refused."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from strand_kit import require_same_after_restart, scene_of
from strandcli.errors import UsageError
from strandcli.groom.emit import emit
from strandcli.simulate.kernels.rod_scratch import PACK
from strandcli.simulate.rod import RodSolver

RADIUS = 1e-3
LIMIT = 0.002
"""A curvature of 2 / m."""
SEGMENTS = 20


def rod(more: str = f"yield_strain: {LIMIT}", rules: str = "") -> RodSolver:
    """One straight rod of a metre without weight, that unbends slowly."""
    scene = scene_of(
        f"solver: rod\nrod: {{radius: {RADIUS}, rest: straight, young: 1.0e+11, density: 1000, drag: 5, damping: 0.3, "
        f"precision: double, {more}}}\n"
        "emitter: {shape: {kind: disc, radius: 1.0e-6}, strands: 1, particles: 21, length: 1, length_variation: 0}\n"
        f"time: {{fps: 240}}\nrules: [{rules}]\n"
    )
    return RodSolver(scene, emit(scene.emitter, scene.seed))


def bend(solver: RodSolver, curvature: float) -> None:
    """Bend it to an arc, the clamp half a segment before the first edge's middle."""
    edges = solver.state.edges.reshape(-1, SEGMENTS, 3, PACK)
    axis = solver.forcing.directions.reshape(-1, 3, PACK)[0, :, 0]
    side = np.cross(axis, [0.3, 0.5, 0.8])
    side /= np.linalg.norm(side)
    for j in range(SEGMENTS):
        turn = curvature * (j + 0.5) / SEGMENTS
        edges[:, j] = (np.cos(turn) * axis + np.sin(turn) * side)[None, :, None]
    length = float(solver.material.lengths[0, 0])
    for j in range(SEGMENTS):
        rows = solver.state.positions.reshape(-1, SEGMENTS + 2, 3, 128)
        rows[:, j + 2] = rows[:, j + 1] + length * edges[:1, j, :, :1]


def curvatures(solver: RodSolver) -> np.ndarray:
    """(N - 1,) at the joints between edges, 1/m."""
    edges = solver.state.edges.reshape(-1, SEGMENTS, 3, PACK)[0, :, :, 0]
    return np.arcsin(np.linalg.norm(np.cross(edges[1:], edges[:-1]), axis=1)) * SEGMENTS


def settled(solver: RodSolver, frames: int) -> np.ndarray:
    for frame in range(2, frames + 2):
        solver.advance(frame)
    return curvatures(solver)


def test_a_rod_bent_beyond_the_limit_springs_back_by_it() -> None:
    solver = rod()
    bend(solver, 5.0)
    solver.yielding.follow(solver.state, solver.material, solver.forcing, solver.pose)  # type: ignore[union-attr]
    # of joints the sine is what is across the edge before
    kept = SEGMENTS * np.arcsin(np.sin(5.0 / SEGMENTS) - LIMIT / RADIUS / SEGMENTS)
    assert kept == pytest.approx(5.0 - LIMIT / RADIUS, rel=0.02)
    bend(solver, kept)  # there, and not let go from where it was: waves would bend it further
    np.testing.assert_allclose(settled(solver, 240), kept, rtol=1e-3)


@pytest.mark.parametrize(("more", "curvature"), [(f"yield_strain: {LIMIT}", 1.8), ("friction: 0", 5.0)])
def test_a_rod_bent_less_or_without_a_limit_springs_back_straight(more: str, curvature: float) -> None:
    solver = rod(more)
    bend(solver, curvature)
    if solver.yielding is not None:
        solver.yielding.follow(solver.state, solver.material, solver.forcing, solver.pose)
    assert settled(solver, 720).max() < 0.02


def test_a_set_is_kept_in_checkpoints() -> None:
    whole, half = rod(), rod()
    bend(whole, 5.0)
    require_same_after_restart(whole, half)
    assert curvatures(half).max() > 2.5


def test_what_makes_steps_several_times_is_refused_by_name() -> None:
    with pytest.raises(UsageError, match=r"rod\.yield_strain: does not go with the rule contact"):
        rod(rules="contact: {thickness: 0.01}")


def test_strands_without_a_limit_have_none() -> None:
    plain: Any = rod("friction: 0")
    assert plain.yielding is None
    assert "bends" not in plain.state_arrays()
