"""The matrix with strands that interact and twist in every case."""

from __future__ import annotations

import json
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cli_runs import Runner
from strandcli.errors import UsageError
from strandcli.scene.checks_of_rod import rod_clashes
from strandcli.simulate import solver_of
from strandcli.simulate.rod.solver import RodSolver
from strandcli.study.stress import run, sheets, together
from strandcli.study.stress.axes import AXES, Case
from strandcli.study.stress.task import Task

TOO_FINE = "rod/dt=0.5/n=1/L=1e-6/offset=1e6/tip=1e6/start=random/between=grid-fine/twist=coil/root=hinged"


@pytest.fixture(scope="module")
def matrix() -> list[Task]:
    return run.tasks(["rod"], kinds=together.KINDS)


def test_every_scene_of_the_matrix_is_there_with_both_on_and_none_twice(matrix: list[Task]) -> None:
    names = {name for task in matrix for name in task.names}
    assert len(names) == len(matrix) >= 60_000
    assert {task.cases[0] for task in matrix} >= set(sheets.full("rod"))
    assert all("none" not in task.labels[:2] for task in matrix)


def test_cells_that_numbers_are_too_coarse_for_have_no_negative_weights() -> None:
    """Cells of 5e-8 m, a metre from the origin: what the grid takes beside itself there, since it begins inside others,
    lay outside of the box, with weights below 0, and was thrown by 1e24 m/s²."""
    (found,) = run.perform(run.named(TOO_FINE))
    assert found.verdict == "pass", found.why
    assert found.metrics["residual"] < 1e-3


def test_every_value_of_an_axis_meets_every_value_of_strands_together(matrix: list[Task]) -> None:
    met = {
        (place, label, axis, own)
        for task in matrix
        for place, label in enumerate(task.cases[0].labels)
        for axis, own in enumerate(task.labels)
        if not together.BETWEEN[task.labels[0]].get("contact")
    }
    touching = {label for label, rules in together.BETWEEN.items() if "contact" in rules}
    for place in range(len(AXES)):
        labels = {task.cases[0].labels[place] for task in matrix}
        for axis, own in enumerate(together.OWN.values()):
            wanted = [one for one in own if one not in touching and not (axis < 2 and one == "none")]
            for label, one in product(labels, wanted):
                bent = list(AXES)[place] == "start" and label == "coincident"
                if not (bent and one in ("coil", "hinged")):  # what is no coil hangs, which asks for a clamped root
                    assert (place, label, axis, one) in met


def test_contact_is_tried_with_every_value_of_the_axes(matrix: list[Task]) -> None:
    mine = [task for task in matrix if "contact" in together.BETWEEN[task.labels[0]]]
    for axis in AXES:
        found, labels = ({task.cases[0].label(axis) for task in some} for some in (mine, matrix))
        missing = {"offset": {"1e6"}, "strands": {"129", "700"}, "n": {"32", "100", "1000"}}.get(axis, set())
        assert found == labels - missing
    for axis, place in (("between", 0), ("twist", 1)):
        assert len({task.labels[place] for task in mine}) >= (3 if axis == "between" else 2)


def test_no_combination_is_one_that_the_product_refuses() -> None:
    case = Case.of("rod", {"start": "random", "n": "3"})
    for row in (*together.rows(together.KINDS, False), *together.rows(together.KINDS, True)):
        scene, groom, _ = together.prepared(case, row)
        assert list(rod_clashes(scene)) == []
        assert len(groom.lengths) == int(together.STRANDS)
    refused = [row for row in product(*together.OWN.values()) if not together.valid(row)]
    for row in refused:
        assert list(rod_clashes(together.prepared(case, row)[0]))


@pytest.mark.parametrize("start", AXES["start"])
@pytest.mark.parametrize("n", ["1", "10"])
def test_strands_do_interact_and_twist(start: str, n: str) -> None:
    case = Case.of("rod", {"start": start, "n": n})
    met = [*together.met_by(case, together.KINDS, False, 20), *together.met_by(case, together.KINDS, True, 20)]
    for row in met:
        scene, groom, _ = together.prepared(case, row)
        one: Any = solver_of(scene)(scene, groom)
        assert one.curled
        assert one.grid is not None or one.contact is not None


def test_lengths_scale_with_strands() -> None:
    row = ("grid-thin", "coil", "free", "clamped", "none")
    for L in ("1e-6", "1e6"):
        scene, groom, _ = together.prepared(Case.of("rod", {"L": L}), row)
        given = {use.name: use.parameters for use in scene.rules}
        assert given["contact"].thickness == pytest.approx(0.005 * float(L))
        assert given["interaction"].cell == pytest.approx(0.2 * float(L))
        assert (scene.rod.young or 0) * (scene.rod.radius or 0) ** 2 / 4 == pytest.approx(float(L) ** 4)
        assert len(groom.roots) == 4


