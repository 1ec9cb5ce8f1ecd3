"""References against tables of the literature, series of another making, and their own differential equations; and
their measures, which must find no fault with an exact run and the whole fault of a wrong one; and the production solver
against them: H/W within 1.5 % up to Γ = 1 and 2.5 % at Γ = 10 with nine segments, second order in the segments."""

from __future__ import annotations

import math

import numpy as np
import pytest

from strandcli.study.points import Point, fitted_order
from strandcli.study.references import REFERENCES, References, Track, elastica, spring
from strandcli.study.references import oscillation as modes
from strandcli.study.sweep import Request

DROOP = {
    0.1: 0.0124996, 1: 0.124562, 3: 0.364621, 10: 1.06680, 30: 2.54721, 100: 5.88810, 300: 11.1831, 1e3: 21.3354,
    1e4: 69.7088,
}  # fmt: skip


@pytest.mark.parametrize("load", DROOP)
def test_heavy_elastica_is_that_of_the_table(load: float) -> None:
    assert elastica.hang(load).droop == pytest.approx(DROOP[load], rel=6e-6)


def test_more_nodes_change_nothing() -> None:
    assert elastica.hang(1e3, nodes=160).droop == pytest.approx(elastica.hang(1e3).droop, rel=1e-10)


def test_an_elastica_keeps_its_length() -> None:
    points = elastica.hang(30.0).points(np.linspace(0, 1, 4001))
    assert np.linalg.norm(np.diff(points, axis=0), axis=1).sum() == pytest.approx(1, abs=1e-6)
    np.testing.assert_allclose(points[0], 0, atol=1e-14)


def test_beam_frequencies() -> None:
    found = modes.beam(4).frequencies
    np.testing.assert_allclose(found[:3], [3.51602, 22.0345, 61.6972], rtol=2e-6)
    for value in found:  # cos β cosh β = −1
        root = math.sqrt(value)
        assert math.cos(root) * math.cosh(root) == pytest.approx(-1, abs=1e-6)


def test_chain_frequencies_are_half_the_zeros_of_bessels_function() -> None:
    found = modes.chain(3).frequencies
    np.testing.assert_allclose(found, [1.20241, 2.76004, 4.32687], rtol=3e-6)
    angle = (np.arange(4000) + 0.5) * np.pi / 4000
    for value in found:  # J₀(x) is the mean of cos(x sin θ)
        assert np.cos(2 * value * np.sin(angle)).mean() == pytest.approx(0, abs=1e-9)


def test_modes_are_orthonormal() -> None:
    places, weights = np.polynomial.legendre.leggauss(48)
    for made in (modes.beam(4), modes.chain(4)):
        shapes = made.shapes((places + 1) / 2)
        np.testing.assert_allclose(shapes.T @ (weights[:, None] / 2 * shapes), np.eye(4), atol=1e-9)


@pytest.mark.parametrize("name", REFERENCES)
def test_every_reference_says_what_it_needs(name: str) -> None:
    reference = REFERENCES[name]
    assert reference.name == name
    assert reference.needs
    case = reference.case(6)
    assert case.settings["emitter"]["strands"] == case.groom.strands
    np.testing.assert_allclose(np.linalg.norm(case.groom.directions, axis=1), 1, rtol=1e-6)
    assert all(np.isfinite(value) for value in reference.exact().values())


def still(strands: list[np.ndarray]) -> Track:
    """A run that ends in these strands (particles, 3)."""
    return Track(np.array([0.0]), np.array([strands]))


def level(shape: elastica.Shape, length: float, particles: int = 9) -> np.ndarray:
    out, down = shape.points(np.linspace(0, 1, particles)).T
    return length * np.stack([out, -down, 0 * out], 1)


def test_exact_shapes_have_no_error_and_moved_tips_have_theirs() -> None:
    strands = [level(shape, size) for shape, size in zip(elastica.shapes(), elastica.LENGTHS, strict=True)]
    assert all(error == pytest.approx(0, abs=1e-9) for error in elastica.measure(still(strands)).values())
    strands[1][-1, 2] += 0.03 * elastica.LENGTHS[1]
    assert elastica.measure(still(strands))["tip"] == pytest.approx(0.03)


