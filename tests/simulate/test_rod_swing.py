"""Free swings at the steps of a film, over a pole, too: they keep their amplitude in steps no shorter than needed."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import strandcli
from rod_kit import each_step, rod_of
from strandcli.groom.emit import emit
from strandcli.simulate.rod import swing
from strandcli.simulate.rod.setup import matter_of, shape_of
from strandcli.simulate.rod.solver import RodSolver
from strandcli.study.references.oscillation import oscillation
from tests.simulate.test_rod import PULL, scene
from tests.simulate.test_rod_motion import FREE, energy, first

FPS = 24


def solver_of(gamma: float, length: float, **changes: Any) -> RodSolver:
    """A strand that hangs, with the rigidity that Γ asks for."""
    young = 4 * 1000.0 * PULL * length**3 / gamma / 1e-4**2
    material = {"rod.density": 1000.0, "rod.radius": 1e-4, "rod.young": young}
    settings = {**FREE, "time": {"fps": FPS}, "emitter.length": length, **material, **changes}
    one = scene(gamma, direction=settings.pop("direction", (0, -1, 0)), **settings)
    return RodSolver(one, emit(one.emitter, one.seed))


def frequency(gamma: float, length: float) -> float:
    """About that of a hanging strand, Hz: of a chain and of a beam by the sum of their squares."""
    return math.sqrt((1.4459 + 12.362 / gamma) * PULL / length) / math.tau


def swung(solver: RodSolver, hertz: float, fps: float = FPS) -> tuple[float, float]:
    """The share of its amplitude that a strand loses in a cycle after a push aside, and the energy that it gains after
    that, over m g L."""
    velocity = solver.state.velocity
    n = velocity.shape[1]
    u = np.arange(1, n + 1) / n
    length = float(solver.lengths[0, 0]) * n
    stiff = solver.material.stiffness[0, 0] * n**-4 * length > PULL  # shapes of a beam's and of a chain's first mode
    across = u**2 * (6 - 4 * u + u**2) / 3 if stiff else u
    velocity[0, :, : velocity.shape[2] // 3] = (0.05 * math.tau * hertz * length * across)[:, None]
    start, most, x = energy(solver), 0.0, []
    for _ in each_step(solver, fps, int(max(10 / hertz, 40 / fps) * fps)):
        most = max(most, energy(solver) - start)
        x.append(first(solver)[-1, 0])
    begin = math.ceil(fps / hertz)  # the first cycle takes what else the push has set in motion
    found = oscillation(np.arange(len(x) - begin) / fps, np.array(x[begin:]), math.tau * hertz)
    return -math.expm1(-math.tau * found[1] / found[0]), most


LENGTHS = (0.02, 0.03, 0.05, 0.08, 0.11, 0.15, 0.25, 0.5)
SWINGS = [(g, length) for g in (1e6, 1e3, 100.0, 10.0, 3.0, 1.0) for length in LENGTHS if frequency(g, length) < 7.9]


@pytest.mark.parametrize(("gamma", "length"), SWINGS)
def test_a_swing_that_the_film_shows_loses_at_most_3_percent_a_cycle(gamma: float, length: float) -> None:
    loss, growth = swung(solver_of(gamma, length), frequency(gamma, length))
    assert loss <= 0.03
    assert growth <= 0.01


@pytest.mark.parametrize(("gamma", "drag", "damping"), [(1e3, 1.0, 0.001), (3.0, 4.0, 0.001), (3.0, 1.0, 0.01)])
def test_what_drag_and_damping_take_counts_apart(gamma: float, drag: float, damping: float) -> None:
    changes = {"rod.drag": drag, "rod.damping": damping}
    for length in (0.03, 0.08, 0.2):
        hertz = frequency(gamma, length)
        if hertz < 7.9:
            fine, _ = swung(solver_of(gamma, length, **changes), hertz, 40 * FPS)
            found, _ = swung(solver_of(gamma, length, **changes), hertz)
            assert found - fine <= 0.03


@pytest.mark.parametrize("fps", [24, 60])
@pytest.mark.parametrize("length", [0.03, 0.08])
def test_short_strands_come_to_rest(length: float, fps: int) -> None:
    solver = solver_of(30.0, length, direction=(1, 0, 0), **{"rod.drag": 3.0, "time": {"fps": fps}})
    assert swing.parts(solver._swing_rate, 1 / fps) > 1 or fps == 60
    seen = []
    for _ in each_step(solver, fps, 16 * fps):
        seen.append(first(solver)[-1])
    assert np.ptp(np.array(seen[-fps:]), axis=0).max() <= 1e-6 * length


@pytest.mark.parametrize("root", ["clamped", "hinged"])
def test_a_limp_strand_that_falls_over_gains_no_energy(root: str) -> None:
    """Where BDF2 goes on with edges that turn by more than a right angle in a step, they fly to and fro for ever, and
    the strand comes to have up to .7 m g L more."""
    for particles, length, degrees in ((6, 0.5, 175), (10, 0.12, 175), (12, 0.3, 140)):
        angle = math.radians(degrees)
        way = (math.sin(angle), -math.cos(angle), 0.0)
        solver = solver_of(1e5, length, direction=way, **{"emitter.particles": particles, "rod.root": root})
        start = energy(solver)
        for _ in each_step(solver, FPS, 5 * FPS):
            assert energy(solver) - start <= 0.01


@pytest.mark.parametrize("tilt", [0.0, 1e-5, 2e-3])
@pytest.mark.parametrize(("particles", "length"), [(5, 0.05), (9, 0.1), (21, 0.3)])
@pytest.mark.parametrize("whole", [False, True])
def test_a_limp_strand_that_stands_upright_gains_no_energy(
    whole: bool, particles: int, length: float, tilt: float
) -> None:
    """In steps that are cut for its swing, and in whole ones. Its first edge turned back at once and on again, which
    gave it up to .37 m g L: exactly upright it may stand."""
    changes = {"emitter.particles": particles, "direction": (tilt, 1, 0)}
    solver = solver_of(1e6, length, **changes)
    solver._swing_rate *= not whole
    start, most = energy(solver), 0.0
    for _ in each_step(solver, FPS, 36):
        most = max(most, energy(solver) - start)
    assert most < 0.01
    if tilt == 0.0:
        np.testing.assert_allclose(first(solver)[-1], (0, length, 0), atol=1e-6)


def found_frequency(solver: RodSolver) -> float:
    """What the choice of steps takes a strand's frequency to be, Hz."""
    one = solver.scene
    matter = matter_of(one, solver.groom)
    arguments = matter.lengths, matter.stiffness, shape_of(one, solver.groom, np.float64), np.eye(3)
    square = swing.frequencies(one, *arguments)[0]
    return float(np.sqrt(square[0])) / math.tau


