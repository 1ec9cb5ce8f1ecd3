"""What becomes of bare triangles: merged, turned, counted."""

from __future__ import annotations

import numpy as np
import pytest

import mesh_kit as kit
from strandcli.errors import UsageError
from strandcli.meshes.make import RawMesh, make_mesh, mesh_of
from strandcli.meshes.mesh import TriangleMesh


def volume(mesh: TriangleMesh) -> float:
    a, b, c = np.moveaxis(mesh.vertices[mesh.triangles], 1, 0)
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6)


def test_a_box_as_it_is() -> None:
    mesh = make_mesh(*kit.cube())
    assert mesh.closed
    assert mesh.notes == ()
    assert mesh.facts.parts == 1
    assert volume(mesh) == pytest.approx(8)
    np.testing.assert_allclose(mesh.normals, mesh.vertices / np.sqrt(3), atol=1e-12)  # weighted by angle: symmetric
    np.testing.assert_allclose(mesh.areas(), 2)
    assert mesh.size() == 2


@pytest.mark.parametrize("seed", range(2))
def test_mixed_winding_is_made_one_and_outward(seed: int) -> None:
    vertices, triangles = kit.sphere(2)
    generator = np.random.default_rng(seed)
    turned = generator.random(triangles.shape[0]) < generator.random()
    triangles = np.where(turned[:, None], triangles[:, ::-1], triangles)
    mesh = make_mesh(vertices, triangles)
    assert mesh.closed
    assert volume(mesh) == pytest.approx(3.81773, rel=1e-5)
    assert mesh.facts.turned == turned.sum()
    assert (np.einsum("ij,ij->i", mesh.face_normals(), mesh.vertices[mesh.triangles].mean(axis=1)) > 0).all()


def test_each_part_is_turned_outward() -> None:
    vertices, triangles = kit.sphere(1)
    both = np.concatenate([vertices, vertices + 5])
    mesh = make_mesh(both, np.concatenate([triangles, triangles[:, ::-1] + vertices.shape[0]]))
    assert mesh.facts.parts == 2
    assert mesh.facts.turned == triangles.shape[0]
    assert volume(mesh) == pytest.approx(2 * volume(make_mesh(vertices, triangles)))


def test_a_sheet_stays_as_most_of_it_is() -> None:
    vertices = np.array([[x, y, 0.0] for y in range(4) for x in range(4)])
    lower = np.array([(r * 4 + c, r * 4 + c + 1, r * 4 + c + 4) for r in range(3) for c in range(3)])
    upper = np.stack([lower[:, 1], lower[:, 2] + 1, lower[:, 2]], axis=1)
    triangles = np.concatenate([lower, upper])
    triangles[4] = triangles[4, ::-1]
    mesh = make_mesh(vertices, triangles)
    assert mesh.facts.turned == 1
    assert (mesh.face_normals()[:, 2] > 0).all()
    assert not mesh.closed
    assert (mesh.facts.boundary, mesh.facts.holes) == (12, 1)


def test_holes_are_counted() -> None:
    vertices, triangles = kit.sphere(3)
    high = np.abs(vertices[triangles, 2]) > 0.7
    mesh = make_mesh(vertices, triangles[~high.all(axis=1)])
    assert mesh.facts.holes == 2
    assert not mesh.closed
    assert any("2 holes" in note for note in mesh.notes)


def test_seams_are_merged_and_what_belongs_to_corners_stays() -> None:
    vertices, triangles = kit.cube()
    apart = vertices[triangles].reshape(-1, 3)
    generator = np.random.default_rng(1)
    uv = generator.random((12, 3, 2)).astype(np.float32)
    normals = np.repeat(make_mesh(vertices, triangles).face_normals(), 3, axis=0)
    raw = RawMesh(apart, np.arange(36).reshape(-1, 3), normals=normals, uv=uv, attributes={"density": apart[:, 0]})
    mesh = mesh_of(raw, "box")
    assert mesh.vertices.shape == (8, 3)
    assert mesh.closed
    assert mesh.facts.merged == 28
    assert np.array_equal(mesh.uv, uv)
    np.testing.assert_allclose(mesh.corner_normals, np.repeat(mesh.face_normals()[:, None], 3, axis=1), atol=1e-12)
    np.testing.assert_allclose(mesh.attributes["density"], mesh.vertices[:, 0])
    assert mesh.merge is not None
    np.testing.assert_array_equal(mesh.vertices[mesh.merge], apart)


