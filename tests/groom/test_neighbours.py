"""Nearest neighbours by a grid, against all distances."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from strandcli.groom.family import nearest_of

LOTS = np.random.default_rng(1)
PLACES: dict[str, Callable[[int], NDArray[np.floating]]] = {
    "a cloud": lambda n: LOTS.normal(size=(n, 4)),
    "a plane, far away": lambda n: LOTS.uniform(size=(n, 4)) * [30, 0, 50, 0] + [1000, 5, -2000, 0],
    "a line": lambda n: LOTS.uniform(size=(n, 4)) * [0, 7, 0, 0],
    "a point": lambda n: np.zeros((n, 4)) + LOTS.uniform(size=(n, 4)) * 1e-30,
    "two heaps": lambda n: LOTS.normal(size=(n, 4)) * 1e-3 + LOTS.integers(0, 2, (n, 1)) * [1e3, -1e3, 0, 0],
    "a sphere's halves, far apart": lambda n: _halves(LOTS.normal(size=(n, 3))),
    "with normals": lambda n: LOTS.normal(size=(n, 7)),
}


def _halves(points: NDArray[np.floating]) -> NDArray[np.floating]:
    points = points / np.linalg.norm(points, axis=1, keepdims=True)
    return np.column_stack([points, 10 * np.sign(points[:, 0])])


@pytest.mark.parametrize("kind", PLACES)
@pytest.mark.parametrize(("others", "many"), [(3, 3), (700, 4)])
def test_the_nearest_are_the_nearest(kind: str, others: int, many: int) -> None:
    points, among = (PLACES[kind](n).astype(np.float32) for n in (300, others))
    points[: others // 2] = among[: min(others // 2, 300)]  # some of them are where another one is
    points[-20:] += 3 * np.ptp(among, axis=0)  # and some beyond the grid
    found, squares = nearest_of(points, among, many)
    true = np.sort(((points[:, None].astype(np.float64) - among) ** 2).sum(2), axis=1)[:, :many]
    np.testing.assert_allclose(squares, true, rtol=1e-5, atol=1e-30)
    there = ((points[:, None].astype(np.float64) - among[found]) ** 2).sum(2)
    np.testing.assert_allclose(there, true, rtol=1e-5, atol=1e-30)
    assert all(len(set(row)) == many for row in found.tolist())
