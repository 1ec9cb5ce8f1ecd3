"""What a mesh's file gives its solid: place, creases, colours; and what is told of it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

import mesh_kit
from strand_kit import warned
from strandcli.errors import UsageError
from strandcli.mesh_file import needs
from strandcli.mesh_file.maps import LINEAR, pyramid
from strandcli.mesh_file.prepared import key_of, mesh_of, prepared, shading_normals
from strandcli.meshes.make import make_mesh
from strandcli.scene import SceneError, loads
from strandcli.simulate.rules import registry
from strandcli.solid_shapes.mesh import Settings
from tests.solids.test_mesh import STRANDS, settings


def test_place_size_scale_and_up_are_those_of_grooms(tmp_path: Path) -> None:
    vertices, triangles = mesh_kit.ball(2)
    path = mesh_kit.write(tmp_path / "high.obj", vertices * (1, 2, 3) + (5, 6, 7), triangles)
    box = np.array(mesh_of(settings(path)).box())
    np.testing.assert_allclose(np.ptp(box, axis=0) / np.ptp(vertices, axis=0), (1, 2, 3))
    turned = np.array(mesh_of(settings(path, up="z", scale=0.5)).box())
    np.testing.assert_allclose(np.ptp(turned, axis=0), np.ptp(box, axis=0)[[0, 2, 1]] / 2)
    assert turned[0, 1] == pytest.approx(box[0, 2] / 2)
    ground = np.array(mesh_of(settings(path, size=1.2, place="ground")).box())
    assert np.ptp(ground, axis=0).max() == pytest.approx(1.2)
    np.testing.assert_allclose([ground[0, 1], *ground.sum(0)[[0, 2]]], 0, atol=1e-12)
    np.testing.assert_allclose(np.array(mesh_of(settings(path, place="origin")).box()).sum(0), 0, atol=1e-12)


def test_creases_are_kept_and_facets_are_not() -> None:
    cube = make_mesh(*mesh_kit.cube())
    np.testing.assert_allclose(shading_normals(cube, 60.0), np.repeat(cube.face_normals()[:, None], 3, 1), atol=1e-12)
    corner = shading_normals(cube, 100.0)
    np.testing.assert_allclose(np.abs(corner), 1 / np.sqrt(3), atol=0.2)
    vertices, triangles = mesh_kit.ball(3)
    ball = make_mesh(vertices, triangles)
    np.testing.assert_allclose(shading_normals(ball, 60.0), shading_normals(ball, 180.0), atol=1e-12)
    flat = make_mesh(vertices, triangles)
    facets = np.repeat(flat.face_normals()[:, None], 3, 1)
    object.__setattr__(flat, "own", facets)
    np.testing.assert_allclose(shading_normals(flat, 60.0), shading_normals(ball, 60.0))  # no more than faces
    own = facets[:, :, [1, 2, 0]]
    object.__setattr__(flat, "own", own)
    np.testing.assert_array_equal(shading_normals(flat, 60.0), own)


def test_levels_of_a_texture_keep_its_light() -> None:
    random = np.random.default_rng(4)
    image = random.integers(0, 256, (37, 61, 3), np.uint8)
    found = pyramid(image)
    assert [tuple(row[1:]) for row in found.levels] == [(61, 37), (30, 18), (15, 9), (7, 4), (3, 2), (1, 1)]
    for first, wide, high in found.levels:
        light = LINEAR[found.texels[first : first + wide * high]]
        np.testing.assert_allclose(light.mean(0), LINEAR[image].mean((0, 1)), atol=0.03)
    grey = pyramid(np.full((8, 8, 3), 77, np.uint8))
    assert (grey.texels == 77).all()


def test_which_colour_is_drawn(tmp_path: Path) -> None:
    vertices, triangles = mesh_kit.ball(1)
    plain = mesh_kit.write(tmp_path / "plain.obj", vertices, triangles)
    coloured = mesh_kit.write(tmp_path / "coloured.obj", vertices, triangles, colours=np.abs(vertices) / 2)
    pictured = mesh_kit.write(tmp_path / "pictured.obj", vertices, triangles, uv=np.abs(vertices[:, :2]))
    Image.fromarray(np.zeros((4, 4, 3), np.uint8)).save(tmp_path / "black.png")
    black = str(tmp_path / "black.png")

    def kinds(**more: Any) -> tuple[bool, bool]:
        made = prepared(key_of(Settings(**more)))
        return len(made.colours) > 0, made.texture is not None

    assert kinds(file=str(plain)) == (False, False)
    assert kinds(file=str(coloured)) == (True, False)
    assert kinds(file=str(coloured), colour=(0.1, 0.2, 0.3)) == (False, False)
    assert kinds(file=str(coloured), colour=(0.1, 0.2, 0.3), colour_from="file") == (True, False)
    assert kinds(file=str(coloured), colour_from="colour") == (False, False)
    assert kinds(file=str(pictured)) == (False, False)
    assert kinds(file=str(pictured), texture=black) == (False, True)
    with pytest.raises(UsageError, match="no picture that can be read"):
        kinds(file=str(pictured), texture=str(plain))


def test_bad_input_is_told(tmp_path: Path) -> None:
    def faults(solid: str) -> str:
        with pytest.raises(SceneError) as caught:
            loads(f"solids: [{solid}]", rules=registry())
        return str(caught.value)

    path = mesh_kit.write(tmp_path / "ball.obj", *mesh_kit.ball(1))
    assert "must be the path of a mesh" in faults("{kind: mesh}")
    assert "there is no file" in faults(f"{{kind: mesh, file: {tmp_path}/none.obj}}")
    assert "clashes with solids.0.size" in faults(f"{{kind: mesh, file: {path}, size: 1, scale: 2}}")
    with pytest.raises(SceneError, match=r"clashes with emitter\.shape\.size"):
        loads(f"emitter: {{shape: {{kind: mesh, file: {path}, size: 1, scale: 2}}}}", rules=registry())
    (tmp_path / "not.obj").write_text("hello")
    with pytest.raises(UsageError, match="no triangles"):
        mesh_of(settings(tmp_path / "not.obj"))


def test_a_wrong_unit_and_an_open_mesh_are_told(tmp_path: Path) -> None:
    vertices, triangles = mesh_kit.ball(3)
    path = mesh_kit.write(tmp_path / "open.obj", vertices * 18, triangles[20:])
    text = STRANDS.format(solver="rod", rules="gravity, collision", solid=f"{{kind: mesh, file: {path}}}")
    told = "\n".join(warned(text))
    assert "36.3 m large" in told
    assert "set its scale" in told
    assert "is open" in told
    assert "more than half around" in told


def test_colours_that_cannot_be_drawn_are_told(tmp_path: Path) -> None:
    """A texture without uv or beside `colour_from: colour`, and `colour_from: file` of a file without colours; nothing
    of a mesh that has them."""
    Image.new("RGB", (2, 2)).save(tmp_path / "skin.png")
    plain, lying = tmp_path / "plain.obj", tmp_path / "lying.obj"
    corners = "v -1 -3 0\nv 1 -3 0\nv 0 -2 0\n"
    plain.write_text(corners + "f 1 2 3\n")
    lying.write_text(corners + "vt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n")

    def told(**given: Any) -> str:
        return "\n".join(needs.warnings("solids.0", settings(**given), 1.0, False))

    texture = str(tmp_path / "skin.png")
    assert "its texture skin.png would lie on it" in told(path=plain, texture=texture)
    assert "which colour_from: file asks for" in told(path=plain, colour_from="file")
    assert "colour_from: colour leaves out its texture skin.png" in told(
        path=lying, texture=texture, colour_from="colour"
    )
    assert told(path=plain) == told(path=plain, colour_from="colour") == ""
    assert told(path=lying, texture=texture) == told(path=lying, texture=texture, colour_from="file") == ""
