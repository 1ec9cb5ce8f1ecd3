"""`strandcli info MESH`: facts by closed forms, faults that are put in, guesses, a picture."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import mesh_kit
from cli_runs import Runner
from strandcli.meshes.facts import facts, is_mesh
from strandcli.meshes.make import make_mesh


def test_a_box_by_its_closed_form() -> None:
    vertices, triangles = mesh_kit.cube()
    found = facts(make_mesh(vertices * [1, 2, 3] + [50, 0, 0], triangles))
    assert (found["vertices"], found["triangles"], found["parts"], found["closed"]) == (8, 12, 1, True)
    assert found["area"] == pytest.approx(2 * (2 * 4 + 4 * 6 + 2 * 6))
    assert found["volume"] == pytest.approx(2 * 4 * 6)
    assert found["box"] == {"min": [49, -2, -3], "max": [51, 2, 3], "size": [2, 4, 6]}
    assert found["faults"] == found["notes"] == []
    assert found["guess"]["up"] is None  # it may stand on any side


def test_faults_are_told_with_their_numbers() -> None:
    vertices, triangles = mesh_kit.cube()
    damaged = np.concatenate([triangles[1:], triangles[3:4], [[0, 0, 1]]])
    damaged[4] = damaged[4][::-1]
    found = facts(make_mesh(np.concatenate([vertices, [[9, 9, 9]]]), damaged))
    counts = {one["fault"]: one["count"] for one in found["faults"]}
    assert counts == {"no_area": 1, "repeated": 1, "unused": 1, "turned": 1, "boundary": 3}
    assert found["volume"] is None
    assert found["holes"] == 1
    assert [one["text"] for one in found["faults"]] == [
        "1 triangle without area: left out", "1 triangle equal to another: left out",
        "1 vertex of no triangle: left out", "1 of 11 triangles was wound the opposite way: turned",
        "open: 1 hole, 3 edges on its rim; inside is where the surface goes more than half around",
    ]  # fmt: skip


@pytest.mark.parametrize("up", ["y", "-x"])
@pytest.mark.parametrize("closed", [True, False])
def test_up_is_away_from_the_side_that_is_cut_off(up: str, closed: bool) -> None:
    """A ball cut off below, its hole left open or closed by a fan."""
    vertices, triangles = mesh_kit.sphere(4)
    kept = triangles[(vertices[triangles, 1] > -0.6).all(axis=1)]
    if closed:
        rim = np.unique(make_mesh(vertices, kept).triangles)  # all that is used
        edges = np.concatenate([kept[:, (0, 1)], kept[:, (1, 2)], kept[:, (2, 0)]])
        alone = {tuple(one) for one in edges.tolist()}
        bounds = [(a, b) for a, b in alone if (b, a) not in alone]
        assert len(rim) > len(bounds)
        flat = vertices.copy()
        flat[[a for a, _ in bounds], 1] = -0.6
        vertices = np.concatenate([flat, [[0, -0.6, 0]]])
        kept = np.concatenate([kept, [(b, a, len(vertices) - 1) for a, b in bounds]])
    axis, sign = "xyz".index(up[-1]), -1.0 if up[0] == "-" else 1.0
    turned = np.roll(vertices, axis - 1, axis=1)
    if sign < 0:
        turned = -turned
        kept = kept[:, ::-1]
    mesh = make_mesh(turned, kept)
    assert mesh.closed is closed
    assert facts(mesh)["guess"]["up"] == up


@pytest.mark.parametrize(("factor", "name"), [(0.15, "m"), (15, "cm"), (1, None)])
def test_the_unit_is_guessed_by_size(factor: float, name: str | None) -> None:
    vertices, triangles = mesh_kit.sphere(2)
    guess = facts(make_mesh(factor * vertices, triangles))["guess"]["unit"]
    assert (guess and guess["unit"]) == name


@pytest.mark.parametrize("command", ["render", "plan"])
def test_a_mesh_in_the_place_of_a_preset_is_told_what_it_is(command: str, run: Runner, tmp_path: Path) -> None:
    mesh = tmp_path / "head.obj"
    mesh.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    assert f"{mesh}: is a mesh, neither a preset nor strands" in run.refused(command, mesh)


def test_info_tells_a_mesh_and_draws_it(run: Runner, tmp_path: Path) -> None:
    path = mesh_kit.write(tmp_path / "ball.obj", *mesh_kit.sphere(3))
    words = run.fine("info", path, "--picture", tmp_path / "ball.png")
    assert "triangles  512" in words.out
    assert "parts      1, closed" in words.out
    data = json.loads(run("info", path, "--json").out)
    assert data["area"] == pytest.approx(4 * np.pi, rel=0.03)
    assert data["volume"] == pytest.approx(4 / 3 * np.pi, rel=0.05)
    picture = np.array(Image.open(tmp_path / "ball.png")).astype(float)
    shown = np.abs(picture - picture[:, :1]).sum(axis=2) > 20  # of the row's background
    rows, columns = np.nonzero(shown)
    assert 0.5 * picture.shape[0] < np.ptp(rows) < 0.9 * picture.shape[0]
    assert abs(columns.mean() - picture.shape[1] / 2) < 30
    assert run("info", path, "--picture", tmp_path / "ball.png").code == 2


def test_files_of_strands_are_no_meshes(run: Runner, tmp_path: Path) -> None:
    head = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
    strands, mesh = tmp_path / "a.ply", tmp_path / "b.ply"
    strands.write_text(head + "end_header\n0 0 0\n0 1 0\n1 0 0\n1 1 0\n")
    mesh.write_text(
        head + "element face 2\nproperty list uchar int vertex_indices\nend_header\n"
        "0 0 0\n0 1 0\n1 0 0\n1 1 0\n3 0 1 2\n3 1 3 2\n"
    )
    assert not is_mesh(strands)
    assert is_mesh(mesh)
    assert "strands    2" in run("info", strands, "--stride", 2).out
    assert "triangles  2" in run("info", mesh).out
    for name, text in (("c.obj", ""), ("d.stl", "solid"), ("e.glb", "glTF")):
        (tmp_path / name).write_text(text)
        result = run("info", tmp_path / name)
        assert result.code == 2
        assert result.err.count("\n") == 1
    assert "no such file" in run("info", tmp_path / "none.obj").err