def test_turned_triangles_take_their_corners_along() -> None:
    vertices, triangles = kit.cube()
    uv = np.arange(72.0).reshape(12, 3, 2)
    normals = vertices / np.sqrt(3)
    whole = mesh_of(RawMesh(vertices, triangles, normals=normals, uv=uv), "box")
    mixed, other = triangles.copy(), uv.copy()
    mixed[5:], other[5:] = triangles[5:, ::-1], uv[5:, ::-1]
    mesh = mesh_of(RawMesh(vertices, mixed, normals=normals, uv=other), "box")
    assert mesh.facts.turned == 7
    for t in range(12):
        one, two = whole.triangles[t].tolist(), mesh.triangles[t].tolist()
        turn = np.array([two.index(vertex) for vertex in one])
        assert np.array_equal(mesh.uv[t, turn], whole.uv[t])  # type: ignore[index]
        np.testing.assert_allclose(mesh.corner_normals[t, turn], whole.corner_normals[t])  # type: ignore[index]


def test_a_moebius_strip_has_no_outside_and_says_so() -> None:
    turns = np.arange(12) / 12 * 2 * np.pi
    across = np.stack([np.cos(turns / 2) * np.cos(turns), np.cos(turns / 2) * np.sin(turns), np.sin(turns / 2)], axis=1)
    middle = np.stack([np.cos(turns), np.sin(turns), 0 * turns], axis=1)
    vertices = np.stack([middle - 0.3 * across, middle + 0.3 * across], axis=1).reshape(-1, 3)
    triangles = []
    for k in range(12):
        a, b = 2 * k, 2 * k + 1
        c, d = (2 * k + 2, 2 * k + 3) if k < 11 else (1, 0)
        triangles += [(a, b, c), (b, d, c)]
    mesh = make_mesh(vertices, np.array(triangles))
    assert mesh.facts.twisted == 1
    assert mesh.facts.holes == 1
    assert any("outside" in note for note in mesh.notes)


@pytest.mark.parametrize(
    ("vertices", "triangles", "words"),
    [
        (np.zeros((0, 3)), np.zeros((0, 3), int), "no triangles"),
        (np.eye(3), np.zeros((0, 3), int), "no triangles"),
        (np.eye(3), [(0, 1, 3)], "wants vertex 3"),
        (np.eye(3), [(0, 1, -1)], "wants vertex -1"),
        (np.array([[0, 0, 0], [1, 0, 0], [np.nan, 0, 0]]), [(0, 1, 2)], "vertex 2 is (nan, 0, 0)"),
        (np.array([[0, 0, 0], [1, 0, 0], [0, np.inf, 0]]), [(0, 1, 2)], "(0, inf, 0)"),
        (np.array([[0, 0, 0], [1, 0, 0], [0, 1e16, 0]]), [(0, 1, 2)], "1e+16"),
        (np.array([[0, 0, 0], [1.0, 0, 0], [2, 0, 0]]), [(0, 1, 2)], "has an area"),
    ],
)
def test_what_is_no_mesh(vertices: np.ndarray, triangles: list, words: str) -> None:
    with pytest.raises(UsageError) as told:
        make_mesh(vertices, np.array(triangles), "a.obj")
    assert str(told.value).startswith("a.obj: ")
    assert words in str(told.value)


@pytest.mark.parametrize(
    "matrix", [np.diag((2.0, 3, 4)), np.diag((-1.0, 1, 1)), [[0.0, 1, 0], [0.5, 0, 0], [0, 0.2, 1]]]
)
def test_a_transformed_mesh_is_wound_and_shaded_outward(matrix: np.ndarray) -> None:
    vertices, triangles = kit.sphere(2)
    mesh = mesh_of(RawMesh(vertices, triangles, normals=vertices, uv=vertices[triangles][:, :, :2]), "ball")
    placed = mesh.transformed(np.array(matrix), np.array((1.0, 2, 3)))
    direct = make_mesh(vertices @ np.array(matrix).T + (1, 2, 3), triangles)
    assert volume(placed) == pytest.approx(volume(direct))
    assert volume(placed) > 0
    assert (np.einsum("ij,ij->i", placed.normals, direct.normals) > 0.97).all()
    faces = placed.face_normals()
    assert (np.einsum("tkj,tj->tk", placed.corner_normals, faces) > 0.3).all()
    back = np.linalg.solve(np.array(matrix), (placed.vertices[placed.triangles] - (1, 2, 3)).reshape(-1, 3).T).T
    np.testing.assert_allclose(placed.uv, back.reshape(-1, 3, 3)[:, :, :2], atol=1e-6)
