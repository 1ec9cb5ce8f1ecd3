"""Strands in contact: what they lose of a swing, friction of those that slide, bundles that are shaken."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from crossing_kit import strands
from rod_kit import rod_of
from strand_kit import scene_of
from strandcli.groom.emit import emit
from strandcli.jit import function
from strandcli.simulate.contact.kernels import contact_solve
from strandcli.simulate.health import interpenetration
from strandcli.simulate.rod.kernels.arrays import PACK
from strandcli.simulate.rod.solver import RodSolver
from strandcli.study.bench import at_first_frame, load
from strandcli.study.references import incline, track_of
from tests.simulate.test_strand_contact import CROSS, RULE, Floats, laid_pair

PAIR = (
    "rod: {rest: shape, radius: 3.0e-4, young: 1.0e+7, drag: 0, damping: 0}\ntime: {fps: 24, substeps: %d}\n"
    "emitter: {strands: 2, particles: 25, length: 1, keys: [{time: 0, rotation: [25, 0, 0]}, {time: 0.1}]}\n"
    "rules: [emitter_motion, gravity, contact: {thickness: 0.005, friction: %g}]"
)


def swing(turns: float, friction: float, substeps: int) -> tuple[Floats, int]:
    """Return where tips are across, of two strands laid about each other, in each of 96 frames, and in how many of
    these the strands press each other."""
    solver = rod_of(PAIR % (substeps, friction), laid_pair(24, turns, 0.0025, 0.25))
    tips, touched = [], 0
    for frame in range(2, 98):
        solver.advance(frame)
        tips.append(solver.particles()[:, -1, 2].mean())
        touched += bool(solver.state.acceleration.any())
    return np.array(tips, float), touched


def loss_of(tips: Floats) -> float:
    """Return the share of the amplitude that a cycle takes, from the half-cycles after the root has come to rest."""
    extremes = []
    for a, b, c in zip(tips[3:], tips[4:], tips[5:], strict=False):
        if (b - a) * (c - b) <= 0 and a - 2 * b + c != 0:
            extremes.append(b - (c - a) ** 2 / 8 / (a - 2 * b + c))
    sizes = np.abs(np.diff(extremes))
    return float(1 - np.exp(2 * np.polyfit(np.arange(len(sizes)), np.log(sizes), 1)[0]))


@pytest.mark.parametrize(
    ("turns", "friction", "most"),
    [(1.0, 0.5, 0.021), pytest.param(2.5, 0.0, 0.024, marks=pytest.mark.long), (2.5, 0.5, 0.036)],
)
def test_strands_that_touch_lose_little_more_than_in_fine_steps(turns: float, friction: float, most: float) -> None:
    """At 24 steps a second, against steps a sixteenth as long. A strand that touches nothing loses .02. Those that met
    anew by Euler's method would lose .12, .07 and .07, those that went on with impacts .06. With friction it matters
    where they stick: .03 to .05 by 2.3 to 2.5 turns at 21 to 29°, .07 to .15 by 2.7 turns."""
    (coarse, touched), (fine, _) = swing(turns, friction, 1), swing(turns, friction, 16)
    assert touched > 40
    assert loss_of(coarse) < loss_of(fine) + most


def test_strands_do_not_spring_back_from_each_other() -> None:
    """One that crosses another flies at it, without weight: after the step in which they meet, and in the steps after
    it, where they touch, they come apart by less than a twentieth of that speed."""
    groom = strands([[-0.5, 0, 0], [0, 0.013, -0.5]], [[1, 0, 0], [0, 0, 1]], [1, 1])
    text = CROSS.format(young="1.0e+3") + RULE.format(d=0.01).replace("gravity", "gravity: {acceleration: [0, 0, 0]}")
    solver = rod_of(text, groom)
    solver.advance(2)
    speed, dt = 0.1, 1 / 24
    state = solver.state
    for one, value in (
        (state.velocity, -speed),
        (state.before, -speed),
        (state.ahead, -speed),
        (state.moved, -speed * dt),
    ):
        one.reshape(1, 10, 3, PACK)[0, :, 1, 1] = value
    apart = []
    for frame in range(3, 7):
        solver.advance(frame)
        velocity = state.velocity.reshape(1, 10, 3, PACK)[0, 4, 1].astype(float)
        apart.append(velocity[1] - velocity[0])
    assert max(apart) < 0.05 * speed


def test_contact_leaves_strands_that_interact_as_they_are_where_none_touch() -> None:
    """By the rule interaction alone and with contact of strands that are far too thin to meet."""
    text = (
        "solver: rod\nrod: {rest: straight, radius: 2.0e-4, young: 1.0e+8}\n"
        "emitter: {shape: {kind: disc, radius: 0.01}, strands: 24, particles: 9, length: 0.1, "
        "keys: [{time: 0}, {time: 0.5, position: [0.05, 0, 0]}]}\nrules: [emitter_motion, gravity, interaction%s]"
    )
    found = []
    for rule in ("", ", contact: {thickness: 1.0e-9}"):
        scene = scene_of(text % rule)
        solver = RodSolver(scene, emit(scene.emitter, scene.seed))
        solver.advance(8)
        assert rule or (solver.grid is not None and solver.grid.pushed.any())
        found.append(solver.particles())
    np.testing.assert_allclose(found[1], found[0], atol=1e-6)


@function
def force_of(given: Floats, friction: float, w: Floats, out: Floats) -> None:
    """``given`` (3, 3): normal, way at the begin, and way without the force, which is to be 1 along the normal."""
    three = contact_solve.three
    rows = three(w[0], 0), three(w[1], 0), three(w[2], 0)
    normal, start, free = three(given[0], 0), three(given[1], 0), three(given[2], 0)
    out[0], out[1], out[2] = contact_solve.force_of(normal, start, free, 1.0, friction, rows)


def response(rng: np.random.Generator, along: float) -> Floats:
    """(3, 3) of strands that give way ``along`` themselves by so much, as a share of across."""
    axes = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    found: Floats = (axes * [1.0, 0.7, along]) @ axes.T
    return found


@pytest.mark.parametrize("friction", [0.0, 0.1, 0.5, 1.0, 3.0, 100.0])
@pytest.mark.parametrize("along", [1.0, 0.04, 1e-4])
def test_what_slides_obeys_coulombs_law(along: float, friction: float) -> None:
    """Both stay apart, friction is µ times the pressure, and opposes the way. Iterations for its direction leave it
    across the way where strands hardly give way along themselves."""
    rng = np.random.default_rng(1)
    slid = 0
    for _ in range(300):
        n = rng.normal(size=3)
        n /= np.linalg.norm(n)
        way, force = rng.normal(size=3), np.zeros(3)
        free = (1 - rng.uniform(0.0, 1.0)) * n + way - (way @ n) * n
        w = response(rng, along)
        force_of(np.array([n, n, free]), friction, w, force)
        push = force @ n
        drag = force - push * n
        left = free - n + w @ force
        assert left @ n == pytest.approx(0, abs=1e-6)
        assert push >= 0
        size = np.linalg.norm(drag)
        assert size <= friction * push * (1 + 1e-6) + 1e-12
        if np.linalg.norm(left) > 1e-6:
            slid += 1
            assert size == pytest.approx(friction * push, rel=1e-6)
            assert drag @ left == pytest.approx(-size * np.linalg.norm(left), rel=1e-6, abs=1e-9)
    assert slid > 0 or friction > 3


def ways_on_slopes(friction: float, rate: float, monkeypatch: pytest.MonkeyPatch) -> Floats:
    """(slopes,) metres that tips go within a second of strands laid across others, in the order of `incline.OFF`."""
    monkeypatch.setattr(incline, "MU", friction)
    track = track_of(incline.case(11), 1 / rate, 1.0, moving=True)
    tips = track.positions[:, :: 1 + len(incline.RAILS), -1]
    found: Floats = np.linalg.norm(tips - tips[0], axis=-1).max(0)
    return found


@pytest.mark.parametrize("rate", [24, 240])
@pytest.mark.parametrize("friction", [0.4, 1.0, 1.5])
def test_strands_stick_at_once_to_slopes_that_are_flat_enough(
    friction: float, rate: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where friction did not oppose the way, tips slid by 7 to 26 mm at first."""
    ways = ways_on_slopes(friction, rate, monkeypatch)
    off = np.array(incline.OFF)
    assert ways[off < -1].max() < 2.5e-4
    assert ways[off < 0].max() < 6e-4
    assert ways[off > 0].min() > 5e-3