def test_frequencies_are_those_of_chain_and_beam() -> None:
    unit = math.sqrt(PULL / 0.1) / math.tau
    assert found_frequency(solver_of(1e6, 0.1)) == pytest.approx(1.20241 * unit, rel=0.005)
    stiff = found_frequency(solver_of(1e-3, 0.1, **{"emitter.particles": 30}))
    assert stiff == pytest.approx(3.51602 * unit / math.sqrt(1e-3), rel=0.005)
    for gamma in (1.0, 10.0, 100.0):  # both count more together than by the sum of squares (Southwell)
        found = found_frequency(solver_of(gamma, 0.1, **{"emitter.particles": 30}))
        assert 1 <= found / frequency(gamma, 0.1) < 1.04
    # a hinged stiff rod is a pendulum
    assert found_frequency(solver_of(0.01, 0.1, **{"rod.root": "hinged"})) == pytest.approx(
        math.sqrt(1.5) * unit, rel=0.01
    )
    # one that stands swings the more slowly the nearer it is to buckling, at 7.84
    standing = [found_frequency(solver_of(g, 0.1, direction=(0, 1, 0))) * math.sqrt(g) / unit for g in (0.01, 4.0, 7.0)]
    assert standing == pytest.approx(
        [3.516, 3.516 * math.sqrt(1 - 4 / 7.84), 3.516 * math.sqrt(1 - 7 / 7.84)], rel=0.06
    )


