"""Thin strands that are thrown at each other: what tells that one has passed through another."""

from __future__ import annotations

import numpy as np
import pytest

from strandcli.simulate.contact.between_strands import StrandContact
from strandcli.study.stress import checks, run, tunnelling, verdicts
from strandcli.study.stress.crossing import linking, passed

FAST = {
    "speed": "200", "dt": "24Hz", "thickness": "0.2mm", "n": "10", "friction": "0.3",
    "young": "1e6", "twist": "none",
}  # fmt: skip


def line(*points: tuple[float, float, float]) -> np.ndarray:
    return np.array(points, float)


def test_segments_that_pass_are_counted() -> None:
    low = line((-1, 0, 0), (0.1, 0, 0), (1, 0, 0))
    high, below = (line((0, y, -1), (0, y, 0.1), (0, y, 1)) for y in (0.5, -0.5))
    assert passed(np.stack([low, high]), np.stack([low, below])) == 1
    assert passed(np.stack([low, high]), np.stack([low, high])) == 0
    aside = high + np.array((3, 0, 0))
    assert passed(np.stack([low, aside]), np.stack([low, aside - (0, 1, 0)])) == 0
    beside = low + np.array((0, 0, 0.01))  # in one plane and never near
    assert passed(np.stack([low, beside]), np.stack([low, beside + np.array((0, 1e-9, 0))])) == 0
    there_and_back = np.stack([low, high]), np.stack([low, below])
    assert passed(*there_and_back) + passed(*there_and_back[::-1]) == 2


def test_linking_numbers_are_whole_and_change_by_one() -> None:
    t = np.linspace(0, 2 * np.pi, 20, endpoint=False)
    ring = np.stack([np.cos(t), np.sin(t), 0 * t], 1)
    other = np.stack([1 + np.cos(t + 0.1), 0 * t + 0.03, np.sin(t + 0.1)], 1)
    assert abs(linking(ring, other)) == pytest.approx(1)
    assert linking(ring, other + np.array((4, 0, 0))) == pytest.approx(0, abs=1e-9)
    twice = np.stack([1 + 0.5 * np.cos(2 * t), 0.1 * np.cos(t) + 0.02, 0.5 * np.sin(2 * t)], 1)
    assert abs(linking(ring, twice)) == pytest.approx(2)


@pytest.mark.parametrize("kind", tunnelling.KINDS)
@pytest.mark.parametrize("speed", ["2", "200"])
def test_without_contact_strands_pass_and_with_it_they_do_not(
    kind: str, speed: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    labels = FAST | {"of": kind, "speed": speed}
    found = tunnelling.check_tunnelling("rod", labels=labels)
    assert verdicts.judge("rod", {}, found).verdict == "pass"
    monkeypatch.setattr(StrandContact, "_look", lambda *arguments: None)
    failed = verdicts.judge("rod", {}, tunnelling.check_tunnelling("rod", labels=labels)).failed
    assert "passed" in failed or "linking_changed" in failed


def test_most_throws_would_pass_without_contact_and_some_are_linked_by_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(StrandContact, "_look", lambda *arguments: None)
    rows = tunnelling.rows()[::4]
    found = [tunnelling.check_tunnelling("rod", labels=row) for row in rows]
    assert sum(bool(one["passed"] or one.get("linking_changed")) for one in found) > 0.7 * len(rows)
    assert any(one.get("linking_changed") for one in found)


def test_passing_at_the_end_of_a_step_that_is_undone_does_not_count(monkeypatch: pytest.MonkeyPatch) -> None:
    """Whatever contact makes of it: parts of steps that are made anew in two halves."""
    labels = FAST | {"of": "across", "speed": "50"}
    make = StrandContact.step
    halved = []

    def too_long(self: StrandContact, run: object, dt: float, solver: object) -> bool:
        if dt > 0.03:
            look, self._look = self._look, lambda *arguments: None  # type: ignore[method-assign]
            make(self, run, dt, solver)  # type: ignore[arg-type]
            self._look = look  # type: ignore[method-assign]
            halved.append(dt)
            return False
        return make(self, run, dt, solver)  # type: ignore[arg-type]

    monkeypatch.setattr(StrandContact, "step", too_long)
    assert tunnelling.check_tunnelling("rod", labels=labels)["passed"] == 0
    assert halved


def test_they_are_in_the_matrix_and_a_few_in_the_small_one() -> None:
    rows = tunnelling.rows()
    assert len(tunnelling.CHECKS) == len(rows) == 180
    for axis, labels in {**tunnelling.AXES, **tunnelling.REST}.items():
        assert {row[axis] for row in rows} == set(labels)
    assert set(tunnelling.CHECKS) <= set(checks.CHECKS)
    assert 3 <= len(set(tunnelling.QUICK) & set(checks.QUICK)) <= 8
    (found,) = run.perform(run.named(f"thesis/{tunnelling.QUICK[0]}"))
    assert found.verdict == "not_represented"