BUNDLE = (
    "rod: {{rest: straight, radius: 5.0e-4, young: 1.0e+7, drag: 1}}\ntime: {{fps: 24}}\n"
    "emitter: {{shape: {{kind: disc, radius: {radius}}}, strands: {strands}, particles: {particles}, length: 0.2, "
    "jitter: {jitter}, keys: [{keys}]}}\n"
    "rules: [emitter_motion, gravity, contact: {{thickness: 0.0015}}]"
)


def test_a_dense_bundle_is_shaken_without_cutting_steps(steps: list[tuple[Floats, Floats]]) -> None:
    """Forty strands from one square centimetre, some closer than their thickness at the roots.
    Rounds converge in whole steps, and what roots hold too close only comes apart."""
    keys = "{time: 0, rotation: [180, 0, 0]}, {time: 0.25, rotation: [180, 0, 0], position: [0.1, 0, 0]}"
    text = BUNDLE.format(radius=0.00564, strands=40, particles=13, jitter=0, keys=keys)
    solver = rod_of(text)
    deep = []
    for frame in range(2, 8):
        solver.advance(frame)
        deep.append(solver.errors(frame)["strand_penetration_max"])
    assert len(steps) <= 8
    assert (
        np.diff(np.array(deep, float)).max() < 0.01 * 0.0015
    )  # what roots hold too close is led apart, and nothing comes closer


