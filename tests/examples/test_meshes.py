"""The meshes that presets use are those that examples/meshes makes, and they are closed."""

from __future__ import annotations

import importlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from strandcli.meshes.read import read_mesh

ROOT = Path(__file__).parents[2]
NAMES = ("head", "fox")


@pytest.fixture
def module(monkeypatch: pytest.MonkeyPatch) -> Any:
    """Imports a module of examples/meshes, as its programs do."""
    monkeypatch.syspath_prepend(str(ROOT / "examples/meshes"))
    return importlib.import_module


def shipped(name: str) -> Path:
    return ROOT / f"presets/meshes/{name}.ply"


@pytest.mark.parametrize("name", NAMES)
def test_the_shipped_file_is_of_the_sculpture(name: str, module: Any) -> None:
    model = module(name).model()
    rows, _ = module("ply").read(shipped(name))
    points = model.unposed(np.stack([rows[axis] for axis in "xyz"], 1).astype(float))
    assert np.abs(model.sculpture.field(points)).max() < 5e-5
    normals = np.stack([rows[axis] for axis in ("nx", "ny", "nz")], 1)
    straight = (normals * module("surface").unit(model.sculpture.gradient(points))).sum(1)
    assert np.quantile(straight, 0.002) > 0.999
    painted = np.stack([rows[axis] for axis in ("red", "green", "blue")], 1).astype(int)
    assert (np.abs(painted - model.colours(points)) <= 1).all(1).mean() > 0.999
    for key, wanted in model.numbers(points).items():
        assert (np.abs(rows[key] - wanted) < 1e-3).mean() > 0.999, key


@pytest.mark.parametrize("name", NAMES)
def test_the_shipped_file_is_read_without_faults(name: str) -> None:
    assert shipped(name).stat().st_size < 600_000
    mesh = read_mesh(shipped(name))
    assert mesh.closed
    assert mesh.facts.parts == 1
    assert not any((mesh.facts.no_area, mesh.facts.repeated, mesh.facts.unused, mesh.facts.boundary,
                    mesh.facts.crowded, mesh.facts.turned, mesh.facts.twisted))  # fmt: skip
    assert 5_000 <= len(mesh.triangles) <= 20_000
    assert len(mesh.vertices) - len(mesh.triangles) / 2 == 2, "a surface without handles"


def test_remeshing_makes_a_closed_surface_with_edges_as_long_as_wanted(module: Any) -> None:
    sculpt, surface = module("sculpt"), module("surface")
    sculpture = sculpt.Sculpture()
    sculpture.ball((0, 0, 0), 0.05, 0)
    sculpture.tube([(0, 0.03, 0, 0.02), (0, 0.09, 0, 0.015)], 0.02)
    sculpture.ball((0.05, 0, 0), 0.02, 0.01, op=sculpt.CUT)
    line = np.arange(-0.11, 0.11, 0.005)
    points, faces = surface.net(sculpture.field, (line, line + 0.001, line + 0.002))
    remesher = surface.Remesher(sculpture, lambda p: np.full(len(p), 0.008), sculpture.project(points), faces)
    remesher.run(5)
    _, _, length = remesher.edges()
    assert len(remesher.points) - len(remesher.faces) / 2 == 2
    assert np.abs(sculpture.field(remesher.points)).max() < 1e-5
    assert np.quantile(length, 0.02) > 0.6
    assert np.quantile(length, 0.98) < 1.5
    outward = sculpture.gradient(remesher.points[remesher.faces].mean(1))
    assert (surface.area_vectors(remesher.points, remesher.faces) * outward).sum(1).min() > 0


def test_the_field_of_mirrored_parts_is_symmetric(module: Any) -> None:
    sculpture = module("sculpt").Sculpture()
    sculpture.ball((0, 0, 0), (0.05, 0.06, 0.07), 0)
    with sculpture.group((0.08, 0.02, 0.01, 0.05), 0.004, mirror=True) as inner:
        inner.ball((0.08, 0.02, 0.01), (0.01, 0.02, 0.03), 0, turn=(20, 30, 40))
        inner.tube([(0.06, 0, 0, 0.004), (0.08, 0.02, 0.03, 0.006), (0.09, 0.03, 0.01, 0.004)], 0.004)
    sculpture.crease([(0.02, 0.01, 0, 0.004), (0.03, 0.02, 0, 0.004)], 0.002, mirror=True, drape=True)
    points = np.random.default_rng(3).uniform(-0.12, 0.12, (4000, 3))
    np.testing.assert_allclose(sculpture.field(points), sculpture.field(points * [-1, 1, 1]), atol=1e-12)


def test_the_wet_sheet_lies_on_the_fox_that_is_shipped(module: Any) -> None:
    eyes, ply = module("fox_eyes"), module("ply")
    rows, faces = eyes.wet(*ply.read(shipped("fox")))
    sheet, found = ply.read(shipped("fox-eyes"))
    np.testing.assert_array_equal(found, faces)
    for axis in "xyz":
        np.testing.assert_allclose(sheet[axis], rows[axis] + eyes.ABOVE * rows["n" + axis], atol=1e-6)
    assert (rows["density"] < 0.7).all()
    assert (sheet["y"] > 0.3).all()


def test_the_bob_grows_on_the_head_that_is_shipped(module: Any) -> None:
    bob, ply = module("bob"), module("ply")
    head, _ = ply.read(shipped("head"))
    rows, _ = ply.read(shipped("bob"))
    assert set(map(tuple, rows[["x", "y", "z"]].tolist())) <= set(map(tuple, head[["x", "y", "z"]].tolist()))
    points, normals = (np.stack([rows[p + axis] for axis in "xyz"], 1).astype(float) for p in ("", "n"))
    ways = np.stack([rows[f"comb_{axis}"] for axis in "xyz"], 1)
    np.testing.assert_allclose(ways, bob.ways(points, normals), atol=1e-5)
    np.testing.assert_allclose(rows["length"], np.clip(bob.lengths(points) / bob.LONGEST, 0.05, 1), atol=1e-5)
    assert rows["length"].max() < 1


def test_hair_of_a_bob_that_grows_low_reaches_the_line(module: Any) -> None:
    bob = module("bob")
    low = np.array([[0.075, -0.02, 0.0], [0, 0.0, -0.1], [-0.075, -0.06, -0.02]])
    np.testing.assert_allclose(low[:, 1] - bob.lengths(low), [bob.LINE, bob.LINE_BEHIND, bob.LINE], atol=1e-9)
    np.testing.assert_allclose(bob.lengths(np.array([[0, -0.05, -0.1]])), bob.NAPE)
