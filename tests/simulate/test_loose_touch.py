"""Strands with free roots that touch: they lie on each other, slide as Coulomb's law says, and pass through none."""

from __future__ import annotations

import math

import numpy as np
import pytest

from crossing_kit import crossings
from loose_kit import LENGTH, SEGMENTS, G, Loose, groom_about

MU, THICKNESS = 0.4, 0.002
FLOOR = "{kind: plane}"


@pytest.mark.long
@pytest.mark.parametrize("integrator", ["euler", "bdf2"])
def test_one_that_lies_across_others_begins_to_slide_at_the_angle_of_friction(integrator: str) -> None:
    """Three lead down a slope that holds them, and one lies across. A degree beyond the angle it slides as Coulomb's
    law says, to a twentieth; a degree below, hardly."""
    middles, ways = [[0, 0, z] for z in (-0.1, 0.0, 0.1)] + [[0, THICKNESS, 0]], [[1, 0, 0]] * 3 + [[0, 0, 1]]
    touch = f"contact: {{thickness: {THICKNESS}, friction: {MU}}}"
    for beyond in (-1.0, 1.0):
        angle = math.atan(MU) + math.radians(beyond)
        down, onto = G * math.sin(angle), G * math.cos(angle)
        pull = f"gravity: {{acceleration: [{down}, {-onto}, 0]}}"
        rod = f"drag: 0, friction: 10, integrator: {integrator}"
        loose = Loose(groom_about(middles, ways), f"{pull}, {touch}, collision", rod, FLOOR)
        start = loose.centre()
        loose.run(1.0)
        moved = loose.centre() - start
        assert moved[3, 0] == pytest.approx(max(down - MU * onto, 0.0) / 2, rel=0.05, abs=1e-3 * LENGTH)
        assert np.abs(moved[:3]).max() < 1e-5 * LENGTH


@pytest.mark.long
def test_a_pile_of_sticks_comes_to_rest_and_none_passes_through_another() -> None:
    count = 8
    rng = np.random.default_rng(3)
    turn = rng.uniform(0, np.pi, count)
    middles = np.stack(
        [rng.uniform(-0.03, 0.03, count), 0.05 + 0.02 * np.arange(count), rng.uniform(-0.03, 0.03, count)], 1
    )
    ways = np.stack([np.cos(turn), rng.uniform(-0.1, 0.1, count), np.sin(turn)], 1)
    touch = f"contact: {{thickness: {THICKNESS}, friction: {MU}}}"
    loose = Loose(groom_about(middles, ways), f"gravity, {touch}, collision", f"drag: 0.5, friction: {MU}", FLOOR)
    worst = 0.0
    before = loose.places()
    for _ in range(120):
        loose.run(1 / 60)
        after = loose.places()
        assert crossings(before, after) == 0
        worst, before = max(worst, loose.solver.errors(1)["strand_penetration_max"] or 0.0), after
    assert worst < 0.1 * THICKNESS
    assert before[..., 1].min() > -1e-5 * LENGTH
    assert before[..., 1].max() > 2 * THICKNESS  # a pile
    loose.run(0.5)
    assert np.abs(loose.places() - before).max() < 0.02 * LENGTH


@pytest.mark.long
@pytest.mark.parametrize("integrator", ["euler", "bdf2"])
def test_two_that_hit_each_other_in_flight_keep_momentum(integrator: str) -> None:
    """One flies across the end of another, near its root, which nothing holds: both turn."""
    touch = f"contact: {{thickness: {THICKNESS}, friction: {MU}}}"
    middles = [[0, 0, 0], [-0.9 * LENGTH / 2, 0.05, 0]]
    still = "gravity: {acceleration: [0, 0, 0]}"
    rod = f"drag: 0, integrator: {integrator}"
    loose = Loose(groom_about(middles, [[1, 0, 0], [0, 0, 1]]), f"{still}, {touch}", rod)
    thrown = np.zeros((2, SEGMENTS + 1, 3))
    thrown[1, :, 1] = -1.0
    loose.throw(thrown)
    push, turn = loose.momentum()
    loose.run(0.5)
    after = loose.momentum()
    assert np.linalg.norm(after[0] - push) < 1e-10 * np.linalg.norm(push)
    assert np.linalg.norm(after[1] - turn) < 0.05 * np.linalg.norm(turn)
    ways = loose.places()[:, -1] - loose.places()[:, 0]
    assert ways[0, 1] / LENGTH > 0.1  # its root was hit
