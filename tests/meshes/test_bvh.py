"""Rays, nearest points and winding numbers, against all triangles one by one and against libigl."""

from __future__ import annotations

import igl
import numpy as np
import pytest

import mesh_kit as kit
from strandcli.jit import parallel, prange
from strandcli.meshes.bvh import Bvh, closest, make_bvh, moved
from strandcli.meshes.kernels.rays import RAYS, first_hit, first_hits
from strandcli.meshes.kernels.winding import winding
from strandcli.meshes.mesh import TriangleMesh

MESHES = ("bowl", "soup", "sliver")


@parallel
def cast(bvh, origins, directions, t_max, found, triangles):
    for i in prange(origins.shape[0]):
        ox, oy, oz = origins[i, 0], origins[i, 1], origins[i, 2]
        dx, dy, dz = directions[i, 0], directions[i, 1], directions[i, 2]
        found[i, 0], triangles[i], found[i, 1], found[i, 2] = first_hit(bvh, ox, oy, oz, dx, dy, dz, t_max)


@parallel
def wind(bvh, points, found):
    for i in prange(points.shape[0]):
        found[i] = winding(bvh, points[i, 0], points[i, 1], points[i, 2])


def rays(bvh: Bvh, origins: np.ndarray, directions: np.ndarray, t_max: float = np.inf) -> tuple[np.ndarray, ...]:
    """t, u, v; triangles."""
    count = origins.shape[0]
    found = np.empty((count, 3)), np.empty(count, np.int64)
    cast(bvh, origins, directions, t_max, *found)
    return found


@parallel
def cast_together(bvh, packets, found):
    for i in prange(packets.shape[0]):
        first_hits(bvh, packets[i], found[i])


def tree(mesh: TriangleMesh) -> Bvh:
    return make_bvh(mesh.vertices, mesh.triangles)