def test_rounds_that_do_not_converge_cut_the_step() -> None:
    """Twelve strands shaken and turned: once those are apart whose roots are too close, no frame leaves any a fifth of
    their thickness too close. Steps that are not cut let strands through each other."""
    keys = "{time: 0, rotation: [180, 0, 0]}, {time: 0.2, rotation: [180, 0, 0], position: [0.3, 0, 0]}, "
    keys += "{time: 0.4, rotation: [180, 40, 0]}"
    solver = rod_of(BUNDLE.format(radius=0.00564 * 0.3**0.5, strands=12, particles=13, jitter=0, keys=keys))
    for frame in range(2, 14):
        solver.advance(frame)
        assert frame < 7 or float(solver.errors(frame)["strand_penetration_max"] or 0) < 0.2 * 0.0015


@pytest.mark.parametrize(
    ("count", "frames", "share"), [(50, 8, 0.5), pytest.param(1000, 4, 1.0, marks=pytest.mark.long)]
)
def test_many_strands_that_begin_inside_each_other_are_led_apart(
    count: int, frames: int, share: float, steps: list[tuple[Floats, Floats]]
) -> None:
    """Roots so dense that strands are inside of up to twenty others, and their weight draws tips together: nothing is
    shot out, no step is cut into many, for rounds do not diverge, and half as many tips come close as without contact
    in the same time. A thousand come apart over seconds: here no more of them come close."""
    radius = 0.01 * np.sqrt(count / 1000)
    text = BUNDLE.format(radius=radius, strands=count, particles=4, jitter=3, keys="{time: 0, rotation: [180, 0, 0]}")
    solver = rod_of(text)
    past = solver.particles()
    for frame in range(2, frames + 1):
        solver.advance(frame)
        now = solver.particles()
        assert np.abs(now - past).max() < 0.5 * 9.81 / 24**2  # as far as weight alone moves what is at rest
        past = now
    assert solver.errors(frames)["nonfinite"] == 0
    assert len(steps) <= 4 * frames
    alone = rod_of(text.replace(", contact: {thickness: 0.0015}", ""))
    alone.advance(frames)
    assert close_tips(past) < share * close_tips(alone.particles())


