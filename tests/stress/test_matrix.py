"""The stability matrix: its axes, the names of cases, pairs, and the scenes that they stand for."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from strandcli.errors import UsageError
from strandcli.study.stress import covering, run, scenes, sheets
from strandcli.study.stress.axes import AXES, DEFAULTS, Case, case_named


@pytest.mark.parametrize(
    "axes",
    [
        {"a": "xy", "b": "xyz", "c": "pq"},
        {"a": "x", "b": "yz"},
        {name: tuple(labels) for name, labels in AXES.items()},
    ],
)
def test_every_pair_is_covered(axes: dict[str, Any]) -> None:
    rows = covering.covering(axes)
    met = set().union(*(covering.pairs_of(row) for row in rows))
    assert met == set(covering.all_pairs(axes))
    sizes = sorted((len(labels) for labels in axes.values()), reverse=True)
    assert sizes[0] * sizes[1] <= len(rows) < 2 * sizes[0] * sizes[1]


def test_one_axis_alone_takes_each_of_its_values() -> None:
    assert covering.covering({"a": "xyz"}) == [{"a": "x"}, {"a": "y"}, {"a": "z"}]


def test_a_name_leads_back_to_its_case() -> None:
    for case in sheets.quick("rod") + list(sheets.pairs("thesis")) + list(sheets.grooms("rod")):
        assert case_named(case.name) == case
    assert Case.of("rod").name == "rod"
    assert case_named("rod/start=folded/dt=0.5").name == "rod/dt=0.5/start=folded"
    assert case_named("thesis").parameters == DEFAULTS


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("rood/dt=10", "did you mean 'rod'"),
        ("rod/gama=10", "did you mean 'gamma'"),
        ("rod/dt=0.6", "dt has no value '0.6'; it has 1e-4, 240Hz"),
        ("rod/dt=10/dt=0.5", "gives dt twice"),
        ("rod/check=twirl", "did you mean 'check=twist'"),
        ("rood/check=twist", "did you mean 'rod'"),
    ],
)
def test_a_name_that_is_none_is_refused_with_the_part_that_is_wrong(name: str, words: str) -> None:
    with pytest.raises(UsageError, match=words):
        run.named(name)


def test_the_matrix_has_the_axes_of_its_design_in_full_where_they_move_one_strand() -> None:
    cases = sheets.full("rod")
    assert len(cases) == len(set(cases)) > 20_000
    for axes in sheets.SHEETS.values():
        free = [axis for axis in AXES if axis not in axes]
        short = [case for case in cases if all(case.label(axis) == DEFAULTS[axis] for axis in free)]
        found = {tuple(case.label(axis) for axis in axes) for case in short}
        most = [len(sheets.SHORT if axis == "n" else AXES[axis]) for axis in axes]
        assert len({row for row in found if "n" not in axes or row[axes.index("n")] in sheets.SHORT}) == np.prod(most)
    alone = [case.parameters for case in cases if case.label("strands") == "1" and case.label("lengths") == "equal"]
    met = set().union(*(covering.pairs_of({axis: row[axis] for axis in (*sheets.ALONE, "start")}) for row in alone))
    assert met >= set(covering.all_pairs({axis: tuple(AXES[axis]) for axis in (*sheets.ALONE, "start")}))


def test_batches_are_cases_that_differ_in_their_start_alone() -> None:
    batches = sheets.batches(sheets.full("thesis"))
    assert sum(map(len, batches)) == len(sheets.full("thesis"))
    for batch in batches:
        assert len({case.labels[:-1] for case in batch}) == 1
        assert len(batch) <= len(AXES["start"])


def test_scenes_are_what_their_names_say() -> None:
    case = case_named("rod/B=1e2/gamma=7.9/L=1e6/tip=1e-6/emitter=teleport/offset=1e6")
    times = scenes.times_of(case)
    scene = scenes.scene_of(case, times)
    assert scene.rod.young * scene.rod.radius**2 / (4 * scene.rod.density) == pytest.approx(1e2 * 1e24)
    pull = next(use.parameters for use in scene.rules if use.name == "gravity").acceleration
    assert -pull[1] * 1e18 / (1e2 * 1e24) == pytest.approx(7.9)  # Γ = g L³ / (B / ρ A)
    assert scene.rod.tip == pytest.approx(1e-3)
    assert scene.emitter.keys[0].position == (1e12, 0, 0)
    assert scene.emitter.keys[1].position == (1e12, 0, 1e8)
    steps = np.diff(scenes.times_of(case_named("rod/dt=noisy")), prepend=0)
    assert 0.5 / 60 <= steps.min() < 0.7 / 60
    assert 1.3 / 60 < steps.max() <= 1.5 / 60
    starts = [Case(case.solver, (*Case.of("rod").labels[:-1], start)) for start in AXES["start"]]
    edges = scenes.groom_of(starts).edges
    assert edges is not None
    sizes = np.linalg.norm(edges, axis=2)
    assert (sizes[0] == 1).all()
    assert (sizes[1] == 0).sum() == 1
    assert (sizes[2] == 0).all()
    assert (edges[3, ::2, 0] == 1).all()
    assert (edges[3, 1::2, 0] == -1).all()
    np.testing.assert_allclose(sizes[4], 1)


def test_a_moving_ball_goes_through_the_strand() -> None:
    case = case_named("rod/contact=moving")
    (ball,) = scenes.scene_of(case, scenes.times_of(case)).solids
    assert ball.keys[0].position[1] > 0 > ball.keys[1].position[1]
