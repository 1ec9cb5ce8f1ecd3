"""The production solver against the references, by the code of `strandcli study`; thresholds from the design of the rod
solver: H/W within 1.5 % up to Γ = 1 and 2.5 % at Γ = 10 with nine segments, second order in the segments."""

from __future__ import annotations

from strandcli.study.axes import Request
from strandcli.study.points import Point, fitted_order
from strandcli.study.references.experiment import References


def measured(name: str, particles: int, dt: float) -> Point:
    return References(Request(name=name)).measure({"solver": "rod", "emitter.particles": particles, "dt": dt})


def error(name: str, metric: str, particles: int, dt: float) -> float:
    value = measured(name, particles, dt).error[metric]
    assert value is not None
    return value


def test_level_rods_are_the_elastica_at_any_step() -> None:
    for dt in (1 / 24, 1 / 120):
        errors = measured("elastica", 10, dt).error
        for load, most in (("0.1", 0.015), ("1", 0.015), ("10", 0.025)):
            found = errors[f"H/W Γ={load}"]
            assert found <= most


def test_segments_are_of_second_order() -> None:
    counts = (6, 10, 19)
    errors = [error("elastica", "H/W Γ=1", particles, 1 / 24) for particles in counts]
    order = fitted_order([1 / (particles - 1) for particles in counts], errors)
    assert order >= 1.8


def test_buckling_loads_are_those_of_the_exact_rod() -> None:
    assert error("buckling", "load", 10, 1 / 24) <= 0.01


def test_a_hanging_chain_keeps_its_frequency_and_its_swing() -> None:
    found = measured("chain", 10, 1 / 60).error
    assert found["loss"] <= 1e-3  # a cycle keeps at least 99.9 % at 60 steps a second
    assert found["frequency 1"] is not None
    assert found["frequency 1"] <= 0.006