def test_coils_turn_by_the_same_angle_at_every_joint() -> None:
    edges = together.coil(np.tile([1.0, 0.0, 0.0], (2, 5, 1)))
    np.testing.assert_allclose(np.linalg.norm(edges, axis=2), 1)
    bends = np.linalg.norm(np.diff(edges, axis=1), axis=2)
    np.testing.assert_allclose(bends, bends[0, 0])
    assert bends[0, 0] > 0.3


def test_names_lead_back_to_their_cases(matrix: list[Task]) -> None:
    for task in matrix[::501]:
        assert run.named(task.names[0]) == task
    for name, words in (
        ("rod/between=thni/twist=coil", "between has no value 'thni'; it has none, grid"),
        ("rod/twist=sag-free/root=hinged", "the product refuses such strands"),
        ("thesis/between=grid/twist=coil", "the product refuses such strands"),
        ("rod/dt=7/between=grid", "dt has no value"),
    ):
        with pytest.raises(UsageError, match=words):
            run.named(name)


NAME = "rod/B=1e-2/start=random/between=grid/twist=coil"


def test_a_solver_that_leaves_nan_or_raises_fails_its_case(monkeypatch: pytest.MonkeyPatch) -> None:
    (good,) = run.perform(run.named(NAME))
    assert (good.verdict, good.name) == ("pass", NAME)
    assert good.metrics.keys() >= {"nonfinite", "stretch", "residual", "stopped", "moved_by_nothing"}
    assert good.parameters["twist"] == "coil"
    step = RodSolver.step

    def spoil(self: RodSolver, time: float, dt: float) -> None:
        step(self, time, dt)
        if dt > 0:
            self.positions[0, 3, 1] = np.nan

    monkeypatch.setattr(RodSolver, "step", spoil)
    (bad,) = run.perform(run.named(NAME))
    assert bad.verdict == "fail"
    assert "nonfinite" in bad.failed

    def explode(self: RodSolver, time: float, dt: float) -> None:
        raise ZeroDivisionError("bug")

    monkeypatch.setattr(RodSolver, "step", explode)
    assert run.perform(run.named(NAME))[0].why == "ZeroDivisionError: bug"


@pytest.mark.parametrize(
    "name",
    [
        "rod/gamma=0/emitter=teleport/start=coincident/between=grid-fine/twist=sag-free/end=pinned/torsion=0.7",
        "rod/dt=1e-4/B=1e-6/wind=gale/emitter=teleport/start=coincident/between=grid-fine/twist=sag-free/end=pinned",
        "rod/dt=1e-4/gamma=1e4/emitter=flip/start=coincident/between=grid-fine/twist=sag-free/end=pinned",
        "rod/dt=1e-4/gamma=7.7/emitter=shake/between=grid-coarse/twist=coil/end=pinned/root=hinged/torsion=0.7",
    ],
)
def test_taut_strands_with_pinned_tips_stay_so_a_hundred_lengths_away(name: str) -> None:
    """Positions are rounded more there, which tips had no way to go by."""
    (found,) = run.perform(run.named(name))
    assert (found.verdict, found.why) == ("pass", "")


@pytest.fixture
def command(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Runner:
    monkeypatch.chdir(tmp_path)
    return Runner(tmp_path, capsys)


def test_the_command_runs_and_lists_them(command: Runner) -> None:
    listed = command("stress", "--with", "twist,interaction", "--quick", "--list").out.split()
    assert (
        listed == command("stress", "--with", "interaction,twist", "--quick", "--list", "--solver", "rod").out.split()
    )
    assert len(listed) > 60
    assert any("between=thi" in name for name in listed)
    some = ("--filter", "contact=through emitter=flip between=grid")
    result = command("stress", "--with", "interaction,twist", "--quick", *some, "--json", "--no-progress")
    assert result.code == 0, result.err
    data = json.loads(result.out)
    summary = data["summary"]
    assert summary["pass"] + summary["expected_failure"] == len(data["cases"]) > 1
    assert summary["expected_failure"] <= 1
    assert command("stress", "--case", data["cases"][0]["name"], "--json").out.count("between") > 0
    only = command("stress", "--with", "twist", "--quick", "--list").out.split()
    assert all("twist=" in name and "between=" not in name for name in only)
    assert "choose interaction, twist, or both" in command("stress", "--with", "twst").error()
    for more in (("--solver", "thesis"), ("--case", "rod"), ("hair",)):
        assert command("stress", "--with", "twist", *more).code == 2
