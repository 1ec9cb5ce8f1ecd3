"""Steps that vary: the thesis' stiffness trembles by them, and nothing else of a film changes."""

from __future__ import annotations

import numpy as np
import pytest

import strandcli
from strand_kit import solver_of
from strandcli.errors import UsageError
from strandcli.groom.emit import emit
from strandcli.scene.model import Scene
from strandcli.simulate.advice import warnings
from strandcli.study.claims import tremble

SETTINGS = {
    "emitter.strands": 40, "emitter.particles": 8, "emitter.length": 1.0, "emitter.keys": [], "time.fps": 24,
    "time.preroll": 8.0, "rules": ["gravity", {"stiffness": {"strength": 40.0}}, "elasticity"],
}  # fmt: skip


def scene(jitter: float, **more: object) -> Scene:
    return strandcli.load("headline", settings={**SETTINGS, "time.jitter": jitter, **more})


def test_resting_strands_tremble_by_stiffness_and_steps_that_vary() -> None:
    assert tremble(scene(0.0), 24) < 1e-5
    assert tremble(scene(0.5), 24) > 0.01
    assert tremble(scene(0.5, rules=["elasticity"]), 24) < 1e-5


def test_steps_are_spread_evenly_about_the_given_one() -> None:
    one = solver_of(scene(0.5))
    steps = np.sort([one._stretched(number / 24, 1 / 24) for number in range(-100, 400)])
    assert np.allclose(steps, np.linspace(0.5, 1.5, 500), atol=0.01)
    assert solver_of(scene(0.0))._stretched(3.0, 1 / 24) == 1.0


def test_a_step_asks_its_rules_for_its_own_length() -> None:
    """Gravity alone moves a particle by g Δt²."""
    one = solver_of(scene(0.5, rules=["gravity"]), plain=True)
    before = one.particles()[:, -1, 1]
    one.step(1.0, 1 / 24)
    fallen = before - one.particles()[:, -1, 1]
    assert fallen == pytest.approx(9.81 * (one._stretched(1.0, 1 / 24) / 24) ** 2, rel=1e-3)


def test_rods_say_that_they_ignore_it() -> None:
    rods = strandcli.load("headline", settings={"solver": "rod", "time.jitter": 0.5, "emitter.strands": 4})
    assert any(words.startswith("time.jitter: ignored") for words in warnings(rods, emit(rods.emitter, 0)))
    with pytest.raises(UsageError, match="jitter"):
        scene(1.0)
