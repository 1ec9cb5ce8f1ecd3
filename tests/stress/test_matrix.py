"""The stability matrix: its axes, the names of cases, pairs, and the scenes that they stand for."""

from __future__ import annotations

from itertools import product
from typing import Any

import numpy as np
import pytest

from strandcli.errors import UsageError
from strandcli.scene.checks import findings
from strandcli.simulate import solver_of
from strandcli.study.stress import matrix, run, scenes
from strandcli.study.stress.matrix import AXES, DEFAULTS, GROUPED, Case, case_named, refusal


@pytest.mark.parametrize(
    "axes",
    [
        {"a": "xy", "b": "xyz", "c": "pq"},
        {"a": "x", "b": "yz"},
        {name: tuple(labels) for name, labels in AXES.items()},
    ],
)
def test_every_pair_is_covered(axes: dict[str, Any]) -> None:
    rows = matrix.covering(axes)
    met = set().union(*(matrix.pairs_of(row) for row in rows))
    assert met == set(matrix.all_pairs(axes))
    sizes = sorted((len(labels) for labels in axes.values()), reverse=True)
    assert sizes[0] * sizes[1] <= len(rows) < 2 * sizes[0] * sizes[1]


def test_a_name_leads_back_to_its_case() -> None:
    for case in (*matrix.quick("rod"), *matrix.pairs("thesis"), *matrix.grooms("rod"), *matrix.groups()):
        assert case_named(case.name) == case
        assert case in run.named(case.name)
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
        ("rod/between=thni/twist=coil", "between has no value 'thni'; it has none, grid"),
        ("rod/twist=sag-free/root=hinged", "hinged roots hold no strand up"),
        ("thesis/between=grid", "axes of the solver rod"),
    ],
)
def test_a_name_that_is_none_is_refused_with_the_part_that_is_wrong(name: str, words: str) -> None:
    with pytest.raises(UsageError, match=words):
        run.named(name)


def test_the_matrix_has_the_axes_of_its_design() -> None:
    for solver in ("rod", "thesis"):
        cases = matrix.full(solver)
        assert len(cases) == len(set(cases))
        assert 18_000 < len(cases) < 22_000
        for axes in matrix.SHEETS.values():
            wanted = {axis: taken or tuple(AXES[axis]) for axis, taken in axes.items()}
            free = [axis for axis in AXES if axis not in axes]
            found = [case for case in cases if all(case.label(axis) == DEFAULTS[axis] for axis in free)]
            rows = {tuple(case.label(axis) for axis in wanted) for case in found}
            assert rows >= set(product(*wanted.values()))
        alone = [case.parameters for case in cases if case.label("strands") == "1" and case.label("lengths") == "equal"]
        axes = (*matrix.ALONE, "start")
        met = set().union(*(matrix.pairs_of({axis: row[axis] for axis in axes}) for row in alone))
        assert met >= set(matrix.all_pairs({axis: tuple(AXES[axis]) for axis in axes}))


def test_batches_are_cases_that_differ_in_their_start_alone() -> None:
    batches = matrix.batches(matrix.full("rod"))
    assert sum(map(len, batches)) == len(matrix.full("rod"))
    for batch in batches:
        assert len({case.with_labels(start="straight") for case in batch}) == 1
        assert len(batch) <= len(AXES["start"])
        assert len(batch) == 1 or scenes.strands_of(batch[0]) == 1


def test_every_combination_of_what_rods_do_together_meets_every_pair_of_other_axes() -> None:
    beside = {axis: taken or tuple(AXES[axis]) for axis, taken in matrix.BESIDE.items()}
    met: dict[tuple[str, ...], set[matrix.Pair]] = {}
    for case in matrix.groups():
        key = case.label("between"), case.label("twist"), case.label("end")
        met.setdefault(key, set()).update(matrix.pairs_of({axis: case.label(axis) for axis in beside}))
    assert set(met) == set(product(*(tuple(AXES[axis]) for axis in ("between", "twist", "end"))))
    wanted = set(matrix.all_pairs(beside))
    assert all(found == wanted for (_, twist, _), found in met.items() if twist != "sag-free")


def test_no_case_is_one_that_presets_are_refused_for() -> None:
    for row in product(*(tuple(AXES[axis]) for axis in GROUPED)):
        case = Case.of("rod", {"start": "random", "n": "3", **dict(zip(GROUPED, row, strict=True))})
        assert bool(list(findings(scenes.scene_of(case, scenes.times_of(case))))) == bool(refusal(case))


@pytest.mark.parametrize("start", AXES["start"])
@pytest.mark.parametrize("n", ["1", "10"])
def test_strands_interact_and_twist_where_a_case_says_so(start: str, n: str) -> None:
    cases = [case for case in matrix.groups() if "none" not in (case.label("between"), case.label("twist"))]
    assert {case.label("between") for case in cases} == set(AXES["between"]) - {"none"}
    for case in [one for one in cases if (one.label("start"), one.label("n")) == (start, n)][:20]:
        scene = scenes.scene_of(case, scenes.times_of(case))
        solver: Any = solver_of(scene)(scene, scenes.groom_of([case]))
        bendless = start == "coincident" or (start, n) == ("zero", "1")  # of which no coil can be made
        assert solver.curled or (bendless and case.label("twist") == "coil")
        assert solver.grid is not None or solver.contact is not None


def test_lengths_scale_with_strands() -> None:
    for L in ("1e-6", "1e6"):
        case = Case.of("rod", {"L": L, "between": "grid-thin", "twist": "coil"})
        scene = scenes.scene_of(case, scenes.times_of(case))
        given = {use.name: use.parameters for use in scene.rules}
        assert given["contact"].thickness == pytest.approx(0.005 * float(L))
        assert type(given["contact"].iterations) is int  # a count has no length
        assert given["interaction"].cell == pytest.approx(0.2 * float(L))
        assert (scene.rod.young or 0) * (scene.rod.radius or 0) ** 2 / 4 == pytest.approx(float(L) ** 4)
        assert len(scenes.groom_of([case]).roots) == scene.emitter.strands == 4


def test_coils_turn_by_the_same_angle_at_every_joint() -> None:
    edges = scenes.coil(np.tile([1.0, 0.0, 0.0], (2, 5, 1)))
    np.testing.assert_allclose(np.linalg.norm(edges, axis=2), 1)
    bends = np.linalg.norm(np.diff(edges, axis=1), axis=2)
    np.testing.assert_allclose(bends, bends[0, 0])
    assert bends[0, 0] > 0.3


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
    starts = [Case.of("rod", {"start": start}) for start in AXES["start"]]
    edges = scenes.groom_of(starts).edges
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
