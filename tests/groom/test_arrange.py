"""Neighbours are found, and stand together, and nobody who asks for strands by their number can tell."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from unittest.mock import patch

import numpy as np
import pytest
from numpy.typing import NDArray

from strand_kit import frames_of, groom_of, scene_of
from strandcli.constants import VECTOR
from strandcli.groom.blocks import LEAF, arranged, spatial_order
from strandcli.groom.family import nearest_of
from strandcli.simulate.rod.solver import RodSolver

SCENE = """
emitter: {strands: 700, particles: 4, shape: {kind: sphere, radius: 0.5}, length: 0.3, length_variation: 0.4, jitter: 9}
rules: [gravity]
camera: {position: [0, 0.3, 4]}
image: {size: [64, 48], resolver: sorted, aovs: [strand_id]}
material: {width: 0.01}
time: {fps: 10, frames: 3}
"""
CHILDREN = "children: {count: 5, clumps: [{size: 0.2, strength: 0.8}]}\n"
TIED = SCENE.replace("jitter: 9", "jitter: 9, tie: {position: [0.1, 0.45, 0.2], radius: 0.08, slack: 0.02}")
NEAR = "detail: {near: 1, fraction: 0.01}\n"


def sides(points: np.ndarray, together: int) -> float:
    """Mean of the longest sides of boxes about so many points in a row."""
    rows = points[: len(points) // together * together].reshape(-1, together, 3)
    return float(np.ptp(rows, axis=1).max(1).mean())


def test_so_many_in_a_row_are_near_each_other() -> None:
    """As near as squares that tile the sphere would have them, about, and 32 or 64 as well."""
    points = np.random.default_rng(1).normal(size=(5000, 3))
    points /= np.linalg.norm(points, axis=1)[:, None]
    found = points[spatial_order(points)]
    assert LEAF == VECTOR // 4  # single precision
    for together in (LEAF, 2 * LEAF, 4 * LEAF):
        assert sides(found, together) < 1.2 * np.sqrt(4 * np.pi * together / len(points))
    assert sides(points, LEAF) > 1.5


def test_what_strands_have_goes_with_them_and_back() -> None:
    groom = groom_of(scene_of(SCENE))
    once = arranged(groom)
    twice = arranged(once)
    for other in (once, twice):
        for name in ("roots", "directions", "lengths", "tones"):
            there, here = getattr(groom, name), getattr(other, name)
            np.testing.assert_array_equal(other.emitted(here), there)
            np.testing.assert_array_equal(other.placed(there), here)
        np.testing.assert_allclose(other.emitted(other.edge(1, 3)), groom.edge(1, 3))
    assert not np.array_equal(once.roots, groom.roots)
    # as well where they stand otherwise already
    p = np.random.default_rng(2).permutation(groom.strands).astype(np.int32)
    names = ("roots", "directions", "lengths", "tones")
    mixed = replace(groom, places=p, **{name: getattr(groom, name)[p] for name in names})
    np.testing.assert_array_equal(arranged(mixed).emitted(arranged(mixed).roots), groom.roots)
    tied = groom_of(scene_of(TIED))
    assert tied.grown is not None
    grown = arranged(tied).grown
    assert grown is not None
    np.testing.assert_array_equal(arranged(tied).emitted(grown), tied.grown)
    # neighbours are those that hang beside each other, which are simulated
    assert sides(arranged(tied).roots, LEAF) < 0.7 * sides(tied.roots[spatial_order(tied.grown)], LEAF)
    np.testing.assert_array_equal(groom.emitted(groom.lengths), groom.lengths)


def test_positions_are_taken_in_the_order_of_emission() -> None:
    scene = scene_of(SCENE + "solver: rod\n")
    groom = groom_of(scene)
    run, taken = RodSolver(scene, arranged(groom)), RodSolver(scene, arranged(groom))
    run.advance(3)
    taken.take(3, run.particles())
    np.testing.assert_array_equal(taken.positions, run.positions)
    np.testing.assert_allclose(run.particles()[:, 0], groom.roots, atol=1e-6)
    np.testing.assert_allclose(run.rest_lengths(), groom.lengths / 3, rtol=1e-6)
    run.state.residuals.reshape(-1)[: run.strands] = run.groom.places
    np.testing.assert_array_equal(run.strand_residuals(), np.arange(run.strands))


def test_pictures_are_the_same() -> None:
    """With all strands, with those that level of detail draws, where strands guide others, and where they are tied."""
    for text in (SCENE, SCENE + NEAR, SCENE + CHILDREN, SCENE + CHILDREN + NEAR, TIED, TIED + NEAR, TIED + CHILDREN):
        scene = scene_of(text)
        frame = frames_of(scene, 2)[0]
        with patch("strandcli.run.stages.arranged", lambda groom, ends: groom):
            plain = frames_of(scene, 2)[0]
        assert frame.report["counts"]["strands"] == plain.report["counts"]["strands"]
        assert np.abs(frame.image.astype(int) - plain.image).max() <= 1
        same = frame.aovs["strand_id"] == plain.aovs["strand_id"]
        assert same.mean() > 0.99  # what covers as much as another may give way to it
        assert (plain.aovs["strand_id"] >= 0).mean() > 0.02


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
