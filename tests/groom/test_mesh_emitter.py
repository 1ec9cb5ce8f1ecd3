"""Strands that grow on meshes: where, how many a square metre, which way and how long."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import mesh_kit
from mesh_kit import sphere
from scene_kit import scene
from strand_kit import frames_of
from strandcli.compiling import runtime
from strandcli.errors import UsageError
from strandcli.groom.blocks import arranged
from strandcli.groom.children import Children
from strandcli.groom.emit import emit
from strandcli.groom.on_mesh import at_anchors, described, notes, seedbed
from strandcli.groom.record import Groom
from strandcli.meshes.bvh import closest, make_bvh
from strandcli.meshes.mesh import TriangleMesh
from strandcli.scene.model import Emitter, MeshShape

COUNT = 20_000


def write(path: Path, vertices: np.ndarray, triangles: np.ndarray, **attributes: np.ndarray) -> str:
    """A .ply file of a mesh with a number for each attribute, three for one of three columns."""
    more = {}
    for name, values in attributes.items():
        more |= {name: values} if values.ndim == 1 else dict(zip((f"{name}_{c}" for c in "xyz"), values.T, strict=True))
    path.write_bytes(mesh_kit.ply(TriangleMesh(vertices, triangles.astype(np.int32), vertices), more=more))
    return str(path)


@pytest.fixture
def ball(tmp_path: Path) -> str:
    vertices, triangles = sphere()
    return write(
        tmp_path / "ball.ply", vertices, triangles,
        upper=(vertices[:, 1] > 0).astype(float), ramp=0.5 + 0.5 * vertices[:, 1], nothing=np.zeros(len(vertices)),
        way=np.stack([-vertices[:, 2], 0 * vertices[:, 0], vertices[:, 0]], axis=1),
    )  # fmt: skip


def textured(path: Path, uv: bool = True) -> str:
    """A square from 0 to 1 in x and z, as .obj, whose picture lies on it."""
    corners = np.array([(0, 0, 0), (0, 0, 1), (1, 0, 1), (1, 0, 0)])
    return str(mesh_kit.write(path, corners, np.array([(0, 1, 2), (0, 2, 3)]), uv=corners[:, ::2] if uv else None))


def grown(file: str, seed: int = 1, count: int | None = None, **settings: object) -> Groom:
    emitter = {key: settings.pop(key) for key in ("lift", "jitter") if key in settings}
    shape = MeshShape(file=file, **settings)  # type: ignore[arg-type]
    return emit(Emitter(shape=shape, strands=COUNT, **emitter), seed, count)  # type: ignore[arg-type]


def test_roots_lie_on_their_triangles(ball: str) -> None:
    groom = grown(ball)
    mesh = seedbed(MeshShape(file=ball)).mesh
    anchors = groom.anchors
    assert (anchors.shares >= 0).all()
    np.testing.assert_allclose(anchors.shares.sum(axis=1), 1, atol=1e-12)
    np.testing.assert_allclose(at_anchors(mesh, anchors)[0], groom.roots, atol=1e-6)
    found = closest(make_bvh(mesh.vertices, mesh.triangles), groom.roots)
    assert np.abs(found.distances).max() < 1e-6
    np.testing.assert_allclose(groom.directions, groom.roots, atol=0.02)  # normals of a ball, smooth


@pytest.mark.parametrize("density", ["", "ramp"])
def test_strands_are_spread_by_area_and_density(ball: str, density: str) -> None:
    """Chi-square over bands of height and sectors, whose expected numbers are integrals over the triangles; even
    sequences stay far below what random ones would have."""
    bed = seedbed(MeshShape(file=ball))
    corners = bed.mesh.vertices[bed.mesh.triangles]
    areas = bed.mesh.areas()
    mean = np.ones(len(areas)) if not density else (0.5 + 0.5 * corners[:, :, 1]).mean(axis=1)

    def region(points: np.ndarray) -> np.ndarray:
        turn = np.floor((np.arctan2(points[:, 2], points[:, 0]) / np.pi + 1) * 2).astype(int) % 4
        return 2 * turn + (points[:, 1] > 0)

    # edges of the ball's mesh lie on the borders of its octants
    expected = np.bincount(region(corners.mean(axis=1)), areas * mean, 8)
    expected *= COUNT / expected.sum()
    found = np.bincount(region(grown(ball, density=density).roots.astype(np.float64)), minlength=8)
    assert ((found - expected) ** 2 / expected).sum() < 18.48  # of 7 degrees of freedom, exceeded once in a hundred


def test_density_is_linear_on_a_triangle(tmp_path: Path) -> None:
    """On one triangle with densities 0, 0 and 1 the shares of the third corner are as x (1 − x)."""
    vertices = np.array([[0.0, 0, 0], [2, 0, 0], [0, 0, -3]])
    file = write(tmp_path / "one.ply", vertices, np.array([[0, 1, 2]]), ramp=np.array([0.0, 0, 1]))
    groom = grown(file, density="ramp")
    third = np.sort(groom.anchors.shares[:, np.argmin(seedbed(MeshShape(file=file)).mesh.vertices[:, 2])])
    exact = third**2 * (3 - 2 * third)
    assert np.abs(exact - (np.arange(COUNT) + 0.5) / COUNT).max() < 0.005


def test_nothing_grows_where_density_is_0(ball: str) -> None:
    roots = grown(ball, density="upper").roots
    mesh = seedbed(MeshShape(file=ball)).mesh
    lowest = mesh.vertices[mesh.triangles][(mesh.vertices[mesh.triangles][:, :, 1] > 0).any(axis=1)][:, :, 1].min()
    assert roots[:, 1].min() >= lowest
    bed = seedbed(MeshShape(file=ball, density="upper"))
    assert bed.used < len(mesh.triangles)
    assert bed.even <= bed.grown <= bed.area


def test_pictures_spread_and_shorten(tmp_path: Path) -> None:
    square = textured(tmp_path / "square.obj")
    picture = np.zeros((8, 8), np.uint8)
    picture[:, 4:] = 255  # right half: x > 0.5
    picture[:4] //= 2  # top rows: z > 0.5, where v is 1
    Image.fromarray(picture).save(tmp_path / "map.png")
    name = str(tmp_path / "map.png")
    roots = grown(square, density=name).roots
    # a texel away from the bright half; pictures are repeated, so that the first column begins where the last one ends
    assert not ((roots[:, 0] > 1 / 8) & (roots[:, 0] < 3 / 8)).any()
    assert (roots[:, 0] > 0.5).mean() > 0.85
    inner = roots[roots[:, 0] > 0.6]
    near, far = (np.abs(inner[:, 2] - middle) < 0.15 for middle in (0.25, 0.75))
    assert far.sum() / near.sum() == pytest.approx(127 / 255, rel=0.03)
    lengths = grown(square, length=name)
    x, _, z = np.abs(lengths.roots - [0.75, 0, 0.25]).T
    np.testing.assert_allclose(lengths.lengths[(x < 0.15) & (z < 0.15)], 1.0, atol=1e-6)
    x = np.abs(lengths.roots[:, 0] - 0.25)
    np.testing.assert_allclose(lengths.lengths[x < 0.15], 0.02, atol=1e-6)


def test_lengths_and_combing_are_those_of_the_vertices(ball: str) -> None:
    groom = grown(ball, length="ramp")
    np.testing.assert_allclose(groom.lengths, np.maximum(0.5 + 0.5 * groom.roots[:, 1], 0.02), atol=1e-5)
    roots = (groom := grown(ball, comb="way", lift=0.0)).roots.astype(np.float64)
    around = np.stack([-roots[:, 2], 0 * roots[:, 0], roots[:, 0]], axis=1)
    off_pole = np.linalg.norm(around, axis=1) > 0.3
    along = (groom.directions * around).sum(axis=1) / np.linalg.norm(around, axis=1)
    assert along[off_pole].min() > 0.999
    both = grown(ball, comb="way", lift=30.0)
    sine = (both.directions * both.roots).sum(axis=1) / np.linalg.norm(both.roots, axis=1)
    assert np.median(np.degrees(np.arcsin(sine))) == pytest.approx(30, abs=0.5)
    turned = grown(ball, comb="way", lift=0.0, up="z")
    x, y, _ = turned.roots.astype(np.float64).T
    way = np.stack([-y, x, 0 * x], axis=1)  # about −z, which was y
    ring = np.hypot(x, y) > 0.3
    along = (turned.directions * way).sum(axis=1) / np.maximum(np.linalg.norm(way, axis=1), 1e-9)
    assert np.abs(along[ring]).min() > 0.999


def test_strands_depend_on_the_seed_and_their_number_alone(ball: str) -> None:
    many = grown(ball, 3, length="ramp", density="ramp", jitter=20.0)
    few = grown(ball, 3, 777, length="ramp", density="ramp", jitter=20.0)
    for name in ("roots", "directions", "lengths", "tones"):
        np.testing.assert_array_equal(getattr(few, name), getattr(many, name)[:777])
    with runtime.thread_count(1):
        single = grown(ball, 3, density="ramp")
    np.testing.assert_array_equal(single.roots, many.roots)
    assert (grown(ball, 4).roots != grown(ball, 5).roots).any(axis=1).all()


def test_children_root_on_the_mesh_and_not_across_a_sheet(tmp_path: Path) -> None:
    """A thin plate, whose sides face away from each other: children of one side follow guides of that side."""
    x = np.linspace(0, 1, 9)
    flat = np.array([[a, 0.0, b] for a in x for b in x])
    cells = [(9 * i + j, 9 * i + j + 1, 9 * i + j + 10, 9 * i + j + 9) for i in range(8) for j in range(8)]
    top = np.array([t for a, b, c, d in cells for t in ((a, b, c), (a, c, d))])
    lift = np.array([0, 0.002, 0])
    file = write(tmp_path / "plate.ply", np.concatenate([flat + lift, flat]), np.concatenate([top, top[:, ::-1] + 81]))
    made = scene(
        f"emitter: {{shape: {{kind: mesh, file: {file}}}, strands: 200, particles: 4, length: 0.1}}\n"
        "children: {count: 5}\n"
    )
    guides = arranged(emit(made.emitter, made.seed))
    family = Children(made, guides).family
    own = Children(made, guides).every
    sides = np.sign(own.directions[family.ids, 1])
    of_guides = np.sign(guides.directions[:, 1])[family.parents]
    assert np.abs(sides).min() == 1
    assert ((of_guides == sides[:, None]) | (family.weights == 0)).all()
    assert np.abs(own.roots[family.ids, 1] - np.where(sides > 0, 0.002, 0)).max() < 1e-6


def test_plan_tells_area_triangles_and_density(ball: str) -> None:
    area = float(seedbed(MeshShape(file=ball)).mesh.areas().sum())
    text = described(MeshShape(file=ball), COUNT)
    assert text == f"{area:.3g} m² of 512 triangles; {COUNT / area / 1e4:.3g} strands a cm²"
    assert "on 2" in described(MeshShape(file=ball, density="upper"), COUNT)


def test_another_unit_is_told(ball: str) -> None:
    def said(scale: float) -> list[str]:
        return notes(Emitter(shape=MeshShape(file=ball, scale=scale), length=0.1))

    assert said(1.0) == []
    for scale in (100.0, 0.001):
        assert "another unit" in said(scale)[0]
    told: list[str] = []
    large = scene(f"emitter: {{shape: {{kind: mesh, file: {ball}, scale: 100}}, strands: 9, length: 0.1}}\nrules: []\n")
    frames_of(large, 1, draw=False, warn=told.append)
    assert any("another unit" in words for words in told)


def test_what_cannot_be_used_is_refused(ball: str, tmp_path: Path) -> None:
    bare = textured(tmp_path / "bare.obj", uv=False)
    Image.new("L", (4, 4), 255).save(tmp_path / "white.png")
    Image.new("L", (4, 4), 0).save(tmp_path / "black.png")
    square = textured(tmp_path / "square.obj")
    cases = [
        ({"file": ball, "density": "scalp"}, "no attribute 'scalp' of its vertices; there are nothing, ramp, upper"),
        ({"file": ball, "comb": "ramp"}, "has 1 number a vertex, not 3"),
        ({"file": bare, "density": "scalp"}, "it has none"),
        ({"file": ball, "density": "nothing"}, "is 0 all over the mesh"),
        ({"file": bare, "length": str(tmp_path / "white.png")}, "no texture coordinates"),
        ({"file": square, "density": str(tmp_path / "black.png")}, "is 0 all over the mesh"),
        ({"file": square, "density": ball}, "is no picture"),
        ({"file": str(tmp_path / "none.obj")}, "no such file"),
    ]  # fmt: skip
    for settings, words in cases:
        with pytest.raises(UsageError, match=words) as found:
            grown(**settings)  # type: ignore[arg-type]
        assert "\n" not in str(found.value)


def test_what_needs_a_formula_clashes_with_a_mesh(ball: str) -> None:
    shape = f"emitter: {{shape: {{kind: mesh, file: {ball}}}"
    for text, words in (
        (f"{shape[:-1]}, comb: x}}, tie: {{}}}}", "strands that are tied are combed to their tie"),
        ("emitter: {shape: {kind: mesh}}", "must be the path of a mesh"),
        (f"emitter: {{shape: {{kind: mesh, file: {ball}, density: none.png}}}}", "there is no file"),
    ):
        with pytest.raises(UsageError, match=words):
            scene(text)
