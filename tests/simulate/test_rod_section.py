"""Oval sections: what they bend like across each axis, in any form; how they lie; checkpoints; refusals."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray

from strand_kit import require_same_after_restart, scene_of
from strandcli.groom.emit import emit
from strandcli.scene import SceneError
from strandcli.simulate import section as sections
from strandcli.simulate.advice import warnings
from strandcli.simulate.kernels.records import LED
from strandcli.simulate.kernels.rod_scratch import PACK
from strandcli.simulate.rod import RodSolver
from strandcli.simulate.rod_kernel import StepKernel
from strandcli.study.exactness import scene_of as reference_scene
from strandcli.study.motion.contestants import CONTESTANTS, follow, prepare
from strandcli.study.references import section

Floats = NDArray[np.float64]


@cache
def measured(particles: int, dt: float) -> dict[str, float | None]:
    """Errors of the reference, in double precision as all of these tests: one kernel."""
    case = section.case(particles)
    case.settings["rod"]["precision"] = "double"
    scene = reference_scene(case, CONTESTANTS["rod"], {})
    track, _ = follow(lambda: prepare(CONTESTANTS["rod"], scene, case), dt, section.REFERENCE.span, True)
    return section.measure(track)


@pytest.mark.long
def test_it_swings_about_both_axes_at_a_beam_s_frequencies_and_keeps_at_it() -> None:
    coarse, fine, soon = measured(10, 1 / 192), measured(19, 1 / 192), measured(19, 1 / 24)
    for axis in ("thin", "wide", "askew"):
        assert fine[axis] < 5e-3  # type: ignore[operator]
    assert coarse["thin"] / fine["thin"] > 3.5  # type: ignore[operator]
    assert soon["wide"] / measured(19, 1 / 48)["wide"] > 3.2  # type: ignore[operator]
    assert soon["loss"] < 0.01  # type: ignore[operator]


@pytest.mark.long
def test_an_askew_load_bends_it_out_of_its_plane_as_closed_forms_say() -> None:
    assert measured(19, 1 / 192)["deflection"] < 4e-3  # type: ignore[operator]
    assert measured(10, 1 / 192)["deflection"] / measured(19, 1 / 192)["deflection"] > 3.5  # type: ignore[operator]


def curls(more: str = "", rod: str = "", rest: str = "shape") -> RodSolver:
    """Loose curls under their weight."""
    scene = scene_of(
        f"solver: rod\nrod: {{rest: {rest}, radius: 8.0e-5, precision: double, drag: 8, torsion: 0.7, "
        f"section: {{wide: 1.4, thin: 0.7, angle: 20, spread: 180{more}}}{rod}}}\ntime: {{fps: 60}}\n"
        "emitter: {shape: {kind: disc, radius: 0.01}, strands: 8, particles: 14, length: 0.12, curl_turns: 1.5, "
        "curl_angle: 50, rotation: [180, 0, 0]}\nrules: [gravity]\n"
    )
    return RodSolver(scene, emit(scene.emitter, scene.seed))


def energy(solver: RodSolver, strand: int, edges: Floats, twist: Floats) -> float:
    """Of a strand with such edges (N, 3) and twist angles (N,), over its stiffness, from the docs' words alone: frames
    are carried by rotations, bends are compared with their rests along each axis."""
    soft, material = sections.softness(solver.scene.rod), solver.material
    pack, lane = divmod(strand, PACK)
    bends = material.bends[pack].reshape(-1, 3, PACK)[:, :, lane]
    stiff = float(material.stiffness[pack, lane])
    pull = np.array(solver._gravity) / float(material.lengths[pack, lane])
    turn = np.array(solver.pose.rotation)
    t = turn @ solver.forcing.directions[pack].reshape(3, PACK)[:, lane]
    a, psi, place, total = turn @ bends[0], 0.0, np.zeros(3), 0.0
    for j, e in enumerate(edges):
        wide = np.cos(psi) * a + np.sin(psi) * np.cross(t, a)
        thin = np.cross(t, wide)
        off = np.array([e @ t - 1, e @ wide, e @ thin]) - bends[j + 1]
        total += material.joint[j] / 2 * float(off @ (off * (1, 1, 1 - soft)))
        place = place + e
        total -= solver.mass[j] * float(pull @ place) / stiff
        if j + 1 < len(edges):
            total += solver.forcing.numbers[13] * material.joint[j] / 2 * (twist[j] - psi) ** 2
            psi = twist[j]
        axis = np.cross(t, e)
        sine, cosine = float(np.linalg.norm(axis)), float(t @ e)
        if sine > 0:
            k = axis / sine
            a = a * cosine + np.cross(k, a) * sine + k * (k @ a) * (1 - cosine)
        t = e
    return float(total)


def torques(solver: RodSolver, strand: int) -> tuple[float, float]:
    """Greatest torque on an edge, across and along it, over the weight's at the root."""
    pack, lane = divmod(strand, PACK)
    edges = solver.state.edges[pack].reshape(-1, 3, PACK)[:, :, lane].copy()
    twist = solver.state.twist[pack][:, lane].copy()
    found = []
    for j in range(len(edges)):
        for axis in np.eye(3):
            sides = []
            for way in (1e-5, -1e-5):
                moved = edges.copy()
                moved[j] = moved[j] + way * np.cross(axis, moved[j])
                moved[j] /= np.linalg.norm(moved[j])
                sides.append(energy(solver, strand, moved, twist))
            found.append((sides[0] - sides[1]) / 2e-5)
    about = []
    for j in range(len(edges) - 1):
        sides = []
        for way in (1e-5, -1e-5):
            other = twist.copy()
            other[j] += way
            sides.append(energy(solver, strand, edges, other))
        about.append((sides[0] - sides[1]) / 2e-5)
    weight = np.linalg.norm(solver._gravity) / float(solver.material.lengths[pack, lane])
    scale = float(weight * solver.mass.sum() * len(edges) / 2 / solver.material.stiffness[pack, lane])
    return float(np.abs(found).max()) / scale, float(np.abs(about).max()) / scale