@pytest.mark.parametrize("name", ["beam", "chain"])
def test_frequencies_are_read_off_a_motion_of_modes(name: str) -> None:
    axis, unit = (1, math.sqrt(modes.rigidity())) if name == "beam" else (0, math.sqrt(9.81))
    shapes = modes.beam() if name == "beam" else modes.chain()
    times = np.arange(0, 3, 1 / 480)
    places = np.linspace(0, 1, 60)
    motion = np.zeros((len(times), 1, 60, 3))
    for i, (omega, size, off, decay) in enumerate(
        zip(shapes.frequencies * unit, (1e-2, 1e-3, 1e-4), (1.02, 0.99, 1.03), (0.1, 0.2, 0.3), strict=True)
    ):
        swing = size * np.exp(-decay * times) * np.cos(off * omega * times)
        motion[:, 0, :, axis] += swing[:, None] * shapes.shapes(places)[:, i]
    errors = modes.errors(shapes, unit, Track(times, motion), axis)
    # the share of a slower mode that the trapezoidal rule leaves is fitted with it
    assert errors["frequency 1"] == pytest.approx(0.02, abs=1e-3)
    assert errors["frequency 2"] == pytest.approx(0.01, abs=2e-3)
    assert errors["frequency 3"] == pytest.approx(0.03, abs=5e-3)
    cycle = 2 * math.pi / (1.02 * shapes.frequencies[0] * unit)
    assert errors["loss"] == pytest.approx(1 - math.exp(-0.1 * cycle), rel=0.05)
    assert errors["swing"] == pytest.approx(math.hypot(0.02, 0.1 * 1.02 / (2 * math.pi) * cycle), abs=2e-3)


def test_a_motion_without_swing_has_no_frequency() -> None:
    times = np.arange(100) / 60
    assert modes.oscillation(times, np.zeros(100), 6.0) is None
    assert modes.oscillation(times[:4], np.cos(6 * times[:4]), 6.0) is None
    assert modes.oscillation(times, np.full(100, np.nan), 6.0) is None
    errors = REFERENCES["beam"].measure(Track(times, np.zeros((100, 1, 5, 3))))
    assert set(errors.values()) == {None}


def test_a_slender_coil_has_the_stiffness_of_the_textbooks(monkeypatch: pytest.MonkeyPatch) -> None:
    """G d⁴ / (8 n D³), its climb and its arm added; the wire's weight is nothing."""
    monkeypatch.setattr(spring, "MASS", 1e9)
    climb = math.atan(spring.CLIMB / (2 * math.pi))
    for arm in spring.ARM:
        turns = -spring.coil(arm)[-1, 1] / (spring.CLIMB * spring.R)
        d, g = 2e-3, 1.0
        slender = g * d**4 / (8 * turns * (2 * spring.R) ** 3)
        twisting = g * math.pi * d**4 / 32
        rigid = twisting / spring.TORSION
        length = 2 * math.pi * turns * spring.R / math.cos(climb)
        way = spring.R**2 * length * (math.cos(climb) ** 2 / twisting + math.sin(climb) ** 2 / rigid)
        way += spring.R**3 / (3 * rigid)
        # `bending` is chosen so that a slender coil stretches by `STRETCH` R
        assert spring.displacement(arm) / (spring.STRETCH * spring.R) == pytest.approx(way * slender, rel=1e-5)
        assert way * slender == pytest.approx(1, abs=0.03)


def test_corners_of_a_coil_are_equally_far_apart() -> None:
    for arm in spring.ARM:
        sides = np.linalg.norm(np.diff(spring.coil(arm), axis=0), axis=1)
        np.testing.assert_allclose(sides, spring.R / arm, rtol=1e-12)
        assert spring.arm_of(len(spring.coil(arm))) == arm


def measured(name: str, particles: int, dt: float) -> Point:
    return References(Request(name=name)).measure({"solver": "rod", "emitter.particles": particles, "dt": dt})


def test_level_rods_are_the_elastica_at_any_step() -> None:
    for dt in (1 / 24, 1 / 120):
        errors = measured("elastica", 10, dt).error
        for load, most in (("0.1", 0.015), ("1", 0.015), ("10", 0.025)):
            found = errors[f"H/W Γ={load}"]
            assert found <= most


def test_segments_are_of_second_order() -> None:
    counts = (6, 10, 19)
    errors = [measured("elastica", particles, 1 / 24).error["H/W Γ=1"] for particles in counts]
    assert fitted_order([1 / (particles - 1) for particles in counts], errors) >= 1.8


def test_hair_that_hangs_keeps_its_frequency_and_its_swing() -> None:
    found = measured("swing", 10, 1 / 120).error
    assert found["loss"] <= 1e-3  # a cycle keeps at least 99.9 %
    assert found["frequency 1"] <= 0.006
