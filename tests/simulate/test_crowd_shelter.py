"""Strands that shelter each other from wind."""

from __future__ import annotations

import numpy as np
import pytest

from strandcli.simulate.kernels import crowd_shelter
from strandcli.simulate.kernels.crowd_records import MASS
from tests.simulate.test_crowd import solver_of


@pytest.mark.parametrize("way", [(1.0, 0.0, 0.0), (0.0, 0.0, -1.0), (0.6, -0.8, 0.0)])
def test_wind_fades_exponentially_in_an_even_layer(way: tuple[float, float, float]) -> None:
    """exp(−n d s) after a way s, from where it has entered."""
    side, stop = 24, 0.05
    box = np.array([0, 0, 0, side, side, side, 0])
    grid, left = np.zeros((side**3, 4), np.float32), np.empty(side**3, np.float32)
    grid[:, MASS] = 1
    crowd_shelter.shelter(box, grid, np.array(way, np.float32), np.float32(stop), left)
    middle = left.reshape(side, side, side)[:: -1 if way[2] < 0 else 1][12, 12]
    at = np.arange(side)
    if way[2] < 0:
        assert left.reshape(side, side, side)[side - 1 - 10, 3, 4] == pytest.approx(np.exp(-stop * 10), rel=1e-3)
    elif way[1] == 0:
        np.testing.assert_allclose(middle, np.exp(-stop * at), rtol=2e-3)
    else:  # enters through the top where that is nearer
        ways = np.minimum(at / 0.6, (side - 1 - 12) / 0.8)
        np.testing.assert_allclose(middle, np.exp(-stop * ways), rtol=0.05)


def test_a_strand_in_the_lee_bends_less() -> None:
    """Of a row of tufts along the wind the first takes the most of it."""
    text = (
        "rod: {rest: straight, drag: 5}\nemitter: {shape: {kind: plane, width: 0.4, depth: 0.02}, strands: 900, "
        "particles: 7, length: 0.15}\nchildren: {count: 100}\n"
        "rules: [gravity, wind: {strength: 2}%s]"
    )
    bent = {}
    for rule in ("", ", interaction: {friction: 0, cell: 0.02, density: 1.0e+9}"):
        solver = solver_of(text % rule)
        solver.advance(12)
        x = solver.particles()
        lean = x[:, -1, 0] - x[:, 0, 0]
        bent[rule] = (lean[x[:, 0, 0] < -0.19].mean(), lean[x[:, 0, 0] > 0.1].mean())
    (first, last), (fresh, lee) = bent.values()
    assert last == pytest.approx(first, rel=0.05)
    assert fresh > 0.7 * first
    assert lee < 0.6 * last