@pytest.mark.long
@pytest.mark.parametrize("rod", ["", ", integrator: euler"])
def test_curls_come_to_rest_where_an_independent_energy_is_least(rod: str) -> None:
    solver = curls(rod=rod)
    solver.advance(121)
    assert float(np.abs(solver.state.twist).max()) > 0.1, "they hardly twist"
    for strand in range(solver.strands):
        assert max(torques(solver, strand)) < 1e-8


@pytest.mark.long
def test_it_is_compared_with_what_is_none_the_wiser(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of a section that is a little other, the energy is not least there."""
    solver = curls()
    solver.advance(121)
    softness = sections.softness(solver.scene.rod)
    monkeypatch.setattr(sections, "softness", lambda rod: softness + 0.001)
    assert max(torques(solver, 0)) > 1e-6


@pytest.mark.long
def test_a_sag_free_start_hangs_still() -> None:
    solver = curls(rest="sag_free")
    start = solver.particles().copy()
    for strand in range(solver.strands):
        assert max(torques(solver, strand)) < 1e-8
    solver.advance(30)
    assert np.abs(solver.particles() - start).max() < 1e-6 * 0.12
    assert warnings(solver.scene, solver.groom) == []


@pytest.mark.long
def test_a_state_in_the_middle_goes_on_to_the_same_bits() -> None:
    whole, half = curls(), curls()
    require_same_after_restart(whole, half)


@pytest.mark.long
def test_loose_curls_of_a_flat_wire_gain_no_energy() -> None:
    """Struck, without damping: what moves them in the last of four spans is less than in the second. Led by velocities
    alone they would gain fiftyfold."""
    solver = loose_curls()
    rate = solver._coil_rate
    dt = 0.25 / rate
    along = np.linspace(0, 1, 25)[:, None]
    solver.state.velocity.reshape(25, 3, PACK)[:, :2] += 0.004 * rate * along[:, None]
    found = []
    for span in range(4):
        most = 0.0
        for i in range(1500):
            solver._step((1500 * span + i + 1) * dt, dt)
            most = max(most, float((solver.state.velocity**2).sum()))
        found.append(most)
    assert solver.forcing.numbers[LED] == 1
    assert found[3] < found[1] < found[0]


def loose_curls() -> RodSolver:
    scene = scene_of(
        "solver: rod\nrod: {rest: shape, radius: 4.0e-5, precision: double, damping: 0, drag: 0, torsion: 0.7, "
        "section: {wide: 2, thin: 0.5, angle: 20, spread: 180}}\nemitter: {shape: {kind: disc, radius: 0.01}, "
        f"strands: {PACK}, particles: 26, length: 0.2, curl_turns: 3, curl_angle: 10, rotation: [180, 0, 0]}}\n"
        "rules: []\n"
    )
    return RodSolver(scene, emit(scene.emitter, scene.seed))


def test_the_axes_lie_across_strands_as_they_are_turned() -> None:
    rod = scene_of("solver: rod\nrod: {section: {wide: 2, angle: 30, spread: 10}}\n").rod
    ways = np.array([[0.0, 1, 0], [1, 0, 0], [0, 0, 1], [0.6, 0, 0.8]])
    wide = sections.wide_axes(rod, ways, np.array([0.0, 0.0, 1.0, -1.0]))
    assert wide is not None
    for axis, way, zero, angle in zip(
        wide, ways, ([1, 0, 0], [0, 0, 1], [1, 0, 0], [0.8, 0, -0.6]), (30, 30, 40, 20), strict=True
    ):
        goal = np.cos(np.radians(angle)) * np.array(zero) + np.sin(np.radians(angle)) * np.cross(way, zero)
        np.testing.assert_allclose(axis, goal, atol=1e-15)


def test_round_sections_have_a_round_strand_s_kernel_and_motion() -> None:
    """Twice as thick as the radius says, and with nothing compiled for them."""
    text = "solver: rod\nrod: {{precision: double, {}}}\nemitter: {{strands: 4, particles: 12}}\nrules: [gravity]\n"
    one, other = (
        RodSolver(scene, emit(scene.emitter, scene.seed))
        for scene in map(
            scene_of, (text.format("radius: 8.0e-5"), text.format("radius: 4.0e-5, section: {wide: 2, thin: 2}"))
        )
    )
    for solver in (one, other):
        assert isinstance(solver.kernel, StepKernel)
        assert not solver.kernel._flags.oval
        solver.advance(5)
    np.testing.assert_array_equal(one.positions, other.positions)


@pytest.mark.parametrize(
    ("section", "rod", "words"),
    [
        ("{wide: 0}", "", r":2:\d+: rod\.section\.wide: must be a number above 0"),
        ("{thin: 0}", "", r":2:\d+: rod\.section\.thin: must be a number above 0"),
        ("{thin: 2}", "", r":2:\d+: rod\.section\.thin: thin is more than wide; swap them"),
        ("{wide: 4, thin: 0.9}", "", r"rod\.section\.thin: thin is less than a quarter of wide, 1:"),
        ("{wide: 2}", "root: free", r"rod\.section: free roots have no frame"),
        ("{wide: 2}", "end: clamped", r"rod\.section: clamped tips know of no section"),
    ],
)
def test_sections_that_strands_cannot_have_are_refused_with_their_place(section: str, rod: str, words: str) -> None:
    with pytest.raises(SceneError, match=words):
        scene_of(f"solver: rod\nrod: {{section: {section}, {rod}}}\n")


def test_they_do_not_go_with_contact() -> None:
    with pytest.raises(SceneError, match=r"rod\.section: does not go with the rule contact"):
        scene_of("solver: rod\nrod: {section: {wide: 2}}\nrules: [gravity, contact]\n")
