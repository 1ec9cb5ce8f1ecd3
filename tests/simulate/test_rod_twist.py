"""Coils whose torsion a preset gives: springs, their bounce at any step, and what is refused."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from rod_kit import rod_of, take_steps
from strand_kit import scene_of, warned
from strandcli.constants import VECTOR
from strandcli.groom.blocks import aligned
from strandcli.jit import function
from strandcli.simd import load, store, vector_pointer
from strandcli.simd.turning import cosine_sine
from strandcli.simulate.advice import warnings
from strandcli.simulate.rod.kernels import rest_shape
from strandcli.simulate.rod.solver import RodSolver
from strandcli.study.references import spring, track_of

LANES = VECTOR // 8


@function
def turned(given: Any, out: Any, count: int) -> None:
    """Cosines of vectors of angles, and then their sines."""
    angles, to = vector_pointer(given), vector_pointer(out)
    for i in range(count):
        c, d = cosine_sine(load(angles, i))
        store(to, i, c)
        store(to, count + i, d)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_cosines_and_sines_are_right_to_the_last_digits(dtype: Any) -> None:
    angles, out = aligned((1536,), dtype), aligned((2, 1536), dtype)
    angles[...] = np.concatenate([np.linspace(-1, 1, 512), np.linspace(-4, 4, 512), np.linspace(-3000, 3000, 512)])
    turned(angles, out.reshape(-1), angles.nbytes // VECTOR)
    exact = np.array([np.cos(angles.astype(np.longdouble)), np.sin(angles.astype(np.longdouble))])
    assert np.abs(out - exact).max() <= np.finfo(dtype).eps


def stretched(particles: int, **rod: Any) -> float:
    """Relative error of the spring's stiffness."""
    case = spring.case(particles)
    case.settings["rod"].update(rod)
    error = spring.measure(track_of(case, 1 / 480, spring.SPRING.span))["stiffness"]
    assert error is not None
    return error


def test_a_coil_has_a_spring_s_stiffness_ever_nearer_with_more_segments() -> None:
    few, _, many = (len(spring.coil(arm)) for arm in spring.ARM)
    coarse, fine = stretched(few), stretched(many)
    assert fine < 0.02
    assert math.log(coarse / fine) / math.log((many - 1) / (few - 1)) > 1.7


def test_the_stiffness_is_that_of_torsion() -> None:
    """With twice the torsion it would be another spring."""
    assert stretched(len(spring.coil(3)), torsion=2 * spring.TORSION) > 0.6


def ringlet(fps: int, more: str = "torsion: 0.7", rest: str = "shape") -> RodSolver:
    return rod_of(
        f"rod: {{rest: {rest}, radius: 2.5e-5, damping: 0.0002, {more}}}\ntime: {{fps: {fps}}}\n"
        "emitter: {shape: {kind: disc, radius: 0.01}, strands: 16, particles: 60, length: 0.2, curl_turns: 5, "
        "curl_angle: 60, rotation: [180, 0, 0]}\nrules: [gravity]\n"
    )


def bounce(solver: RodSolver, seconds: float) -> NDArray[np.float64]:
    """(frames,) height of the first tip under its root."""
    fps = solver.scene.time.fps
    found = []
    for frame in range(2, round(fps * seconds) + 2):
        solver.advance(frame)
        x = solver.particles()[0]
        found.append(float(x[0, 1] - x[-1, 1]))
    return np.array(found)


def test_a_ringlet_bounces_and_comes_to_rest_in_one_place_at_every_step() -> None:
    more = "torsion: 0.7, drag: 4"
    coarse, fine = bounce(ringlet(24, more), 5), bounce(ringlet(96, more), 5)
    assert coarse.max() > 1.03 * coarse[-1], "it does not bounce"
    assert coarse.max() == pytest.approx(fine.max(), rel=0.05)
    assert coarse[-1] == pytest.approx(fine[-1], rel=1e-3)
    assert np.ptp(coarse[-6:]) < 1e-3 * coarse[-1]


@pytest.mark.parametrize("rest", ["shape", "sag_free"])
def test_coils_too_fast_for_the_steps_stay_where_they_are(rest: str) -> None:
    stiff = ringlet(24, "torsion: 0.7, young: 1.0e+13", rest)
    heights = bounce(stiff, 1)
    assert np.ptp(heights) < 1e-3
    assert warnings(stiff.scene, stiff.groom) == []