def close_tips(x: NDArray[Any]) -> int:
    """Pairs of tips that are closer than half of a thickness of BUNDLE's."""
    tips = x[:, -1].astype(float)
    apart = np.linalg.norm(tips[:, None] - tips[None], axis=2)
    return int((apart[np.triu_indices(len(tips), 1)] < 0.00075).sum())


def test_contact_without_friction_adds_no_energy() -> None:
    """Two crossed strands, one of which falls on the other: kinetic and potential energy, and that of bending, never
    grow above the least so far by more than .002 of gL. BDF2, which does not damp, leaves a wave of
    .0009 of it at 24 steps a second; at others and of other stiffness up to .0055."""
    groom = strands([[-0.1, -0.02, 0], [0, 0.05, -0.5]], [[1, 0, 0], [0, 0, 1]], [0.2, 1])
    text = CROSS.format(young="5.0e+9") + RULE.format(d=0.01).replace("friction: 0.5", "friction: 0")
    solver = rod_of(text, groom)
    lengths = groom.lengths.astype(float) / 10
    stiffness = solver.material.stiffness[0, :2].astype(float)

    def energy() -> float:
        x = solver.particles().astype(float)
        v = solver.state.velocity.reshape(1, 10, 3, PACK)[0, :, :, :2].astype(float)
        edges = np.diff(x, axis=1)
        begin = groom.directions.astype(float)[:, None] * lengths[:, None, None]
        bends = np.diff(np.concatenate([begin, edges], 1), axis=1)
        mass, joint = solver.mass.astype(float), solver.material.joint.astype(float)
        moving = np.einsum("j,jcs,s->", mass, v**2, lengths) / 2
        height = 9.81 * np.einsum("j,sj,s->", mass, x[:, 1:, 1], lengths)
        bent = np.einsum("j,s,sjc,s->", joint, stiffness, bends**2, lengths) / 2
        return float(moving + height + bent)

    past, touched = energy(), False
    for frame in range(2, 40):
        solver.advance(frame)
        touched = touched or bool(solver.state.acceleration.any())
        now = energy()
        assert now <= past + 2e-3 * 9.81
        past = min(past, now)
    assert touched


def test_tips_that_a_solid_holds_by_friction_keep_apart() -> None:
    """Bristles of the preset `brush` pressed on its ball: without forces that grow where friction on the ball hides
    them, tips come closer from step to step, by a half of their thickness in frames 11 to 13."""
    solver = at_first_frame(load("brush"))
    deep = []
    for frame in range(2, 14):
        solver.advance(frame)
        deep.append(float(solver.errors(frame)["strand_penetration_max"] or 0))
    assert max(deep) < 0.15 * 0.001


def test_strands_that_are_too_close_are_told_of() -> None:
    """Of two strands that begin across each other, by a restart too."""
    groom = strands([[0.0, 0, 0], [0.1, 0, 0.0002]], [[1, -1, 0], [-1, -1, 0]], [0.2, 0.2])
    text = "rod: {radius: 2.0e-4, young: 1.0e+7}\nemitter: {strands: 2, particles: 9, length: 0.2}\n"
    text += "time: {fps: 24}\nrules: [gravity, contact: {thickness: 0.002}]"
    solver, again = rod_of(text, groom), rod_of(text, groom)
    assert interpenetration(solver, 1, solver.errors(1)) == ""
    solver.advance(2)
    again.restore(solver.state_arrays())
    for one in (solver, again):
        words = interpenetration(one, 2, one.errors(2))
        assert "frame 2: strands are 0.0017 m closer than contact.thickness, 0.002 m" in words
        assert "time.preroll" in words
