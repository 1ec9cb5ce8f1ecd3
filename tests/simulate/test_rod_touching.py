"""Strands that lean on solids swing as free ones do, and which of them take a step by Euler's method."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from strand_kit import scene_of
from strandcli.groom.emit import emit
from strandcli.simulate.kernels.records import STEADY
from strandcli.simulate.kernels.rod_touching import CALM, CHANGE, SLIGHT, SLIGHT_OF_CURLS
from strandcli.simulate.rod import RodSolver

Floats = NDArray[np.float64]
SETTLED = 3
"""Seconds after which a strand hangs over the pole at rest."""


def over_a_pole(rate: int, more: str = "rest: straight, friction: 0", curl: str = "", strands: int = 16) -> RodSolver:
    """Strands of .3 m that begin on a pole, lie across it and hang down behind."""
    scene = scene_of(
        f"solver: rod\nrod: {{radius: 4.0e-5, drag: 0, damping: 0, {more}}}\ntime: {{fps: {rate}}}\n"
        f"emitter: {{shape: {{kind: disc, radius: 0.0001}}, strands: {strands}, particles: 26, length: 0.3,"
        f" rotation: [0, 0, -90]{curl}}}\nrules: [gravity, collision]\n"
        "solids: [{kind: capsule, radius: 0.03, length: 1, position: [0.05, -0.031, 0], rotation: [90, 0, 0]}]\n"
    )
    return RodSolver(scene, emit(scene.emitter, scene.seed))


def rows(solver: RodSolver, row: int) -> Floats:
    """(strands, 3) particles of a row of positions."""
    found = solver.positions[:, row].reshape(len(solver.positions), 3, -1).transpose(0, 2, 1)
    return found.reshape(-1, 3)[: solver.strands].astype(float)


def swings(rate: int, seconds: int) -> Floats:
    """(seconds,) half the width of the tip's swing along the pole in each second, from a push along it."""
    solver = over_a_pole(rate)
    state = solver.state
    for i in range(SETTLED * rate):
        solver.step((i + 1) / rate, 1 / rate)
        for member in (state.velocity, state.ahead, state.before, state.moved):
            member *= 0.5 ** (24 / rate)
    along = 0.3 * np.linspace(0, 1, state.velocity.shape[1])[:, None]
    for member in (state.velocity, state.ahead, state.before):
        member.reshape(len(member), len(along), 3, -1)[:, :, 2] += along
    found = []
    for i in range(SETTLED * rate, (SETTLED + seconds) * rate):
        solver.step((i + 1) / rate, 1 / rate)
        found.append(rows(solver, -1)[0, 2])
    return np.ptp(np.array(found).reshape(seconds, rate), axis=1) / 2


@pytest.mark.parametrize(("rate", "kept"), [(24, 0.42), (48, 0.85), (96, 0.95)])
def test_what_hangs_over_a_pole_keeps_its_swing(rate: int, kept: float) -> None:
    """In four seconds, some five cycles; by Euler's method .08, .28 and .52 of it are left. Nor does the swing grow."""
    found = swings(rate, 4)
    assert kept < found[3] / found[0] < 1.05
    assert 0.035 < found[0] < 0.05


@pytest.mark.parametrize("rest", ["rest: straight, friction: 0.2", "rest: shape, friction: 0.2"])
def test_strands_are_marked_by_how_forces_of_contact_change(rest: str) -> None:
    """Against NumPy, at each step of strands that fall on a pole and swing."""
    curled = "shape" in rest
    curl = ", curl_turns: 2, curl_angle: 30" if curled else ""
    solver = over_a_pole(60, f"precision: double, {rest}", f"{curl}, jitter: 20", strands=24)
    state, dt, seen = solver.state, 1 / 60, set()
    for i in range(90):
        push, mark = state.push.copy(), state.touching.copy()
        before = rows(solver, -1) - rows(solver, 1)
        solver.step((i + 1) * dt, dt)
        way = np.linalg.norm(rows(solver, -1) - rows(solver, 1) - before, axis=1)
        shape = len(push), -1, push.shape[2] // 3

        def total(values: Floats, shape: tuple[int, int, int] = shape) -> Floats:
            return np.abs(values).reshape(shape).sum(1).reshape(-1)[: solver.strands]

        force, change = total(state.push), total(state.push - push)
        past, now = (one.reshape(-1)[: solver.strands] for one in (mark, state.touching))
        after = np.maximum(past - CALM, 0) if curled else np.zeros_like(past)
        after = np.where(force > 0, np.maximum(after, STEADY), after)
        little = (SLIGHT_OF_CURLS if curled else SLIGHT) * push.shape[1] * way
        much = (change > CHANGE * force) | ((force > 0) & (dt**2 * change >= little))
        np.testing.assert_allclose(now, np.where(much, 1, after), atol=1e-6, err_msg=str(i))
        seen |= set(now[now <= STEADY])
        if (now == 1).any():
            seen.add(1.0)
    assert {0.0, STEADY, 1.0} <= seen
