"""What follows from the numbers of a study: front, orders, limits, recommendations; its chart, CSV and table."""

from __future__ import annotations

import csv
import io
import math
import xml.etree.ElementTree as xml

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from strandcli.study.chart import Scale, chart, styles_of
from strandcli.study.motion import apart, resample
from strandcli.study.points import Point, cheapest, fitted_order, limit, orders, pareto
from strandcli.study.report import order_words, step, to_csv, to_text
from study_kit import made

COSTS = st.floats(1e-6, 1e3)
ERRORS = st.one_of(st.none(), st.floats(0, 10), st.just(float("nan")))
PAIRS = st.lists(st.tuples(COSTS, ERRORS), max_size=30)


@given(PAIRS)
def test_the_front_is_what_nothing_beats(pairs: list[tuple[float, float | None]]) -> None:
    front = pareto([cost for cost, _ in pairs], [error for _, error in pairs])
    known = [(cost, error) for cost, error in pairs if error is not None and math.isfinite(error)]
    for (cost, error), on_front in zip(pairs, front, strict=True):
        usable = error is not None and math.isfinite(error)
        beaten = any(a <= cost and b <= error and (a, b) != (cost, error) for a, b in known) if usable else True
        assert on_front == (not beaten)
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


def measured(solver: str, particles: int, dt: float, error: float | None, **parameters: object) -> Point:
    sizes = {"dt": dt, "segment": 1 / (particles - 1)}
    settings = {"solver": solver, "emitter.particles": particles, "dt": dt, **parameters}
    return Point(settings, 1 / dt, {"e": error}, solver, sizes)


def test_orders_are_fitted_with_all_else_at_its_best() -> None:
    points = [
        measured("rod", n, dt, 1e3 * dt + (20 / (n - 1)) ** 2, **{"rod.iterations": its})
        for n in (5, 9, 17)
        for dt in (4e-3, 2e-3, 1e-3)
        for its in (2, 8)
    ]
    points += [measured("thesis", 5, 1e-3, None)]
    found = {(one["line"], one["in"]): one["order"] for one in orders(points, "e")}
    assert set(found) == {("rod", "dt"), ("rod", "segment")}
    pure = [measured("rod", 9, dt, 3 * dt**1.5) for dt in (4e-3, 2e-3, 1e-3)]
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


def test_csv_holds_all_points() -> None:
    study = made()
    rows = list(csv.DictReader(io.StringIO(to_csv(study))))
    assert len(rows) == 32
    for row, point in zip(rows, study.points, strict=True):
        assert (row["solver"], float(row["dt"])) == (point.solver, point.sizes["dt"])
        assert float(row["tip"]) == point.error["tip"]
        assert row["other"] == ""
        assert row["pareto"] == str(int(point.pareto))


def test_the_table_says_what_there_is_to_say() -> None:
    text = to_text(made(0.1))
    assert "thesis: not represented: inertia" in text
    assert "order 2.00 in Δt" in text
    assert "under 10 %: solver=one" in text
    assert sum(line.startswith("*") for line in text.splitlines()) == sum(point.pareto for point in made().points) + 1


SPACE = "{http://www.w3.org/2000/svg}"


def test_the_chart_shows_every_point_front_and_wish() -> None:
    study = made(0.1)
    root = xml.fromstring(chart(study, 0.1))
    texts = [element.text for element in root.iter(f"{SPACE}text")]
    assert {"a made-up solver", "run time", "asked for: 10 %", "one", "two", "thesis: not represented"} <= set(texts)
    rings = [circle for circle in root.iter(f"{SPACE}circle") if circle.get("r") == "9"]
    assert len(rings) == sum(point.pareto for point in study.points)
    stars = [one for one in root.iter(f"{SPACE}polygon") if one.get("fill") == "#f2b705"]
    assert len(stars) == len(study.recommended)


def test_no_two_lines_of_a_chart_look_the_same() -> None:
    names = ["thesis", "rod", *"abcdefghijkl"]
    styles = styles_of([Point({}, 1.0, {}, name) for name in names])
    assert list(styles) == names
    assert len(set(styles.values())) == len(names)


def test_a_chart_without_a_point_says_so() -> None:
    study = made()
    study.points = []
    assert "no run has an error to be shown" in chart(study)
    study.title = "a < b & c"
    assert "a &lt; b &amp; c" in chart(study)


def test_labels_cover_neither_points_nor_each_other() -> None:
    root = xml.fromstring(chart(made(0.1), 0.1))
    boxes = []
    for one in root.iter(f"{SPACE}text"):
        if one.get("font-size") == "11.5":
            wide = 5.8 * len(one.text or "")
            x, y = float(one.get("x", 0)), float(one.get("y", 0))
            left = x - (wide if one.get("text-anchor") == "end" else 0)
            boxes.append((left, y - 7, left + wide, y + 7))
    assert boxes
    for i, a in enumerate(boxes):
        for b in boxes[:i]:
            assert not (a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3])


def test_scales_are_logarithmic() -> None:
    scale = Scale([0.01, 1.0], 100.0, 500.0)
    assert scale(0.1) == pytest.approx(300)
    assert scale(1.0) - scale(0.1) == pytest.approx(scale(0.1) - scale(0.01))
    labelled = [value for value, has_label in scale.ticks() if has_label]
    assert labelled == pytest.approx([0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1])
    one = Scale([3.0], 0.0, 1.0)
    assert one(3.0) == pytest.approx(0.5)


def test_words_of_the_chart() -> None:
    assert [step(dt) for dt in (1 / 240, 0.5, 1.0, 0.3)] == ["1/240 s", "1/2 s", "1 s", "0.3 s"]
    assert order_words([{"line": "a", "metric": "e", "in": "dt", "order": None}], "a", "e") == ["no order seen in Δt"]
