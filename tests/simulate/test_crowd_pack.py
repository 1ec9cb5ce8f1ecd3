"""Accelerations by interaction that the rods' own step computes, pack by pack."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest

from strandcli.simulate.crowd import Crowd
from tests.simulate.test_crowd import BALL, solver_of


@pytest.mark.parametrize(
    ("double", "cell"), [(False, 0.03), (False, 0.1), pytest.param(True, 0.1, marks=pytest.mark.long)]
)
def test_they_are_those_of_all_packs_at_once(double: bool, cell: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each of which finds its nodes anew; with samples of several segments too, and where the emitter jumps."""
    keys = "[{time: 0.042}, {time: 0.09, position: [0.1, 0, 0]}, {time: 0.12, position: [9, 0, 0]}]"
    text = (
        f"emitter: {{{BALL}, strands: 900, keys: {keys}}}\n"
        "solids: [{kind: sphere, radius: 0.1, follow: emitter}]\nrules: [emitter_motion, gravity, "
        f"wind: {{strength: 1}}, collision, interaction: {{friction: 0.3, cell: {cell}, density: 3000}}]"
    )
    packs, at_once = (solver_of(text, double=double) for _ in range(2))
    assert at_once.crowd is not None
    assert (len(at_once.crowd.samples.first) < 5) == (cell > 0.03)
    packs.advance(4)
    monkeypatch.setattr(at_once.crowd, "prepare", partial(without_later, at_once.crowd))
    at_once.advance(4)
    assert np.abs(at_once.state.crowd).max() > 0
    assert not packs.state.crowd.any(), "accelerations of a pack are kept for no longer than it is worked on"
    for name, one in at_once.state_arrays().items():
        if name != "state crowd":
            np.testing.assert_array_equal(packs.state_arrays()[name], one, name)


def without_later(crowd: Crowd, *args: object) -> tuple[int, ...]:
    assert not crowd.strands.noted
    return Crowd.prepare(crowd, *args[:4])  # type: ignore[arg-type]
