"""Front, orders, limits and recommendations: pure functions of numbers."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from strandcli.study.motion import apart, resample
from strandcli.study.points import Point, cheapest, fitted_order, limit, orders, pareto

COSTS = st.floats(1e-6, 1e3)
ERRORS = st.one_of(st.none(), st.floats(0, 10), st.just(float("nan")))
PAIRS = st.lists(st.tuples(COSTS, ERRORS), max_size=30)


def beats(a: tuple[float, float], b: tuple[float, float]) -> bool:
    return a[0] <= b[0] and a[1] <= b[1] and a != b


@given(PAIRS)
def test_the_front_is_what_nothing_beats(pairs: list[tuple[float, float | None]]) -> None:
    front = pareto([cost for cost, _ in pairs], [error for _, error in pairs])
    known = [(cost, error) for cost, error in pairs if error is not None and math.isfinite(error)]
    for (cost, error), on_front in zip(pairs, front, strict=True):
        usable = error is not None and math.isfinite(error)
        assert on_front == (usable and not any(beats(other, (cost, error)) for other in known))  # type: ignore[arg-type]
    assert any(front) == bool(known)


@given(PAIRS, st.floats(0, 10))
def test_the_cheapest_is_on_the_front(pairs: list[tuple[float, float | None]], most: float) -> None:
    points = [Point({}, cost, {"e": None if error is None or math.isnan(error) else error}) for cost, error in pairs]
    found = cheapest(points, "e", most)
    fit = [point for point in points if point.error["e"] is not None and point.error["e"] <= most]
    assert (found is None) == (not fit)
    if found is not None:
        assert found.seconds == min(point.seconds for point in fit)


def test_the_margin_of_a_solver_counts() -> None:
    sharp, vague = Point({}, 2.0, {"e": 0.008}, "a"), Point({}, 1.0, {"e": 0.005}, "b")
    assert cheapest([sharp, vague], "e", 0.01) is vague
    assert cheapest([sharp, vague], "e", 0.01, {"b": 0.006}) is sharp
    assert cheapest([sharp, vague], "e", 0.01, {"a": 0.003, "b": math.inf}) is None


@given(st.floats(0.5, 4), st.floats(1e-3, 10), st.integers(2, 6))
def test_powers_are_found(power: float, size: float, count: int) -> None:
    steps = [2.0**-i for i in range(count)]
    found = fitted_order(steps, [size * step**power for step in steps])
    # powers are tried in steps of 1/200; the next greater one, with a floor, may fit better than the next smaller one,
    # whose floor would have to be negative
    assert found == pytest.approx(power, abs=0.0051)


def test_a_floor_of_another_making_is_left_out() -> None:
    steps = [2.0**-i for i in range(8)]
    errors = [step**2 + 1e-3 for step in steps]
    assert fitted_order(steps, errors) == pytest.approx(2, abs=0.01)
    assert fitted_order(steps, [1e-3] * 8) is None
    assert fitted_order(steps, [1e-3 / step for step in steps]) is None
    assert fitted_order([1.0], [1.0]) is None
    assert fitted_order([0.1, *steps], [0.0, *[step**2 for step in steps]]) == pytest.approx(2, abs=0.01)
    rounding = [*[step**2 for step in steps[:6]], 2e-3, 4e-3]
    assert fitted_order(steps, rounding) == pytest.approx(2, abs=0.01)
    assert fitted_order([1.0, 0.5], [0.0, 0.0]) is None


def made(solver: str, particles: int, dt: float, error: float | None, **parameters: object) -> Point:
    sizes = {"dt": dt, "segment": 1 / (particles - 1)}
    settings = {"solver": solver, "emitter.particles": particles, "dt": dt, **parameters}
    return Point(settings, 1 / dt, {"e": error}, solver, sizes)


def test_orders_are_fitted_with_all_else_at_its_best() -> None:
    points = [
        made("rod", n, dt, 1e3 * dt + (20 / (n - 1)) ** 2, **{"rod.iterations": its})
        for n in (5, 9, 17)
        for dt in (4e-3, 2e-3, 1e-3)
        for its in (2, 8)
    ]
    points += [made("thesis", 5, 1e-3, None)]
    found = {(one["line"], one["in"]): one["order"] for one in orders(points, "e")}
    assert set(found) == {("rod", "dt"), ("rod", "segment")}
    pure = [made("rod", 9, dt, 3 * dt**1.5) for dt in (4e-3, 2e-3, 1e-3)]
    (only,) = orders(pure, "e")
    assert (only["in"], only["points"]) == ("dt", 3)
    assert only["order"] == pytest.approx(1.5)


@given(st.floats(0.6, 2.0), st.floats(1e-6, 1))
def test_the_distance_to_the_limit_is_covered(power: float, size: float) -> None:
    """Runs each twice as fine as the one before, whose distance from the limit is size · h ** power."""
    at = [size * h**power for h in (4, 2, 1)]
    known = limit(at[0] - at[1], at[1] - at[2])
    assert known.converges
    assert known.order == pytest.approx(power)
    assert known.uncertainty == pytest.approx(1.25 * at[2])


def test_runs_that_do_not_draw_together_have_no_limit() -> None:
    assert not limit(0.1, 0.2).converges
    assert not limit(0.1, 0.1).converges
    assert limit(0.1, 0.1).uncertainty > 0.3
    assert limit(0.0, 0.1).order is None
    assert limit(0.3, 0.0) == limit(0.0, 0.0)
    assert limit(0.0, 0.0).uncertainty == 0
    assert limit(1e-8, 1e-7, noise=1e-6).converges
    assert not limit(math.inf, math.inf).converges


@given(st.integers(2, 12), st.integers(2, 40), st.integers(0, 2**32 - 1))
def test_resampled_points_lie_on_the_strand_at_even_shares(particles: int, places: int, seed: int) -> None:
    strand = np.random.default_rng(seed).normal(size=(particles, 3))
    found = resample(strand, places)
    np.testing.assert_allclose(found[[0, -1]], strand[[0, -1]], atol=1e-12)
    sizes = np.linalg.norm(np.diff(strand, axis=0), axis=1)
    along = np.append(0, np.cumsum(sizes))
    for share, point in zip(np.linspace(0, 1, places), found, strict=True):
        exact = [np.interp(share * along[-1], along, strand[:, c]) for c in range(3)]
        np.testing.assert_allclose(point, exact, atol=1e-9)


def test_resampling_does_not_ask_how_particles_are_spread() -> None:
    coarse = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0]], float)
    fine = np.array([[0, 0, 0], [0.1, 0, 0], [1, 0, 0], [1, 0.3, 0], [1, 0.31, 0], [1, 1, 0]])
    np.testing.assert_allclose(resample(coarse, 9), resample(fine, 9), atol=1e-12)
    np.testing.assert_array_equal(resample(np.ones((3, 3)), 5), np.ones((5, 3)))
    assert resample(np.zeros((2, 4, 7, 3)), 5).shape == (2, 4, 5, 3)


def test_distances_are_shares_of_each_strand() -> None:
    a, b = np.zeros((2, 3, 4, 3)), np.zeros((2, 3, 4, 3))
    b[:, 2, :, 0] = 1.0
    found = apart(a, b, np.array([1.0, 1.0, 4.0]))
    assert found["median"] == 0
    assert found["max"] == pytest.approx(0.25)
    assert found["rms"] == pytest.approx(0.25 / math.sqrt(3))
    b[:, 1:] += [0, 1, 0]
    assert apart(a, b, np.ones(3))["median"] == pytest.approx(1)
