"""Grids of signed distances, against closed forms and libigl."""

from __future__ import annotations

import igl
import numba
import numpy as np
import pytest

import mesh_kit as kit
from strandcli.jit import function, parallel, prange
from strandcli.meshes.bvh import DistanceGrid, closest, make_bvh, make_distance_grid
from strandcli.meshes.kernels.distance import distance_and_gradient, vector_distance_and_gradient
from strandcli.meshes.mesh import TriangleMesh
from strandcli.simd import lane_count, load3, pointer, store, store3


@parallel
def look(grid, points, found):
    for i in prange(points.shape[0]):
        one = distance_and_gradient(grid, points[i, 0], points[i, 1], points[i, 2])
        for k in range(4):
            found[i, k] = one[k]


def distances(grid: DistanceGrid, points: np.ndarray) -> np.ndarray:
    """Distance and gradient at points (P, 4)."""
    found = np.empty((points.shape[0], 4))
    look(grid, points, found)
    return found


def nodes(grid: DistanceGrid) -> np.ndarray:
    """The places of all nodes (n, 3)."""
    axes = [grid.low[2 - k] + grid.spacing * np.arange(count) for k, count in enumerate(grid.values.shape)]
    z, y, x = np.meshgrid(*axes, indexing="ij")
    return np.stack([x.ravel(), y.ravel(), z.ravel()], axis=1).astype(np.float64)


def grid_of(mesh: TriangleMesh, resolution: int) -> DistanceGrid:
    return make_distance_grid(make_bvh(mesh.vertices, mesh.triangles), mesh.closed, resolution)


@pytest.mark.parametrize("name", ["ball", "bowl", "soup"])
def test_nodes_have_the_distance(name: str) -> None:
    mesh = kit.mesh(name)
    grid = grid_of(mesh, 40)
    points = nodes(grid)
    triangles = mesh.triangles.astype(np.int64)
    squared, _, _ = igl.point_mesh_squared_distance(points, mesh.vertices, triangles)
    found = grid.values.ravel()
    assert np.abs(np.abs(found) - np.sqrt(squared)).max() < 1e-6 * mesh.size()
    around = igl.winding_number(mesh.vertices, triangles, points)
    sure = (np.abs(around - 0.5) > (0.06 if name != "soup" else 0.1)) & (np.sqrt(squared) > 1e-5)
    assert np.array_equal((found < 0)[sure], (around > 0.5)[sure])
    assert sure.mean() > 0.6
    if mesh.closed:
        assert sure.mean() > 0.85  # nodes on the box itself have no sign


def test_any_number_of_threads_gives_the_same_bits() -> None:
    bvh = make_bvh(*kit.head(40))
    points = np.random.default_rng(1).normal(size=(1000, 3)) * 0.1
    found = []
    before = numba.get_num_threads()
    try:
        for count in range(1, numba.config.NUMBA_NUM_THREADS + 1):
            numba.set_num_threads(count)
            for closed in (True, False):
                found.append((make_distance_grid(bvh, closed, 40).values, *closest(bvh, points)))
    finally:
        numba.set_num_threads(before)
    for others in found[2:]:
        assert all(np.array_equal(one, other) for one, other in zip(found[0][1:], others[1:], strict=True))
    for k, others in enumerate(found):
        assert np.array_equal(others[0], found[k % 2][0])


def test_a_closed_mesh_has_the_same_signs_when_each_node_is_asked() -> None:
    bvh = make_bvh(*kit.head(40))
    assert np.array_equal(make_distance_grid(bvh, True, 40).values, make_distance_grid(bvh, False, 40).values)


