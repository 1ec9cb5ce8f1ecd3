"""Contact of many strands: bundles that are shaken, or begin inside each other."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from crossing_kit import strands
from rod_kit import rod_of
from strandcli.simulate.health import interpenetration
from strandcli.simulate.rod.kernels.arrays import PACK
from strandcli.study.bench import at_first_frame, load
from tests.simulate.test_strand_contact import CROSS, RULE, Floats

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
