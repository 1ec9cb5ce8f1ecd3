"""Rods against solids: depth, friction, the groove between two, and what is carried along."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import mesh_kit as kit
from rod_kit import each_step, motion_at_rest, rms, rod_of, take_steps
from strandcli.simulate.rod.solver import RodSolver
from tests.simulate.test_rod import PULL, scene, solver_of
from tests.simulate.test_rod_motion import first


def against(solids: list[dict[str, Any]], gamma: float = 10.0, double: bool = False, **changes: Any) -> RodSolver:
    rules: list[Any] = ["emitter_motion", {"gravity": {"acceleration": [0, -PULL, 0]}}, "collision"]
    changes = {"emitter.strands": 20, "emitter.jitter": 30.0, "rules": rules, **changes}
    return solver_of(scene(gamma, solids=solids, **changes), double)


def ball(radius: float, *position: float, **more: Any) -> dict[str, Any]:
    return {"kind": "sphere", "radius": radius, "position": list(position), **more}


CASES = {
    "root on the surface, strand inside": [ball(0.3, 0.3, 0, 0)],
    "strand through the centre": [ball(0.2, 0.5, 0, 0)],
    "two that overlap": [ball(0.2, 0.5, -0.1, 0), ball(0.2, 0.65, -0.1, 0.1)],
    "smaller than half a segment": [ball(0.04, 0.5, -0.3, 0)],
    "capsule": [{"kind": "capsule", "radius": 0.15, "length": 1, "position": [0.5, -0.4, 0], "rotation": [90, 0, 0]}],
    "box": [{"kind": "box", "size": [0.4, 0.4, 0.4], "position": [0.5, -0.4, 0]}],
    "plane": [{"kind": "plane", "position": [0, -0.3, 0]}],
}


@pytest.mark.parametrize("dt", [1 / 240, 1 / 24, 0.5])
@pytest.mark.parametrize("case", CASES)
def test_nothing_is_left_inside(case: str, dt: float) -> None:
    solver = against(CASES[case])
    for i in range(100):
        solver.step((i + 1) * dt, dt)
        errors = solver.errors(1)
        assert errors["nonfinite"] == 0
        assert errors["stretch_max"] <= 1e-6  # type: ignore[operator]
        assert i == 0 or errors["penetration_max"] <= 1e-6  # type: ignore[operator]
        if dt <= 1 / 24:
            assert errors["residual_max"] <= 1e-3  # type: ignore[operator]


def carried(friction: float, shift: float) -> float:
    """How far the tip of a strand goes with a ball, so large that it is nearly flat, which moves under it sideways by
    so many metres in 4 seconds."""
    keys = [{"time": 0, "position": [0.5, -50.2, 0]}, {"time": 4, "position": [0.5, -50.2, shift]}]
    one = {"emitter.strands": 1, "emitter.jitter": 0.0, "rod.friction": friction, "rod.damping": 0.01}
    solver = against([{"kind": "sphere", "radius": 50, "keys": keys}], 100.0, **one)
    take_steps(solver, 24, 96)
    assert first(solver)[-1, 1] < -0.15
    return float(first(solver)[-1, 2])


def test_friction_carries_strands_along() -> None:
    # the ball has its top further on now: without friction the strand slides a little downhill, the other way
    assert -0.05 < carried(0.0, 0.2) < 0
    assert abs(carried(1.0, 0.0)) < 1e-3
    assert carried(1.0, 0.2) > 0.05


SECONDS, RATE, SHIFT = 1.0, 24, 0.2


def slab(folder: Path, shift: float = 0.0, top: float = -0.2) -> str:
    """A file of a slab whose top is at a height, shifted along z."""
    vertices, triangles = kit.cube()
    return str(kit.write(folder / f"slab_{shift}.obj", vertices * (1.5, 0.3, 1.5) + (0, top - 0.3, shift), triangles))


def moved(friction: float, **solid: Any) -> np.ndarray:
    """Particles of a strand that lies on a mesh, after some seconds."""
    one = {"emitter.strands": 3, "emitter.jitter": 0.0, "rod.friction": friction, "rod.damping": 0.01}
    solver = against([{"kind": "mesh", **solid}], 100.0, **one)
    take_steps(solver, RATE, int(SECONDS * RATE))
    assert solver.errors(1)["penetration_max"] < 1e-3  # type: ignore[operator]
    return first(solver)


def test_a_surface_that_slides_carries_strands_as_a_solid_that_moves(tmp_path: Path) -> None:
    """The same motion by files and by keys, of a slab that a strand rests on; straight lines in time are both."""
    here, there = slab(tmp_path), slab(tmp_path, SHIFT)
    keys = [{"time": 0, "ease": "linear"}, {"time": SECONDS, "position": [0, 0, SHIFT]}]
    rigid = moved(1.0, file=here, keys=keys)
    sliding = moved(1.0, file=here, deform=[{"time": 0, "file": here}, {"time": SECONDS, "file": there}])
    still = moved(1.0, file=here)
    assert rigid[-1, 2] - still[-1, 2] > 0.05
    np.testing.assert_allclose(sliding, rigid, atol=1e-5)


def test_without_friction_a_surface_that_slides_carries_nothing(tmp_path: Path) -> None:
    here, there = slab(tmp_path), slab(tmp_path, SHIFT)
    deform = [{"time": 0, "file": here}, {"time": SECONDS, "file": there}]
    np.testing.assert_allclose(moved(0.0, file=here, deform=deform), moved(0.0, file=here), atol=1e-5)


def test_a_surface_that_slides_in_a_solid_that_turns_adds_up(tmp_path: Path) -> None:
    """A slab turned by its keys, whose file slides it along its own axes, is where one is that moves by keys alone; and
    it carries the strand as that does."""
    here, there = slab(tmp_path), slab(tmp_path, SHIFT)
    posed = {"rotation": [0, 90, 0]}
    keys = [{"time": 0, "ease": "linear", **posed}, {"time": SECONDS, "position": [SHIFT, 0, 0], **posed}]
    rigid = moved(1.0, file=here, keys=keys)
    deform = [{"time": 0, "file": here}, {"time": SECONDS, "file": there}]
    sliding = moved(1.0, file=here, deform=deform, **posed)
    np.testing.assert_allclose(sliding, rigid, atol=1e-5)
    half = [{"time": 0, "ease": "linear", **posed}, {"time": SECONDS, "position": [-SHIFT, 0, 0], **posed}]
    held = moved(1.0, file=here, deform=deform, keys=half)
    np.testing.assert_allclose(held, moved(1.0, file=here, **posed), atol=1e-5)


@pytest.mark.parametrize("friction", [0.1, 0.5, 1.0])
def test_friction_on_a_slope_is_coulombs(friction: float) -> None:
    """Across a slope a limp strand stays below arctan µ; on a steeper one all of it slides at g (sin θ − µ cos θ)."""
    for beside in (-3.0, 10.0):
        slope = np.arctan(friction) + np.radians(beside)
        solver = rod_of(
            f"rod: {{rest: straight, radius: 1.0e-4, young: 1000, drag: 0, damping: 0, friction: {friction}}}\n"
            "time: {fps: 960}\nemitter: {shape: {kind: disc, radius: 1.0e-6}, strands: 1, particles: 11, length: 1, "
            "direction: [1, 0, 0]}\nrules: [gravity, collision]\n"
            f"solids: [{{kind: plane, rotation: [{np.degrees(slope)}, 0, 0]}}]\n"
        )
        take_steps(solver, 960, 192)
        slid = first(solver)[-1] @ [0, -np.sin(slope), np.cos(slope)]
        free = max(PULL * (np.sin(slope) - friction * np.cos(slope)), 0) * 0.2**2 / 2
        assert slid == pytest.approx(free, rel=0.04, abs=1e-4)


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
    moved = 1e3 * np.sqrt((motion_at_rest(solver, rate, 8) ** 2).mean(0)).max(-1)
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
