"""Strands in contact: what they lose of a swing, that they do not spring back, and friction of those that slide."""

from __future__ import annotations

import numpy as np
import pytest

from rod_kit import rod_of
from strand_kit import scene_of
from strandcli.groom.emit import emit
from strandcli.jit import function
from strandcli.simulate.contact.kernels import contact_solve
from strandcli.simulate.rod.kernels.arrays import PACK
from strandcli.simulate.rod.solver import RodSolver
from strandcli.study.references import incline, track_of
from tests.simulate.test_strand_contact import CROSS, RULE, Floats, laid_pair, strands

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