def test_a_ringlet_bounces_on_in_the_second_second_and_no_more_than_in_the_first() -> None:
    kept = bounce(ringlet(24, "torsion: 0.7, drag: 0"), 2)
    assert 0.5 * np.ptp(kept[:24]) < np.ptp(kept[24:]) < np.ptp(kept[:24])


def swung(rate: int, double: bool = False) -> NDArray[np.float64]:
    """(3, 16) where tips of ringlets are from their roots, over their length, after half a second on an emitter that
    turns about them and across."""
    solver = rod_of(
        f"rod: {{rest: shape, radius: 4.0e-5, damping: 0.02, torsion: 0.7}}\ntime: {{fps: {rate}}}\n"
        "emitter: {shape: {kind: disc, radius: 0.01}, strands: 16, particles: 26, length: 0.2, curl_turns: 3, "
        "curl_angle: 50, keys: [{time: 0, rotation: [180, 0, 0]}, {time: 0.5, rotation: [220, 60, 0]}]}\n"
        "rules: [emitter_motion, gravity]\n",
        double=double,
    )
    take_steps(solver, rate, rate // 2)
    return np.asarray(solver.state.edges.reshape(25, 3, 16).mean(0, dtype=np.float64))


def test_ringlets_that_are_swung_hardly_depend_on_the_step() -> None:
    """Their rest shapes are those of where they move, as far as iterations in double precision find: 2e-5. It is 2e-4
    where rest shapes have followed edges to .001 of a segment, more where a first solution's reaction is taken."""
    coarse, fine = swung(128), swung(256)
    assert np.abs(coarse - swung(128, double=True)).max() < 4e-5
    assert np.abs(coarse - fine).max() < 3e-4
    assert np.abs(fine - swung(512)).max() < 0.7 * np.abs(coarse - fine).max()


def test_curls_of_few_segments_a_turn_are_warned_of() -> None:
    def told(particles: int, rest: str, angle: int) -> list[str]:
        scene = scene_of(
            f"solver: rod\nrod: {{rest: {rest}}}\nemitter: {{strands: 16, particles: {particles}, length: 0.3, "
            f"curl_turns: 12, curl_angle: {angle}}}\nrules: [gravity]\n"
        )
        return [line for line in warned(scene) if "segments a turn" in line]

    for angle in (10, 56):
        (line,) = told(26, "shape", angle)
        assert line.startswith("rod.rest: shape: 16 of 16 strands have curls with as few as 2.1 segments")
        assert not told(64, "shape", angle)
    assert not told(26, "straight", 56)


def test_strands_of_every_pack_are_moved() -> None:
    solver = rod_of(
        "emitter: {strands: 40, particles: 6, curl_angle: 30, curl_turns: 1, rotation: [90, 0, 0]}\nrules: [gravity]\n"
    )
    start = solver.particles().copy()
    solver.advance(2)
    assert np.abs(solver.particles() - start).max(axis=(1, 2)).min() > 1e-4


@function
def torques(given: Any, out: Any, count: int) -> None:
    at, to = vector_pointer(given), vector_pointer(out)
    for i in range(count):
        x, y, v, w = load(at, i), load(at, count + i), load(at, 2 * count + i), load(at, 3 * count + i)
        turn, stiff = rest_shape.torque(x, y, v, w)
        store(to, i, turn)
        store(to, count + i, stiff)


def test_a_step_of_twist_lowers_the_energy_of_a_bend() -> None:
    """And goes to the balance at once where it is near."""
    draw, count = np.random.Generator(np.random.Philox(key=3)), 512 * LANES
    given, out = aligned((4, count), np.float64), aligned((2, count), np.float64)
    given[...] = draw.normal(size=given.shape)

    def bent(angle: NDArray[np.float64]) -> NDArray[np.float64]:
        x, y, v, w = given
        c, d = np.cos(angle), np.sin(angle)
        return 0.5 * ((c * x + d * y - v) ** 2 + (c * y - d * x - w) ** 2)

    def step() -> NDArray[np.float64]:
        torques(given.reshape(-1), out.reshape(-1), count // LANES)
        return np.asarray(out[0] / out[1])

    zero, first = np.zeros(count), step()
    assert (bent(first) <= bent(zero) + 1e-12).all()
    small = 1e-6
    slope = (bent(zero + small) - bent(zero - small)) / (2 * small)
    np.testing.assert_allclose(out[0], -slope, atol=1e-8)
    given[:2] = given[2:]  # at rest, and then turned a little
    c, d = math.cos(0.01), math.sin(0.01)
    given[0], given[1] = c * given[2] - d * given[3], c * given[3] + d * given[2]
    assert np.abs(step() - 0.01).max() < 1e-6
