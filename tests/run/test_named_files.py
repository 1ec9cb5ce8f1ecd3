"""Errors of files name the key that names the file."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import exchange_kit
import mesh_kit as kit
import strandcli
from strandcli.errors import UsageError
from strandcli.meshes.make import RawMesh, mesh_of
from strandcli.plan import make_plan

ROD = "solver: rod\nrules: [gravity]"
HEAD = "{kind: sphere, radius: 0.1}, {kind: mesh, size: 0.2, file: "
SOLID = "solids: [{kind: mesh, "
CASES = [
    ("solids.1.file", f"solids: [{HEAD}bad.ply}}]"),
    ("solids.1.deform.1.file", f"solids: [{HEAD}ball.obj, deform: [{{file: ball.obj}}, {{time: 1, file: bad.ply}}]}}]"),
    ("solids.1.texture", f"solids: [{HEAD}ball.obj, texture: bad.png}}]"),
    ("solids.0.file", f"emitter: {{groom: {{file: hair.hair, on: head}}}}\n{SOLID}name: head, file: bad.ply}}]"),
    ("solids.0.file", f"{SOLID}file: bad.obj, scale: 1000}}]"),  # which is too far out, then
    ("emitter.shape.file", "emitter: {shape: {kind: mesh, file: bad.ply}}"),
    ("emitter.shape.density", "emitter: {shape: {kind: mesh, file: ball.obj, density: bad.png}}"),
    ("emitter.groom.file", "emitter: {groom: {file: bad.hair}}"),
    ("emitter.groom.file", "emitter: {groom: {file: 'bad.#.hair'}}"),
    ("emitter.groom.file", "emitter: {groom: {file: bad.data, fix: false}}"),  # of strands without length
    ("emitter.groom.file", "emitter: {particles: 9000, groom: {file: bad.npz, guides: 1}}\n" + ROD),  # too short
    ("camera.file", "camera: {file: bad.json}"),
    ("environment.image", "environment: {image: bad.png}"),
]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a mesh, strands, and a damaged file of each kind."""
    from strandcli.exchange.files import write
    from strandcli.exchange.strands import Strands

    found = tmp_path_factory.mktemp("files")
    ball = kit.mesh("ball")
    uv = np.zeros((*ball.triangles.shape, 2), np.float32)
    (found / "ball.obj").write_bytes(kit.obj(mesh_of(RawMesh(ball.vertices, ball.triangles, uv=uv), "ball")))
    (found / "bad.ply").write_bytes(kit.ply(ball)[:-3])
    for name in ("bad.png", "bad.hair", "bad.1.hair", "bad.json"):
        (found / name).write_bytes(b"none")
    (found / "bad.obj").write_bytes(kit.obj(ball.with_vertices(1e14 * ball.vertices)))
    points = np.array([[0, 0.1, 0], [0, 0.2, 0]], np.float32)
    for name, scale in {"hair.hair": 1.0, "bad.data": 0.0, "bad.npz": 1e-6}.items():
        write(found / name, Strands(np.array([0, 2]), np.float32(scale) * points))
    return found


def draw(preset: Path, settings: dict[str, int]) -> None:
    """Do all that reads a scene's files."""
    scene = strandcli.load(str(preset), settings=settings)
    make_plan(scene, [1])
    next(strandcli.render(scene, [1]))


@pytest.mark.parametrize(("key", "text"), CASES)
def test_the_key_of_a_file_stands_before_what_is_wrong_with_it(key: str, text: str, folder: Path) -> None:
    preset = folder / "preset.yaml"
    preset.write_text(f"quality: draft\nimage: {{size: 16x16}}\n{text}\n")
    with pytest.raises(UsageError) as told:
        draw(preset, {} if "groom" in text else {"emitter.strands": 4})
    assert str(told.value).startswith(f"{key}: {folder}/bad."), told.value


@pytest.mark.parametrize(
    ("key", "text"),
    [("environment.image", "environment: {image: gone.png}"), ("solids.0.file", f"{SOLID}file: gone.ply}}]"),
     ("solids.0.texture", f"{SOLID}file: ball.obj, texture: gone.png}}]")],
)  # fmt: skip
def test_a_file_that_is_gone_when_it_is_drawn_has_its_key(key: str, text: str, folder: Path) -> None:
    preset, gone = folder / "gone.yaml", [folder / "gone.png", folder / "gone.ply"]
    for path in gone:
        path.write_bytes(b"")
    preset.write_text(f"quality: draft\nimage: {{size: 16x16}}\n{text}\n")
    scene = strandcli.load(str(preset), settings={"emitter.strands": 4})
    for path in gone:
        path.unlink()
    with pytest.raises(UsageError, match=rf"^{key}: {folder}/gone\.\w+: no such file"):
        next(strandcli.render(scene, [1]))


@pytest.mark.parametrize("bad", ["mesh", "strands", "picture"])
def test_a_file_that_several_keys_name_has_the_key_of_what_it_is_wanted_as(bad: str, folder: Path) -> None:
    """A mesh is no strands and no picture, and strands are no mesh."""
    mesh, strands, with_uv = folder / "ball.ply", folder / "strands.ply", folder / "ball.obj"
    mesh.write_bytes(kit.ply(kit.mesh("ball")))
    strands.write_bytes(exchange_kit.ply([np.linspace((0, k, 0), (1, k, 0), 5, dtype=np.float32) for k in range(4)]))
    key, hair, solid, texture, one = {
        "mesh": ("solids.0.file", strands, strands, "", strands),
        "strands": ("emitter.groom.file", mesh, mesh, "", mesh),
        "picture": ("solids.0.texture", strands, with_uv, f", texture: {with_uv}", with_uv),
    }[bad]
    text = (
        f"emitter: {{groom: {{file: {hair}, on: head}}}}\nsolids: [{{kind: mesh, name: head, file: {solid}{texture}}}]"
    )
    preset = folder / "several.yaml"
    preset.write_text(f"quality: draft\nimage: {{size: 16x16}}\n{text}\n")
    with pytest.raises(UsageError) as told:
        draw(preset, {})
    assert str(told.value).startswith(f"{key}: {one}: "), told.value
