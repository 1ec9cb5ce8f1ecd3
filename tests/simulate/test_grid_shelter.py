"""Strands that shelter each other from wind."""

from __future__ import annotations

import numpy as np
import pytest

from strandcli.simulate.grid.kernels import shelter
from strandcli.simulate.grid.kernels.records import MASS
from tests.simulate.test_grid import solver_of


@pytest.mark.parametrize("way", [(1.0, 0.0, 0.0), (0.0, 0.0, -1.0), (0.6, -0.8, 0.0)])
def test_wind_fades_exponentially_in_an_even_layer(way: tuple[float, float, float]) -> None:
    """exp(−n d s) after a way s, from where it has entered."""
    side, stop = 32, 0.05
    box = np.array([0, 0, 0, side, side, side, 0])
    grid, left = np.zeros((4, side**3), np.float32), np.empty(side**3, np.float32)
    grid[MASS] = 1
    layers = np.empty((4, shelter.layer_size(side, side, side)), np.float32)
    shelter.shelter(box, grid[MASS], np.array(way, np.float32), np.float32(stop), left, layers)
    cells = left.reshape(side, side, side)  # z, y, x, but where the wind blows along x: x, z, y
    if abs(way[0]) > abs(way[1]):
        cells = cells.transpose(1, 2, 0)
    at = np.arange(side)
    if way[2] < 0:
        assert cells[side - 1 - 10, 3, 4] == pytest.approx(np.exp(-stop * 10), rel=1e-3)
    elif way[1] == 0:
        np.testing.assert_allclose(cells[12, 12], np.exp(-stop * at), rtol=1e-3)
    else:  # enters through the top where that is nearer
        ways = np.minimum(at / 0.6, (side - 1 - 12) / 0.8)
        np.testing.assert_allclose(cells[12, 12], np.exp(-stop * ways), rtol=0.05)


def test_a_strand_in_the_lee_bends_less() -> None:
    """Of a row of tufts along the wind the first takes the most of it, once they have come to rest."""
    text = (
        "rod: {rest: straight, drag: 5}\nemitter: {shape: {kind: plane, width: 0.4, depth: 0.02}, strands: 900, "
        "particles: 7, length: 0.15}\nchildren: {count: 100}\n"
        "rules: [gravity, wind: {strength: 2}%s]"
    )
    bent = {}
    for rule in ("", ", interaction: {friction: 0, cell: 0.02, density: 1.0e+9}"):
        solver = solver_of(text % rule)
        solver.advance(72)
        x = solver.particles()
        lean = x[:, -1, 0] - x[:, 0, 0]
        bent[rule] = (lean[x[:, 0, 0] < -0.19].mean(), lean[x[:, 0, 0] > 0.1].mean())
    (first, last), (fresh, lee) = bent.values()
    assert last == pytest.approx(first, rel=0.05)
    assert fresh > 0.7 * first
    assert lee < 0.6 * last
