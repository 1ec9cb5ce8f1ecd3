"""Steps in which Newton's iterations find no lengths: descent (`kernels.rod_descent`)."""

from __future__ import annotations

import numpy as np
import pytest
from numba import njit
from numpy.typing import NDArray

from strand_kit import scene_of
from strandcli.blocks import aligned
from strandcli.constants import VECTOR
from strandcli.groom.emit import emit
from strandcli.scene.motion import emitter_pose
from strandcli.simd import load, store, vector_pointer_at
from strandcli.simulate.kernels import rod_descent, rod_tension
from strandcli.simulate.kernels.rod_scratch import (
    EDGE,
    FIRST_SEGMENT,
    INERTIAL,
    INNOVATION,
    INVERSE_PIVOT,
    SEGMENT,
    TENSION,
)
from strandcli.simulate.rod import RodSolver
from strandcli.study.stress import run as stress
from strandcli.study.stress import together

LANES = VECTOR // 8
FLIPPED = (
    "rod/dt=1e-4/B=0/gamma=0.1/wind=gale/emitter=flip/start=coincident/between=grid-fine/twist=sag-free/end=pinned/"
    "torsion=0.7"
)


@pytest.mark.parametrize(
    "name",
    [
        FLIPPED,
        "rod/B=0/gamma=7.7/emitter=shake/start=folded/between=grid-coarse/twist=sag-free/end=pinned",
        "rod/dt=240Hz/wind=gale/emitter=teleport/contact=through/start=coincident/between=grid/twist=sag-free/"
        "end=pinned/torsion=0.7",
        "rod/dt=240Hz/B=1e6/emitter=shake/contact=inside",
    ],
    ids=["flipped", "shaken", "held by a ball", "stiff in a shaken ball"],
)
def test_lengths_are_found(name: str) -> None:
    """Newton's iterations leave errors of .004 to 1e9 segments. The last case makes steps in parts."""
    for verdict in stress.perform(stress.named(name)):
        assert verdict.verdict == "pass", verdict.why


def turned_over(iterations: int, double: bool) -> float:
    """The greatest residual of steps in which slack strands that are pinned are turned over at once."""
    scene = scene_of(
        "solver: rod\nrod: {rest: straight, end: pinned, young: 1.0e+9, radius: 1.0e-4, "
        f"iterations: {iterations}}}\ntime: {{fps: 24}}\n"
        "emitter: {shape: {kind: disc, radius: 0.03}, strands: 32, particles: 20, length: 0.3, curl_turns: 2, "
        f"curl_angle: 50, keys: [{{time: 0}}, {{time: {2 / 24}}}, "
        f"{{time: {3 / 24}, position: [0.05, 0, 0], rotation: [180, 0, 0]}}]}}\n"
        "rules: [emitter_motion, gravity]\n"
    )
    solver, found = RodSolver(scene, emit(scene.emitter, scene.seed), double), 0.0
    for i in range(6):
        solver.step((i + 1) / 24, 1 / 24)
        found = max(found, float(solver.strand_residuals().max()))
    return found


@pytest.mark.parametrize("double", [False, True])
def test_one_iteration_more_than_newtons_alone_finds_lengths_with_descent(double: bool) -> None:
    """A scene that allows for fewer has none; those of Newton's method alone leave errors of .0018."""
    assert turned_over(rod_descent.WILLING - 1, double) > rod_descent.LOST / 2
    assert turned_over(rod_descent.WILLING, double) < 1e-5


def test_pinned_tips_of_flipped_strands_come_to_their_places() -> None:
    (case,), labels = stress.named(FLIPPED).cases, stress.named(FLIPPED).labels
    scene, groom, times = together.prepared(case, labels)
    solver = RodSolver(scene, groom)
    past = 0.0
    assert solver.pins is not None
    with np.errstate(all="ignore"):
        for time in times.tolist():
            solver.step(time, time - past)
            past = time
            pose = emitter_pose(scene.emitter, time)
            wanted = np.array(pose.rotation) @ solver.pins.places[0][:, : len(groom.roots)]
            off = np.linalg.norm(solver.particles()[:, -1] - wanted.T - np.array(pose.translation), axis=1)
            assert off.max() < 2e-4


def test_long_steps_of_stiff_strands_that_turn_freely_have_lengths() -> None:
    """A joint a million million times as firm as a particle is heavy leaves an edge less freedom than rounding."""
    name = "rod/dt=0.5/B=1e6/gamma=0/between=grid/twist=coil/root=hinged"
    (verdict,) = stress.perform(stress.named(name))
    assert verdict.metrics["residual"] < 1e-3


def scratch_of(n: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Scratch of strands with n segments, and the vectors of segments in it."""
    scratch = aligned((rod_tension.scratch_size(n), LANES), np.float64)
    return scratch, scratch[FIRST_SEGMENT : FIRST_SEGMENT + n * SEGMENT].reshape(n, SEGMENT, LANES)


@njit(error_model="numpy")
def spoil(address, n):
    """Keep what lanes have, write over all of it, and restore all but lanes whose `INNOVATION` is above 0."""
    pile = vector_pointer_at(np.float64, address)
    rod_descent.keep(pile, n)
    for place in range(FIRST_SEGMENT, FIRST_SEGMENT + n * SEGMENT):
        if (place - FIRST_SEGMENT) % SEGMENT != INNOVATION:
            store(pile, place, 7.0)
    rod_descent.restore(pile, n, load(pile, FIRST_SEGMENT + INNOVATION) > 0.0)


def test_lanes_beside_keep_their_bits() -> None:
    scratch, rows = scratch_of(5)
    rows[...] = np.random.default_rng(1).normal(size=rows.shape)
    rows[:, INNOVATION] = np.arange(LANES) == 1
    given = rows.copy()
    spoil(scratch.ctypes.data, 5)
    last = [*range(EDGE, EDGE + 3), *range(INERTIAL, INERTIAL + 3), TENSION, *range(INVERSE_PIVOT, INVERSE_PIVOT + 3)]
    others = np.arange(LANES) != 1
    np.testing.assert_array_equal(rows[:, last][..., others], given[:, last][..., others])
    assert (rows[:, last, 1] == 7.0).all()