@pytest.mark.parametrize("name", MESHES[:-1])
def test_first_hits_are_those_of_all_triangles(name: str) -> None:
    mesh = kit.mesh(name)
    generator = np.random.default_rng(1)
    origins, directions = generator.normal(size=(2, 400, 3))
    aims = mesh.vertices[mesh.triangles[generator.integers(mesh.triangles.shape[0], size=200)]]
    directions[200:] = np.einsum("rk,rkj->rj", generator.dirichlet(np.ones(3), 200), aims) - origins[200:]
    directions[:40] = 0.0
    directions[np.arange(40), np.arange(40) % 3] = np.where(np.arange(40) % 2, 1.0, -2.0)
    found, triangles = rays(tree(mesh), origins, directions)
    t, u, v = kit.all_hits(mesh, origins, directions)
    first = t.min(axis=1)
    assert np.array_equal(np.isfinite(found[:, 0]), np.isfinite(first))
    met = np.isfinite(first)
    assert 200 <= met.sum() < 400
    np.testing.assert_allclose(found[met, 0], first[met], rtol=1e-9, atol=1e-12)
    rows = np.flatnonzero(met), triangles[met]
    np.testing.assert_allclose(t[rows], first[met], rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(found[met, 1:], np.stack([u[rows], v[rows]], axis=1), atol=1e-6)
    assert (triangles[~met] == -1).all()


@pytest.mark.parametrize("name", MESHES[:-1])
def test_rays_that_go_together_hit_what_each_hits(name: str) -> None:
    mesh = kit.mesh(name)
    generator = np.random.default_rng(2)
    origins, directions = np.repeat(generator.normal(size=(2, 60, 3)), RAYS, axis=1)
    aims = mesh.vertices[mesh.triangles[generator.integers(mesh.triangles.shape[0], size=60)]].mean(axis=1)
    directions[::2] = np.repeat(aims, RAYS, axis=0)[::2] - origins[::2]
    directions += 0.03 * generator.normal(size=directions.shape)
    directions[:RAYS, :2] = 0.0
    bvh = tree(mesh)
    alone = rays(bvh, origins, directions)[0][:, 0].reshape(-1, RAYS)
    limits = np.full((60, RAYS), np.inf)
    limits[:, 3], limits[::2, 7] = -1.0, 0.5
    limits[:, 5] = alone[:, 5]
    packets = np.concatenate([origins.reshape(60, RAYS, 3), directions.reshape(60, RAYS, 3)], axis=2)
    found = limits.copy()
    cast_together(bvh, np.ascontiguousarray(packets.transpose(0, 2, 1)).reshape(60, -1), found)
    assert np.isfinite(alone).sum() > 100
    assert np.array_equal(found, np.where(limits < 0, limits, np.minimum(alone, limits)))


def test_no_ray_slips_through_an_edge_or_a_corner() -> None:
    """Rays from the middle of a closed mesh that are aimed at its corners and at points of its edges."""
    mesh = kit.mesh("ball")
    ends = mesh.vertices[mesh.triangles[:, (0, 1)]]
    generator = np.random.default_rng(2)
    share = generator.random((ends.shape[0], 1))
    aims = np.concatenate([mesh.vertices, ends[:, 0] + share * (ends[:, 1] - ends[:, 0])])
    for origin in (np.zeros(3), generator.uniform(-0.3, 0.3, 3)):
        directions = aims - origin
        found, _ = rays(tree(mesh), np.tile(origin, (aims.shape[0], 1)), directions)
        np.testing.assert_allclose(found[:, 0], 1.0, rtol=1e-9)


def test_rays_exactly_at_edges_and_corners_meet_a_triangle() -> None:
    """From within a box and from outside: its corners, middles of its edges, diagonals of its sides, without any
    rounding."""
    steps = np.array((-1.0, -0.5, 0.0, 0.5, 1.0))
    directions = np.stack(np.meshgrid(steps, steps, steps), axis=-1).reshape(-1, 3)
    directions = directions[np.abs(directions).max(axis=1) == 1.0]
    for origins, ways in ((0.0 * directions, directions), (2.0 * directions, -directions)):
        found, _ = rays(tree(kit.mesh("box")), origins, ways)
        assert (found[:, 0] == 1.0).all()


@pytest.mark.parametrize("name", MESHES)
def test_nearest_points_are_those_of_all_triangles(name: str) -> None:
    mesh = kit.mesh(name)
    points = np.random.default_rng(3).normal(size=(500, 3))
    found = closest(tree(mesh), points)
    squared, _, near = igl.point_mesh_squared_distance(points, mesh.vertices, mesh.triangles.astype(np.int64))
    np.testing.assert_allclose(np.abs(found.distances), np.sqrt(squared), rtol=1e-9, atol=1e-12)
    shares = found.barycentrics
    assert (shares >= -1e-12).all()
    np.testing.assert_allclose(shares.sum(axis=1), 1.0)
    of_corners = np.einsum("pk,pkj->pj", shares, mesh.vertices[mesh.triangles[found.triangles]])
    np.testing.assert_allclose(of_corners, found.points, atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(found.points - points, axis=1), np.sqrt(squared), rtol=1e-9, atol=1e-12)
    once = np.abs(np.linalg.norm(near - found.points, axis=1)) < 1e-9
    assert once.mean() > 0.9  # others are as near to two triangles


@pytest.mark.parametrize("name", MESHES)
def test_winding_numbers_are_those_of_all_triangles(name: str) -> None:
    mesh = kit.mesh(name)
    points = np.random.default_rng(4).normal(size=(500, 3))
    found = np.empty(500)
    wind(tree(mesh), points, found)
    whole = igl.winding_number(mesh.vertices, mesh.triangles.astype(np.int64), points)
    assert np.abs(found - whole).max() < (0.1 if name == "soup" else 0.06)
    if mesh.closed:
        assert np.array_equal(found > 0.5, whole > 0.5)


def test_a_tree_follows_its_vertices() -> None:
    mesh = kit.mesh("ball")
    vertices = mesh.vertices * (1.0, 2.0, 0.5) + (0.3, 0.0, -1.0)
    points = np.random.default_rng(5).normal(size=(300, 3))
    old, new = moved(tree(mesh), vertices, mesh.triangles), make_bvh(vertices, mesh.triangles)
    for one, other in zip(closest(old, points), closest(new, points), strict=True):
        np.testing.assert_allclose(one, other, atol=1e-12)


def test_triangles_at_one_place_make_a_tree() -> None:
    """No split parts them by place; a stack holds them all the same."""
    count = 4000
    vertices = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])
    bvh = make_bvh(vertices, np.tile(np.arange(3, dtype=np.int32), (count, 1)))
    found, triangle = rays(bvh, np.array([[0.2, 0.2, 1.0]]), np.array([[0.0, 0, -1]]))
    assert found[0, 0] == 1.0
    assert triangle[0] == 0
    assert closest(bvh, np.array([[0.2, 0.2, 3.0]])).triangles[0] == 0


@pytest.mark.parametrize("scale", [1e-44, 1e14])
def test_meshes_of_any_size(scale: float) -> None:
    """Also where boxes have no more than a few bits of single precision."""
    vertices, triangles = kit.sphere(2)
    points = np.random.default_rng(6).normal(size=(50, 3))
    found = closest(make_bvh(vertices * scale, triangles), points * scale)
    np.testing.assert_allclose(found.points / scale, closest(make_bvh(vertices, triangles), points).points, atol=1e-6)
