"""Every file that a scene is read from is known by its content, whatever names it."""

from __future__ import annotations

import ast
import dataclasses
import json
import os
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

import mesh_kit as kit
import strandcli
import usd_kit
from camera_kit import view
from strandcli.cameras import colmap
from strandcli.errors import UsageError
from strandcli.exchange.files import write
from strandcli.exchange.strands import Strands
from strandcli.files import inputs
from strandcli.meshes.make import RawMesh, mesh_of
from strandcli.run import pipeline
from strandcli.run.checkpoints import key_of
from strandcli.run.fingerprint import READERS, fingerprint
from strandcli.scene.model import Scene
from strandcli.scene.specs import FileSpec, ItemsSpec, ModelSpec, ParametersSpec, RulesSpec, UnionSpec

BALL = kit.mesh("ball")
UV = np.random.default_rng(1).random((*BALL.triangles.shape, 2)).astype(np.float32)
SOLID = "solids: [{kind: mesh, size: 0.5, file: %s}]"
SHAPE = "emitter: {shape: {kind: mesh, size: 0.5, file: %s}}"
MOVED = "{kind: mesh, size: 0.5, file: a.stl, deform: [{file: a.stl}, {time: 1, file: b.stl}]}"
CASES: dict[str, list[tuple[str, tuple[str, ...]]]] = {
    "emitter.groom.file": [
        ("emitter: {groom: {file: hair.hair}}", ("hair.hair",)),
        ("emitter: {groom: {file: over.usda}}", ("over.usda", "under.usda")),
        ("emitter: {groom: {file: hair_%02d.hair}}", ("hair_01.hair", "hair_02.hair", "hair_03.hair")),
    ],
    "emitter.shape.file": [
        (SHAPE % "a.gltf", ("a.gltf", "a.bin", "a.png")),
        (SHAPE % "a.obj", ("a.obj", "a.mtl", "a.png")),
        (SHAPE % "a.ply", ("a.ply", "a.png")),
        (SHAPE % "a.stl", ("a.stl",)),
    ],
    "emitter.shape.density": [(SHAPE % "a.obj, density: a.png", ("a.png",))],
    "emitter.shape.length": [(SHAPE % "a.obj, length: a.png", ("a.png",))],
    "emitter.shape.deform.file": [(f"emitter: {{shape: {MOVED}}}", ("a.stl", "b.stl"))],
    "solids.file": [(SOLID % "a.gltf", ("a.gltf", "a.bin", "a.png")), (SOLID % "a.obj", ("a.obj", "a.mtl", "a.png"))],
    "solids.texture": [(SOLID % "a.obj, texture: b.png", ("b.png",))],
    "solids.deform.file": [(f"solids: [{MOVED}]", ("a.stl", "b.stl"))],
    "camera.file": [
        ("camera: {file: cameras.txt}", ("cameras.txt", "images.txt")),
        ("camera: {file: over.usda}", ("over.usda", "under.usda")),
    ],
    "environment.image": [("environment: {image: b.png}", ("b.png",))],
}
"""By setting: presets, and the files that reading each opens."""
BOTH = [(key, *case) for key, cases in CASES.items() for case in cases]


def settings(model: type, place: tuple[str, ...] = ()) -> Iterator[tuple[str, str]]:
    """Keys of all settings that name files, with the kinds of these."""
    for field in dataclasses.fields(model):
        spec, key = field.metadata.get("spec"), (*place, field.name)
        if isinstance(spec, FileSpec):
            yield ".".join(key), spec.kind
        elif isinstance(spec, ModelSpec):
            yield from settings(spec.model, key)
        elif isinstance(spec, UnionSpec | ItemsSpec):
            for kind in spec.kinds.values():
                yield from settings(kind, key)
        elif isinstance(spec, ParametersSpec | RulesSpec):
            registry = spec.registry if isinstance(spec, ParametersSpec) else strandcli.simulate.rules.registry()
            for name in registry.names() if isinstance(spec, ParametersSpec) else registry:
                driver = registry[name]
                parameters = getattr(driver, "Parameters", None) or getattr(driver, "parameters", None)
                if dataclasses.is_dataclass(parameters):
                    yield from settings(parameters, key)  # type: ignore[arg-type]