def parts_of(solver: RodSolver) -> int:
    return swing.parts(solver._swing_rate, 1 / (solver.scene.time.fps * solver.scene.time.substeps))


def test_steps_are_cut_where_a_swing_asks_for_it_and_nowhere_else() -> None:
    short = 1e3, 0.05
    assert parts_of(solver_of(*short)) == 2
    assert parts_of(solver_of(10.0, 0.02)) == 4
    assert parts_of(solver_of(1e3, 0.25)) == 1  # slow enough
    assert parts_of(solver_of(0.1, 0.05)) == 1  # too fast for the film
    assert parts_of(solver_of(*short, **{"rod.drag": 40.0})) == 1  # it creeps
    assert parts_of(solver_of(*short, **{"rod.drag": 12.0})) == 1  # drag takes more of it than steps do
    assert parts_of(solver_of(*short, **{"time.substeps": 2})) == 1  # steps are short already
    assert parts_of(solver_of(*short, **{"time.fps": 60})) == 1
    assert solver_of(*short, **{"rod.end": "pinned"})._swing_rate == 0
    assert swing.parts(30.0, 10.0) == 1  # no film has such steps


def test_a_few_short_strands_cut_no_steps_of_a_groom() -> None:
    changes = {"emitter.strands": 200, "emitter.jitter": 5.0}
    even = solver_of(1e3, 0.12, **changes)
    rate = even._swing_rate
    assert parts_of(even) == 1
    lengths, stiffness = np.full(200, 0.12 / 9), np.full(200, 1e-6)
    shape = shape_of(even.scene, even.groom, np.float64)
    for count, cut in ((8, False), (160, True)):
        lengths[:count] = 0.04 / 9
        found = swing.swing_rate(even.scene, lengths, stiffness, shape, np.eye(3))
        assert (found > 1.3 * rate) == cut


@pytest.mark.parametrize("preset", ["hair", "portrait", "ponytail", "bob", "brush", "curly", "solvers"])
def test_shipped_presets_take_the_steps_that_they_ask_for(preset: str) -> None:
    one = strandcli.load(preset, overrides=["emitter.strands=1000"])
    for part in one.panels or (one,):
        if part.solver == "rod":
            assert parts_of(RodSolver(part, emit(part.emitter, part.seed))) == 1


Floats = NDArray[np.float64]
SETTLED = 3
"""Seconds after which a strand hangs over the pole at rest."""


def rows(solver: RodSolver, row: int) -> Floats:
    """(strands, 3) particles of a row of positions."""
    found = solver.positions[:, row].reshape(len(solver.positions), 3, -1).transpose(0, 2, 1)
    return found.reshape(-1, 3)[: solver.strands].astype(float)


def swings(rate: int, seconds: int) -> Floats:
    """(seconds,) half the width of the tip's swing along a pole in each second, from a push along it; of strands of
    .3 m that begin on it, lie across it and hang down behind."""
    solver = rod_of(
        f"rod: {{radius: 4.0e-5, drag: 0, damping: 0, rest: straight, friction: 0}}\ntime: {{fps: {rate}}}\n"
        "emitter: {shape: {kind: disc, radius: 0.0001}, strands: 16, particles: 26, length: 0.3,"
        " rotation: [0, 0, -90]}\nrules: [gravity, collision]\n"
        "solids: [{kind: capsule, radius: 0.03, length: 1, position: [0.05, -0.031, 0], rotation: [90, 0, 0]}]\n"
    )
    state = solver.state
    for _ in each_step(solver, rate, SETTLED * rate):
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


@pytest.mark.parametrize(("rate", "kept"), [(24, 0.88), (48, 0.97), (96, 0.97)])
def test_what_hangs_over_a_pole_keeps_its_swing(rate: int, kept: float) -> None:
    """In four seconds, some five cycles; by Euler's method .08, .28 and .52 of it are left. Nor does the swing grow."""
    found = swings(rate, 4)
    assert kept < found[3] / found[0] < 1.02
    assert 0.035 < found[0] < 0.05
