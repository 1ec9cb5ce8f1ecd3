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
