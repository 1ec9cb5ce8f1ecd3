"""Rods that are hard to solve: compression, gales, roots that are shaken, edges without a direction."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from numpy.typing import NDArray

import strandcli
from strandcli.groom.emit import emit
from strandcli.groom.record import Groom
from strandcli.simulate.rod import RodSolver
from strandcli.study.stress import drive
from strandcli.study.stress.axes import case_named
from strandcli.study.stress.shaking import check_shake
from tests.simulate.test_rod import scene
from tests.simulate.test_rod_motion import solver_of


@pytest.mark.parametrize("n", [10, 32])
@pytest.mark.parametrize("way", ["along", "aslant"])
def test_a_root_that_is_shaken_leaves_no_residual(way: str, n: int) -> None:
    found = check_shake("rod", way=way, n=n, rates=("60Hz", "24Hz"), pulls=("0", "100"))
    assert found["residual"] <= 1e-3


def test_brushes_that_are_pressed_together_converge() -> None:
    """Strands that stand upright on a ball that rises under them: compression, where the dual has a gap."""
    one = strandcli.load("headline", settings={"solver": "rod", "emitter.strands": 1000, "time.preroll": 0})
    solver = solver_of(one)
    for frame in range(2, 31):
        solver.advance(frame)
        errors = solver.errors(frame)
        assert errors["nonfinite"] == 0
        assert errors["residual_max"] <= 1e-3  # type: ignore[operator]
        assert errors["penetration_max"] <= 1e-6  # type: ignore[operator]


def test_folded_strands_that_stiffen_toward_the_tip_unfold() -> None:
    """Compression again, where κ grows a million times along the strand: what a beam of κ at each place resists would
    still leave H indefinite, and pivots that run away."""
    name = "rod/dt=24Hz/substeps=8/gamma=7.7/contact=through/n=100/L=1e-6/tip=1e3/start=folded"
    (found,) = drive.run([case_named(name)])
    assert not found.error
    assert found.metrics["nonfinite"] == 0
    assert found.metrics["residual"] <= 0.05


def test_gales_that_turn_about_leave_no_nan() -> None:
    rules = [{"gravity": {}}, {"wind": {"strength": 1000, "sway": 90, "period": 0.1}}]
    for gamma in (1e-2, 1e4):
        solver = solver_of(scene(gamma, rules=rules, **{"emitter.strands": 20, "emitter.jitter": 120.0}))
        time = 0.0
        for dt in np.random.default_rng(1).choice([1e-4, 1 / 240, 1 / 24, 0.5, 10.0], 60):
            time += float(dt)
            solver.step(time, float(dt))
            errors = solver.errors(1)
            assert errors["nonfinite"] == 0
            assert errors["stretch_max"] <= 1e-6  # type: ignore[operator]


@dataclasses.dataclass(frozen=True)
class Collapsed(Groom):
    """A groom whose particles coincide from ``place`` on."""

    place: int = 0

    def edge(self, j: int, edges: int) -> NDArray[np.float64]:
        return super().edge(j, edges) * float(j < self.place)


@pytest.mark.parametrize("place", [0, 4])
def test_edges_without_a_direction_go_on_as_the_one_before(place: int) -> None:
    one = scene(1e9, **{"emitter.strands": 3, "emitter.jitter": 20.0, "rules": []})
    groom = emit(one.emitter, one.seed)
    straight = RodSolver(one, groom)
    lost = RodSolver(one, Collapsed(**{f.name: getattr(groom, f.name) for f in dataclasses.fields(groom)}, place=place))
    np.testing.assert_allclose(lost.particles(), straight.particles(), atol=1e-6)
    for i in range(3):
        lost.step((i + 1) / 24, 1 / 24)
    errors = lost.errors(1)
    assert errors["stretch_max"] <= 1e-6  # type: ignore[operator]
    assert errors["residual_max"] <= 1e-3  # type: ignore[operator]
    np.testing.assert_allclose(lost.particles(), straight.particles(), atol=1e-5)
