"""Strands with free roots on solids: they land, come to rest, and slide as Coulomb's law says, roots and all."""

from __future__ import annotations

import math

import numpy as np
import pytest

from loose_kit import LENGTH, SEGMENTS, G, Loose, groom_about
from strandcli.groom.record import Groom

FLOOR = "{kind: plane}"
MU = 0.4


def handful() -> Groom:
    """Strands of all directions above the origin."""
    rng = np.random.default_rng(2)
    middles = np.stack([rng.uniform(-0.1, 0.1, 14), rng.uniform(0.2, 0.4, 14), rng.uniform(-0.1, 0.1, 14)], 1)
    return groom_about(middles, rng.normal(size=(14, 3)))


@pytest.mark.long
@pytest.mark.parametrize("integrator", ["euler", "bdf2"])
def test_a_handful_that_is_dropped_comes_to_rest_on_the_floor(integrator: str) -> None:
    loose = Loose(handful(), "gravity, collision", f"integrator: {integrator}, friction: {MU}", FLOOR)
    loose.run(3.0)
    places = loose.places()
    assert places[..., 1].max() < 1e-3 * LENGTH
    assert places[..., 1].min() > -1e-6 * LENGTH
    loose.run(0.5)
    assert np.abs(loose.places() - places).max() < 1e-3 * LENGTH


@pytest.mark.long
def test_it_comes_to_rest_in_a_trough_of_two_slopes() -> None:
    """Ends lie on both slopes, roots on the one or on the other; deeper than rounding is none."""
    slopes = ", ".join(f"{{kind: plane, rotation: [0, 0, {angle}]}}" for angle in (30, -30))
    loose = Loose(handful(), "gravity, collision", f"drag: 0.5, friction: {MU}", slopes)
    loose.run(5.0)
    places = loose.places()
    assert (places[..., 1] - math.tan(math.radians(30)) * np.abs(places[..., 0])).min() > -1e-5 * LENGTH
    loose.run(0.5)
    assert np.abs(loose.places() - places).max() < 2e-3 * LENGTH


@pytest.mark.long
@pytest.mark.parametrize("way", [[1, 0, 0], [0, 0, 1], [1, 0, 1]])
def test_one_begins_to_slide_down_a_slope_at_the_angle_of_friction(way: list[float]) -> None:
    """Gravity leans, not the floor. Steeper by a degree the way is that of Coulomb's law, to a thousandth."""
    for beyond in (-1.0, 1.0):
        angle = math.atan(MU) + math.radians(beyond)
        down, onto = G * math.sin(angle), G * math.cos(angle)
        pull = f"gravity: {{acceleration: [{down}, {-onto}, 0]}}"
        loose = Loose(groom_about([[0, 0, 0]], [way]), f"{pull}, collision", f"drag: 0, friction: {MU}", FLOOR)
        start = loose.centre()
        loose.run(1.0)
        moved = loose.centre() - start
        assert moved[0, 0] == pytest.approx(max(down - MU * onto, 0.0) / 2, rel=2e-3, abs=1e-5 * LENGTH)
        assert np.abs(moved[0, 1:]).max() < 1e-5 * LENGTH


@pytest.mark.long
def test_a_floor_without_friction_leaves_momentum_along_it() -> None:
    """But for what edges are turned out of it by as they land, a hundredth of what the floor stops."""
    loose = Loose(
        groom_about([[0, 0.2, 0]], [[1, 1, 0.3]]),
        "gravity, collision",
        "drag: 0, friction: 0, integrator: euler",
        FLOOR,
    )
    loose.run(1 / 60)  # before the first step what is in solids is put out of them, and stopped
    loose.throw(np.broadcast_to([0.7, 0.0, -0.3], (1, SEGMENTS + 1, 3)))
    start = loose.momentum()[0]
    loose.run(1.0)
    assert loose.places()[..., 1].max() < 1e-3 * LENGTH
    np.testing.assert_allclose(loose.momentum()[0][[0, 2]], start[[0, 2]], atol=0.01 * LENGTH * math.sqrt(2 * G * 0.2))


@pytest.mark.long
def test_no_root_begins_in_a_solid() -> None:
    """Strands through the floor come out of it at once."""
    loose = Loose(groom_about([[0, 0.05, 0], [0.5, 0.1, 0]], [[0, 1, 0.2], [0, -1, 0.3]]), "collision", solids=FLOOR)
    loose.run(1 / 60)
    assert loose.places()[..., 1].min() > -1e-6 * LENGTH
