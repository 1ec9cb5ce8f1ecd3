"""Combinations of what strands may be with the extremes of the matrix."""

from __future__ import annotations

from itertools import product
from typing import Any

import numpy as np
import pytest

from strandcli.errors import UsageError
from strandcli.simulate import solver_of
from strandcli.simulate.contact.forces import Forces
from strandcli.study.stress import covering, run, traits, verdicts
from strandcli.study.stress.task import Task

PINNED = {
    "dt": "60Hz", "B": "1", "gamma": "10", "wind": "calm", "emitter": "still", "contact": "none", "n": "10",
    "start": "straight", "root": "clamped", "torsion": "none", "between": "none",
    "rest": "straight", "end": "pinned",
}  # fmt: skip


def test_every_combination_of_traits_meets_every_pair_of_the_other_axes() -> None:
    found: dict[tuple[str, ...], set[tuple[tuple[str, str], tuple[str, str]]]] = {}
    for row in traits.combinations():
        met = found.setdefault(tuple(row[axis] for axis in traits.TRAITS), set())
        met |= set(covering.pairs_of({axis: row[axis] for axis in traits.OTHERS}))
    wanted = set(covering.all_pairs(traits.OTHERS))
    assert set(found) == set(product(*traits.TRAITS.values()))
    assert all(met == wanted for met in found.values())
    assert len(traits.table()) == len(list(traits.combinations())) > 1000


def test_scenes_are_what_their_labels_say() -> None:
    labels = PINNED | {"between": "thick", "rest": "shape", "torsion": "0.7", "start": "random"}
    scene, groom, case, times = traits.prepared(labels)
    assert [use.name for use in scene.rules if use.name == "contact"] == ["contact"]
    assert (scene.rod.end, scene.rod.rest, scene.rod.torsion) == ("pinned", "shape", 0.7)
    assert (scene.rod.young or 0) * (scene.rod.radius or 0) ** 2 / 4 == pytest.approx(1)
    assert len(groom.roots) == 4
    assert np.abs(groom.roots).max() <= traits.CLOSE
    assert (case.label("start"), len(times)) == ("random", 24)


def test_what_is_refused_by_name_counts_as_refused() -> None:
    labels, words = PINNED | {"rest": "sag_free", "root": "hinged"}, "hinged roots hold no strand up"
    assert words in traits.refusal(labels)
    with pytest.raises(traits.Refused, match=words):
        traits.check_traits("rod", labels=labels)
    name = next(name for name, check in traits.table().items() if traits.refusal(check.keywords["labels"]))  # type: ignore[attr-defined]
    (verdict,) = run.perform(Task("rod", named=name))
    assert (verdict.verdict, verdict.metrics) == ("pass", {"refused": 1.0})
    assert verdict.why


def test_the_small_matrix_has_pinned_tips_and_each_refusal() -> None:
    rows = [traits.table()[name].keywords["labels"] for name in traits.quick()]  # type: ignore[attr-defined]
    assert {traits.refusal(row) for row in rows} == {traits.refusal(row) for row in traits.combinations()}
    assert 5 < sum(row["end"] == "pinned" and not traits.refusal(row) for row in rows) < 30
    every = {name for one in run.tasks(["rod"], quick=True) for name in one.names}
    assert {f"rod/{name}" for name in traits.quick()} <= every


def test_what_should_be_refused_and_is_not_has_failed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(traits, "refusal", lambda labels: "no such words")
    assert verdicts.judge("rod", {}, traits.check_traits("rod", labels=PINNED)).failed == ("refused",)
    with pytest.raises(UsageError, match="hinged roots hold no strand up"):
        traits.check_traits("rod", labels=PINNED | {"rest": "sag_free", "root": "hinged"})


def test_pinned_tips_are_watched_and_so_is_energy(monkeypatch: pytest.MonkeyPatch) -> None:
    found = traits.check_traits("rod", labels=PINNED)
    assert found["pinned_off"] < 1e-5
    assert found["energy_gained"] < 1e-3
    assert verdicts.judge("rod", {}, found).verdict == "pass"
    monkeypatch.setattr("strandcli.simulate.rod.solver.HEAVY", 1.0)
    assert "pinned_off" in verdicts.judge("rod", {}, traits.check_traits("rod", labels=PINNED)).failed


def test_a_push_is_energy_gained(monkeypatch: pytest.MonkeyPatch) -> None:
    labels = PINNED | {"end": "free"}
    scene = traits.prepared(labels)[0]
    kind = solver_of(scene)
    step = kind.step

    def pushed(self: object, time: float, dt: float) -> None:
        self.state.velocity[...] += 1.0  # type: ignore[attr-defined]
        step(self, time, dt)  # type: ignore[arg-type]

    monkeypatch.setattr(kind, "step", pushed)
    assert "energy_gained" in verdicts.judge("rod", {}, traits.check_traits("rod", labels=labels)).failed


def test_forces_of_contact_that_no_step_can_carry_do_not_end_a_run(monkeypatch: pytest.MonkeyPatch) -> None:
    """Pinned strands of more segments, or between a ball and each other, are none to judge by: forces for which
    iterations still find lengths leave them speeds of 2.5 km/s, which then no step between two ends can carry."""
    labels = PINNED | {"dt": "noisy", "B": "1e-2", "emitter": "flip", "n": "2", "start": "random", "between": "thick"}
    found = traits.check_traits("rod", labels=labels)
    assert verdicts.judge("rod", {}, found).verdict == "pass"
    assert found["closeness"] < 1
    solve = Forces.solve

    def wild(self: Forces, found: Any, forces: Any, solver: Any) -> float:
        moved = solve(self, found, forces, solver)
        forces *= 1e14
        return moved

    monkeypatch.setattr(Forces, "solve", wild)
    assert "stopped" not in verdicts.judge("rod", {}, traits.check_traits("rod", labels=labels)).failed
    monkeypatch.setattr("strandcli.simulate.contact.between_strands.RESIDUAL_MOST", np.inf)
    assert "stopped" in verdicts.judge("rod", {}, traits.check_traits("rod", labels=labels)).failed