def picture(path: Path) -> None:
    """A picture of noise, so that no byte of its pixels is without meaning."""
    from PIL import Image

    Image.fromarray(np.random.default_rng(len(path.name)).integers(40, 200, (8, 16, 3), np.uint8)).save(path)


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with all files of `CASES`."""
    monkeypatch.chdir(tmp_path)
    for name in ("a.png", "b.png"):
        picture(tmp_path / name)
    with_uv = mesh_of(RawMesh(BALL.vertices, BALL.triangles, uv=UV), "ball")
    text = b"mtllib a.mtl\nusemtl skin\n" + kit.obj(with_uv)
    (tmp_path / "a.obj").write_bytes(text)
    (tmp_path / "a.mtl").write_text("newmtl skin\nmap_Kd a.png\n", encoding="utf-8")
    columns = {"s": UV[:, 0, 0].repeat(2)[: len(BALL.vertices)], "t": UV[:, 0, 1].repeat(2)[: len(BALL.vertices)]}
    (tmp_path / "a.ply").write_bytes(kit.ply(BALL, more=columns).replace(b"made by a test", b"TextureFile a.png"))
    (tmp_path / "a.stl").write_bytes(kit.stl(BALL))
    (tmp_path / "b.stl").write_bytes(kit.stl(BALL.with_vertices(1.1 * BALL.vertices)))
    tree, buffer = kit.gltf_tree(BALL, TEXCOORD_0=np.random.default_rng(2).random((len(BALL.vertices), 2), "f4"))
    tree["buffers"][0]["uri"] = "a.bin"
    tree |= {"images": [{"uri": "a.png"}], "textures": [{"source": 0}]}
    tree["materials"] = [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]
    tree["meshes"][0]["primitives"][0]["material"] = 0
    (tmp_path / "a.gltf").write_text(json.dumps(tree), encoding="utf-8")
    (tmp_path / "a.bin").write_bytes(buffer)
    curves = [np.array([[k, 0, 0], [k, 1, 0], [k, 2, 1]], np.float32) / 9 for k in range(4)]
    for name in ("hair", "hair_01", "hair_02", "hair_03"):
        write(tmp_path / f"{name}.hair", Strands(np.arange(0, 13, 3), np.concatenate(curves)))
    camera = 'def Camera "eye"\n{\n    float focalLength = 40\n}\n'
    (tmp_path / "under.usda").write_text(usd_kit.text(curves) + camera, encoding="utf-8")
    over = '#usda 1.0\n(\n    subLayers = [@under.usda@]\n    upAxis = "Y"\n    metersPerUnit = 1\n)\n'
    (tmp_path / "over.usda").write_text(over, encoding="utf-8")
    for name, data in colmap.written([view(0), view(1)], np.zeros((0, 3))).items():
        (tmp_path / name).write_bytes(data)
    return tmp_path


def changed(path: Path) -> None:
    """Write another content of the same size into a file, whose time of change stays."""
    before, data = path.stat(), path.read_bytes()
    texts = {".usda": (b"1", b"2"), ".txt": (b"5", b"6"), ".obj": (b"0.", b"1."), ".mtl": (b"map_Kd", b"map_Bu"),
             ".gltf": (b'"scene": 0', b'"scene":00')}  # fmt: skip
    if path.suffix in texts:
        old, new = texts[path.suffix]
        place = data.rfind(old)
        assert place >= 0
        data = data[:place] + new + data[place + len(old) :]
    else:
        data = data[:-40] + bytes([data[-40] ^ 1]) + data[-39:]
    path.write_bytes(data)
    os.utime(path, ns=(before.st_atime_ns, before.st_mtime_ns))
    assert (path.stat().st_size, path.stat().st_mtime_ns) == (before.st_size, before.st_mtime_ns)


def scene_of(text: str) -> Scene:
    path = Path("scene.yaml")
    if "groom" not in text and "shape" not in text:
        text += "\nemitter: {strands: 4}"
    path.write_text(f"image: {{size: 16x12}}\nrules: []\n{text}\n", encoding="utf-8")
    return strandcli.load("scene.yaml", [] if "groom" in text else ["emitter.strands=4", "emitter.particles=3"])


def test_every_setting_that_names_a_file_is_looked_at_here() -> None:
    found = dict(settings(Scene))
    assert found.keys() == CASES.keys()
    assert set(found.values()) == READERS.keys()


@pytest.mark.parametrize(("key", "text", "files"), BOTH)
def test_whatever_a_scene_reads_is_in_its_fingerprint(
    key: str, text: str, files: tuple[str, ...], folder: Path
) -> None:
    """Of the same size and time too, at once after it was read; and back again."""
    scene = scene_of(text)
    with inputs.recording() as known:
        before = fingerprint(scene)
    assert {Path(one.path).name for one in known} >= set(files)
    moving = None if key in ("camera.file", "environment.image", "solids.texture") else key_of(scene)
    for name in files:
        data = (folder / name).read_bytes()
        changed(folder / name)
        after = fingerprint(scene)
        assert after != before, name
        assert moving is None or key_of(scene) != moving, name
        (folder / name).write_bytes(data)
        assert fingerprint(scene) == before, name
    missing = folder / files[-1]
    missing.unlink()
    assert fingerprint(scene) != before


@pytest.mark.parametrize(("key", "text", "files"), BOTH)
def test_drawing_opens_nothing_else(key: str, text: str, files: tuple[str, ...], folder: Path) -> None:
    scene = scene_of(text)
    with inputs.recording() as read:
        list(pipeline.render(scene, [1], threads=1))
    with inputs.recording() as known:
        fingerprint(scene)
    opened = {one.path for one in read if one.stamp}
    assert opened <= {one.path for one in known}
    assert opened >= {str(folder / name) for name in files} or key in ("camera.file", "emitter.shape.file")


def test_results_of_relative_paths_are_those_of_their_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    read = inputs.cached(4)(inputs.content)
    for name in ("one", "two"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "a.txt").write_bytes(name.encode())
    for name in ("one", "two", "one"):
        monkeypatch.chdir(tmp_path / name)
        assert read("a.txt") == name.encode()


def test_results_are_kept_as_long_as_their_files_are_the_same(tmp_path: Path) -> None:
    path, made = tmp_path / "a.txt", []

    @inputs.cached(2)
    def inner(name: str) -> bytes:
        made.append(name)
        return inputs.content(tmp_path / name)

    @inputs.cached(2)
    def outer() -> bytes:
        made.append("outer")
        return inner("a.txt")

    with pytest.raises(UsageError, match="no such file"):
        outer()
    for data in (b"one", b"two", b"two", b"one"):
        path.write_bytes(data)
        os.utime(path, ns=(0, 0))
        made.clear()
        assert outer() == outer() == data
        assert made in (["outer", "a.txt"], [])
    made.clear()
    path.touch()
    assert outer() == b"one"
    assert made == []
    path.unlink()
    with pytest.raises(UsageError, match="no such file"):
        outer()


def test_a_file_that_is_written_while_it_is_read_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.bin"
    path.write_bytes(b"abc")
    with pytest.raises(UsageError, match=r"a\.bin: was written while it was read"), inputs.opened(path):
        path.write_bytes(b"abcd")
    os.utime(path, ns=(0, 0))
    settled = inputs.Input(str(path), inputs._stamp_of(str(path)), "")
    path.write_bytes(b"efgh")
    with pytest.raises(UsageError, match="was written after it had been read"):
        inputs.digest_of(settled)


PACKAGE = Path(strandcli.__file__).parent
READ_SCENES = (
    "scene", "exchange", "meshes", "mesh_file", "groom_file", "cameras", "groom", "draw", "simulate", "solids",
    "solid_shapes",
)  # fmt: skip
"""Packages that read what pictures follow from: by `strandcli.files.inputs` alone, so that fingerprints know of it."""
OTHERWISE = {
    "scene/library.py",  # titles of presets, for lists
    "exchange/formats/npz.py",  # members of an archive that is open
    "exchange/usd/worker.py",  # the memory of its process
    "exchange/usd/open_stage.py",  # in the worker, which tells what files it has opened, as for the library
}  # fmt: skip
OPENERS = ("open", "os.open", "io.open", "np.load", "np.fromfile", "np.memmap", "np.genfromtxt", "np.loadtxt")


def test_files_of_scenes_are_opened_in_one_module() -> None:
    found = set()
    for path in (path for room in READ_SCENES for path in (PACKAGE / room).rglob("*.py")):
        calls = [ast.unparse(one.func) for one in ast.walk(ast.parse(path.read_text())) if isinstance(one, ast.Call)]
        if any(name in OPENERS or name.endswith((".open", ".read_bytes", ".read_text")) for name in calls):
            found.add(path.relative_to(PACKAGE).as_posix())
    assert found == OTHERWISE


def test_a_file_is_named_where_the_folder_that_the_process_is_in_is_gone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "gone").mkdir()
    monkeypatch.chdir(tmp_path / "gone")
    (tmp_path / "gone").rmdir()
    with inputs.recording() as found, pytest.raises(UsageError, match=r"a\.npz: no such file"):
        inputs.content("a.npz")
    assert [one.path for one in found] == ["a.npz"]
