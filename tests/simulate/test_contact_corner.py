"""Strands in the groove between two solids, which both press them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from rod_kit import each_step, motion_at_rest, rms, rod_of
from strandcli.simulate.rod.solver import RodSolver
from tests.simulate.test_rod_contact import slab

SECONDS = 8
STILL = 0.5
"""Millimetres a frame, root mean square of the liveliest particles of strands: what two solids at once may leave at
rest."""
GROOVE = (
    "{{kind: plane, rotation: [0, 0, {0}], position: [0, -0.05, 0]}}, "
    "{{kind: plane, rotation: [0, 0, -{0}], position: [0, -0.05, 0]}}"
)
CAPSULES = (
    "{kind: capsule, position: [0.05, -0.07, 0], rotation: [90, 0, 0], length: 0.4, radius: 0.055}, "
    "{kind: capsule, position: [-0.05, -0.08, 0], rotation: [85, 0, 0], length: 0.4, radius: 0.05}"
)
BALL = "{kind: sphere, position: [0.02, -0.06, 0.1], radius: 0.05}"
FLOOR = "{kind: plane, position: [0, -0.05, 0]}"


def fallen(solids: str, rate: int = 24, more: str = "", rule: str = "collision", strands: int = 16) -> RodSolver:
    """Slack strands of .2 m over solids; ``more`` of the rod."""
    return rod_of(
        f"seed: 1\nrod: {{radius: 1.0e-4, rest: straight, drag: 2, damping: 0.01, {more}}}\n"
        f"time: {{fps: {rate}}}\nemitter: {{shape: {{kind: disc, radius: 0.01}}, strands: {strands}, particles: 16, "
        "length: 0.2, jitter: 3, curl_turns: 2, curl_angle: 50, rotation: [90, 0, 0]}\n"
        f"rules: [gravity, {rule}]\nsolids: [{solids}]\n"
    )


def liveliest(solver: RodSolver, rate: int = 24) -> float:
    """Root mean square over strands of the motion of each one's liveliest particle, mm a frame."""
    moved = 1e3 * np.sqrt((motion_at_rest(solver, rate, SECONDS) ** 2).mean(0)).max(-1)
    return rms(moved)


@pytest.mark.parametrize("rate", [24, 60])
@pytest.mark.parametrize("more", ["end: pinned", "end: free", "root: hinged"])
@pytest.mark.parametrize("angle", [40, 60])
def test_strands_rest_in_a_groove(angle: int, more: str, rate: int) -> None:
    solver = fallen(GROOVE.format(angle), rate, f"friction: 0.2, {more}")
    assert liveliest(solver, rate) < STILL
    places = solver.particles().astype(np.float64)
    sides = np.deg2rad(angle) * np.array([1, -1])
    heights = places[..., 1:2] + 0.05
    depth = places[..., :1] * np.sin(sides) - heights * np.cos(sides)
    assert (depth[:, 1:].max(-1) < 1e-5).all()


@pytest.mark.parametrize("low", [-0.04, -0.06])
def test_pinned_tips_stay_where_they_are(low: float) -> None:
    """Steps in parts that began with the velocity of a whole one let them sink by 12 to 22 mm."""
    solver = fallen(GROOVE.format(40).replace("-0.05", str(low)), 24, "friction: 0.2, end: pinned")
    begun = solver.particles()[:, -1].astype(np.float64)
    off = []
    for _ in each_step(solver, 24, 96):
        off.append(np.linalg.norm(solver.particles()[:, -1] - begun, axis=-1).max())
    assert max(off) < 5e-5


@pytest.mark.parametrize("rule", ["collision", "{collision: {segments: true}}"], ids=["particles", "segments"])
@pytest.mark.parametrize("solids", [CAPSULES, GROOVE.format(8), f"{BALL}, {FLOOR}"], ids=["capsules", "flat", "ball"])
@pytest.mark.parametrize("friction", [0.0, 0.2])
@pytest.mark.parametrize("end", ["pinned", "free"])
def test_strands_rest_between_other_solids(end: str, friction: float, solids: str, rule: str) -> None:
    assert liveliest(fallen(solids, 24, f"friction: {friction}, end: {end}", rule)) < STILL


@pytest.mark.parametrize("end", ["pinned", "free"])
def test_strands_rest_between_two_meshes(end: str, tmp_path: Path) -> None:
    file = slab(tmp_path, top=-0.05)
    solids = ", ".join(f"{{kind: mesh, file: {file}, rotation: [0, 0, {angle}]}}" for angle in (20, -35))
    assert liveliest(fallen(solids, 24, f"friction: 0.2, end: {end}")) < STILL


@pytest.mark.parametrize("rule", ["collision", "{collision: {segments: true}}"], ids=["particles", "segments"])
def test_pinned_strands_whose_roots_are_in_a_solid_rest(rule: str) -> None:
    ball = "{kind: sphere, position: [0.03, -0.02, 0], radius: 0.05}"
    assert liveliest(fallen(f"{ball}, {FLOOR}", 24, "friction: 0.2, end: pinned", rule)) < STILL


@pytest.mark.parametrize("end", ["pinned", "free"])
def test_a_solid_that_is_there_twice_changes_no_bit(end: str) -> None:
    once, twice = (fallen(solids, 24, f"end: {end}") for solids in (BALL, f"{BALL}, {BALL}"))
    for i in range(48):
        for solver in (once, twice):
            solver.step((i + 1) / 24, 1 / 24)
    assert once.state.force.any()
    np.testing.assert_array_equal(once.particles(), twice.particles())


def test_strands_beside_change_no_bit() -> None:
    """Of strands in a groove, those of 16 are the first ones of 40."""
    few, many = (fallen(GROOVE.format(40), 24, "end: pinned", strands=strands) for strands in (16, 40))
    np.testing.assert_array_equal(few.particles(), many.particles()[:16])
    for i in range(48):
        for solver in (few, many):
            solver.step((i + 1) / 24, 1 / 24)
    np.testing.assert_array_equal(few.particles(), many.particles()[:16])
