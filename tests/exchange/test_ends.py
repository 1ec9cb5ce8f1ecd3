"""Guesses of roots and up axis: none is wrong on made grooms of all kinds, both ways round, and most are left
alone; what turns strands says so."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import ends_kit
import exchange_kit as kit
import groom_file_kit
from cli_runs import Runner
from exchange.test_edits import head
from strandcli.exchange import edits
from strandcli.exchange.ends import ends, up_axis
from strandcli.exchange.facts import facts
from strandcli.groom_file import from_scene


@pytest.mark.parametrize("kind", ends_kit.KINDS)
def test_no_guess_is_wrong(kind: str) -> None:
    right = 0
    for seed in range(1000, 1002):
        made = ends_kit.made(kind, seed)
        for truth, strands in (("first", made.strands), ("last", edits.reversed_all(made.strands)[0])):
            known = ends(strands)
            up = up_axis(strands, known)
            assert known.root in ("", truth)
            assert up is None or up[0] == made.up
            right += known.root == truth
    if kind in ("long_hair", "curls"):
        assert right >= 2


@pytest.mark.parametrize("kind", ["grass", "afro"])
def test_what_nothing_is_guessed_of_is_not_turned(kind: str) -> None:
    strands = ends_kit.made(kind, 3).strands
    assert edits.fixed(strands)[0].points.tobytes() == strands.points.tobytes()
    assert facts(strands)["guess"] == {"root": None, "up": None}


def test_what_turns_all_strands_says_why_and_how_to_have_them_otherwise(tmp_path: Path) -> None:
    hair = head()
    change = edits.fixed(kit.of(list(hair[:, ::-1])))[1]
    assert change.facts["turned_around"] == 200
    assert "turned around, for roots are last: there strands fan out" in change.text
    assert "with --reverse as well they run as in the file" in change.text
    file = groom_file_kit.write(tmp_path / "a.data", list(hair[:, ::-1]))
    for root, fix_it, turned in (("auto", True, True), ("first", True, False), ("auto", False, False)):
        given = groom_file_kit.scene(file, emitter__groom__root=root, emitter__groom__fix=fix_it)
        notes = [one for one in from_scene(given).notes if "turned around" in one]
        assert len(notes) == turned
        assert all("emitter.groom.root: first has none turned" in one for one in notes)


def test_info_says_what_is_not_guessed(tmp_path: Path, run: Runner) -> None:
    groom_file_kit.write(tmp_path / "grass.data", list(ends_kit.made("grass", 4).strands.points.reshape(-1, 2, 3)))
    (tmp_path / "hair.data").write_bytes(kit.data(list(head() * np.float32(0.01))))
    (tmp_path / "none.data").write_bytes(kit.data([]))
    line = "as it is   roots are first, up is y, units are metres: there is no evidence for a guess"
    assert line in run("info", tmp_path / "grass.data").out
    assert "roots are" not in run("info", tmp_path / "none.data").out
    assert "as it is   units are metres: there" in run("info", tmp_path / "hair.data").out