def test_interpolation_errs_by_the_square_of_the_spacing() -> None:
    mesh = kit.mesh("ball")
    points = np.random.default_rng(1).normal(size=(20000, 3))
    points *= np.random.default_rng(2).uniform(0.5, 1.05, (20000, 1)) / np.linalg.norm(points, axis=1, keepdims=True)
    squared, _, _ = igl.point_mesh_squared_distance(points, mesh.vertices, mesh.triangles.astype(np.int64))
    errors = []
    for resolution in (24, 48):
        found = distances(grid_of(mesh, resolution), points)
        errors.append(np.sqrt(np.mean((np.abs(found[:, 0]) - np.sqrt(squared)) ** 2)))
        outward = points / np.linalg.norm(points, axis=1, keepdims=True)
        assert np.mean(np.sum(found[:, 1:] * outward, axis=1)) == pytest.approx(1.0, abs=0.02)
    assert errors[1] < 0.45 * errors[0]
    assert errors[0] < 4e-3


def test_gradients_are_those_of_the_distance() -> None:
    grid = grid_of(kit.mesh("box"), 24)
    points = np.random.default_rng(3).uniform(-2.5, 2.5, (2000, 3))
    step = 1e-5
    found = distances(grid, points)
    for k in range(3):
        ahead, behind = (distances(grid, points + s * np.eye(3)[k])[:, 0] for s in (step, -step))
        slope = (ahead - behind) / (2 * step)
        assert np.median(np.abs(slope - found[:, 1 + k])) < 1e-6
        assert np.mean(np.abs(slope - found[:, 1 + k]) < 1e-4) > 0.99  # others lie at a cell's side


def test_outside_of_the_grid_it_is_never_more_than_the_distance() -> None:
    mesh = kit.mesh("bowl")
    grid = grid_of(mesh, 32)
    points = np.random.default_rng(4).normal(size=(3000, 3)) * 3.0
    squared, _, _ = igl.point_mesh_squared_distance(points, mesh.vertices, mesh.triangles.astype(np.int64))
    low = grid.low
    high = low + grid.spacing * (np.array(grid.values.shape[::-1]) - 1)
    out = ((points < low) | (points > high)).any(axis=1)
    found = distances(grid, points)[:, 0]
    assert out.sum() > 1000
    assert (found[out] <= np.sqrt(squared[out]) + 1e-3).all()
    assert (found[out] > 0.6 * np.sqrt(squared[out])).all()


@function
def one_by_one(grid, points, found):
    for i in range(found.shape[1]):
        found[0, i], found[1, i], found[2, i], found[3, i] = distance_and_gradient(
            grid, points[0, i], points[1, i], points[2, i]
        )


@function
def in_vectors(grid, points, found):
    rows, out = pointer(points), pointer(found)
    for i in range(0, found.shape[1], lane_count(rows)):
        x, y, z = load3(rows, i, points.shape[1])
        d, gx, gy, gz = vector_distance_and_gradient(grid, x, y, z)
        store(out, i, d)
        store3(out, i + found.shape[1], found.shape[1], gx, gy, gz)


def test_vectors_have_the_bits_of_numbers() -> None:
    """Also outside of the grid, but for gradients; lanes that hold no point read nothing outside of it."""
    grid = grid_of(kit.mesh("bowl"), 32)
    points = (np.random.default_rng(5).normal(size=(3, 4096)) * 1.5).astype(np.float32)
    odd = [np.nan, np.inf, -np.inf, 1e38, -1e38, -0.0]
    points[:, : len(odd) ** 3] = np.stack(np.meshgrid(odd, odd, odd)).reshape(3, -1)
    found, expected = np.empty((2, 4, points.shape[1]), np.float32)
    in_vectors(grid, points, found)
    one_by_one(grid, points, expected)
    real = np.isfinite(expected[0]) & (np.abs(points) < 1e30).all(axis=0)
    assert real.sum() > 3000
    assert found[0, real].tobytes() == expected[0, real].tobytes()
    beyond = (np.abs(points) > 1.6).any(0)
    assert min((real & beyond).sum(), (real & ~beyond).sum()) > 500
    np.testing.assert_allclose(found[:, real], expected[:, real], rtol=1e-5, atol=1e-6)
