"""Guesses of roots, up axis and unit: none is wrong on made grooms of all kinds, both ways round, and most are left
alone; what a file states counts; what turns strands says so."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest

import ends_kit
import exchange_kit as kit
from exchange.test_edits import head
from guesses import tally
from strandcli.exchange.edit import fix
from strandcli.exchange.ends import ends
from strandcli.exchange.facts import facts
from strandcli.exchange.strands import Attribute, Strands


@pytest.mark.parametrize("kind", ends_kit.KINDS)
def test_no_guess_is_wrong(kind: str) -> None:
    found: Counter[str] = Counter()
    for seed in range(1000, 1006):
        made = ends_kit.made(kind, seed)
        found.update(tally(made.strands, made.up, made.unit, seed))
    assert not {name: count for name, count in found.items() if name.endswith("wrong") and count}
    if kind in ("long_hair", "curls"):
        assert found["root right"] >= 4
    if kind not in ("fur", "long_hair", "curls", "bob", "forward"):
        assert found["root right"] == 0


@pytest.mark.parametrize("kind", ["grass", "mohawk", "line", "afro", "plane_fur", "buzz"])
def test_what_nothing_is_guessed_of_is_not_turned(kind: str) -> None:
    strands = ends_kit.made(kind, 3).strands
    assert fix.fixed(strands)[0].points.tobytes() == strands.points.tobytes()
    assert facts(strands).data["guess"] == {"root": None, "up": None, "head": None}


def held(strands: Strands, last: bool) -> Strands:
    """With the points movable but for the two at one end."""
    place = np.concatenate([np.arange(n)[:: -1 if last else 1] for n in strands.counts()])
    movable = (place > 1).astype(np.float32)
    return Strands(strands.first, strands.points, {"movable": Attribute("point", movable)})


def test_points_that_are_held_state_the_root() -> None:
    grass = ends_kit.made("grass", 4).strands
    for last, root in ((False, "first"), (True, "last")):
        found = facts(held(grass, last))
        assert (found.data["root"], found.data["guess"]["root"]) == (root, None)
        assert [one.mend for one in found.faults if one.fault == "tips_first"] == ["--reverse"] * last
    hair = kit.of(list(head()))
    assert ends(hair).root == "first"
    assert ends(held(hair, last=True)).root == "last"
    both = Attribute("point", np.zeros(len(hair.points), np.float32))
    assert not ends(Strands(hair.first, hair.points, {"movable": both})).stated
