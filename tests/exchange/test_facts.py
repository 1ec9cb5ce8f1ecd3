"""What is told of a groom: closed forms of simple ones, and the option that mends each fault."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import exchange_kit as kit
from exchange.test_edits import head
from strandcli.exchange import edits
from strandcli.exchange.facts import facts, facts_of_file
from strandcli.exchange.files import ReadOptions
from strandcli.exchange.strands import Strands


def faults(strands: Strands) -> dict[str, tuple[int, str]]:
    return {one["fault"]: (one["count"], one["mend"]) for one in facts(strands)["faults"]}


def test_counts_lengths_and_box() -> None:
    strands = kit.of([np.array([[0, 0, 0], [3, 4, 0]], np.float32), np.array([[0, 0, 0], [0, 0, 1], [0, 0, 2]])])
    data = facts(strands)
    assert (data["strands"], data["points"]) == (2, 5)
    assert data["length"] == {"min": 2, "median": 3.5, "mean": 3.5, "max": 5}
    assert data["points_a_strand"]["median"] == 2.5
    assert data["box"] == {"min": [0, 0, 0], "max": [3, 4, 2], "size": [3, 4, 2]}


def test_tips_that_come_first_are_told() -> None:
    groom = head() * np.float32(0.01)
    assert faults(kit.of(list(groom[:, ::-1]))) == {"tips_first": (200, "--reverse")}


@pytest.mark.parametrize("far", [None, 1.0, 1e8])
def test_a_groom_of_metres_with_y_up_has_no_faults_and_a_strand_far_from_all_others_changes_nothing(
    far: float | None,
) -> None:
    groom = list(head() * np.float32(0.01))
    if far is not None:
        stray = np.array([[0, 0, 0], [far, 0, 0]], np.float32)
        groom += [stray, stray + np.float32(2 * far)]
    found = facts(kit.of(groom))
    guess = found["guess"]
    assert (guess["root"], guess["up"]["axis"]) == ("first", "y")
    assert found["faults"] == []


def test_single_strands_at_fault_are_told_with_what_mends_them() -> None:
    groom = list(head() * np.float32(0.01))
    bad = groom[1].copy()
    bad[0, 0] = np.inf
    speck = groom[0][0] + np.linspace(0, 1e-6, 5, dtype=np.float32)[:, None]
    strands = kit.of([*groom[2:], bad, groom[4], np.ones((3, 3), np.float32), speck.astype(np.float32)])
    found = faults(strands)
    assert {name: one[0] for name, one in found.items()} == {
        "not_finite": 1, "without_length": 1, "repeated": 1, "tiny": 1,
    }  # fmt: skip
    assert found["not_finite"][1] == found["without_length"][1] == found["repeated"][1] == "--fix"
    assert found["tiny"][1].startswith("--min-length")
    assert not {"not_finite", "without_length", "repeated"} & faults(edits.fixed(strands)[0]).keys()


def test_json_has_no_number_that_is_none(tmp_path: Path) -> None:
    """Of no strands, and of strands that are all bad."""
    grooms: list[Any] = [[], [np.full((3, 3), np.nan, np.float32)], [np.ones((2, 3), np.float32)]]
    for strands in grooms:
        (tmp_path / "a.data").write_bytes(kit.data(strands))
        json.dumps(facts_of_file(tmp_path / "a.data", ReadOptions()), allow_nan=False)
