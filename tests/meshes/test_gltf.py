"""glTF: numbers however they are stored, scenes as another reader places them, and what asks for more than it holds."""

from __future__ import annotations

import base64
import json
import struct
import tracemalloc
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image

import mesh_kit as kit
from strandcli.errors import UsageError
from strandcli.exchange.bounded import Beside
from strandcli.files import picture_samples
from strandcli.meshes import gltf
from strandcli.meshes.gltf import read_gltf
from strandcli.meshes.read import read_mesh

BALL = kit.mesh("ball")
CORNERS = ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0))


def triangle(maker: kit.Maker, **more: Any) -> dict[str, int]:
    return {"POSITION": maker.accessor(np.array(CORNERS, np.float32), **more)}


KINDS = st.sampled_from(["i1", "u1", "i2", "u2", "f4"])


@settings(max_examples=60)
@given(st.data())
def test_numbers_are_read_however_they_are_stored(
    tmp_path_factory: pytest.TempPathFactory, data: st.DataObject
) -> None:
    maker = kit.Maker()
    kind, normalized = data.draw(KINDS), data.draw(st.booleans())
    random = np.random.default_rng(data.draw(st.integers(0, 99)))
    info = np.iinfo(kind) if kind != "f4" else None
    stored = random.integers(info.min, info.max + 1, (40, 3)).astype(kind) if info else random.random((40, 3), "f4")
    values = stored.astype(np.float64)
    item = 3 * stored.itemsize
    more: dict[str, Any] = {"normalized": True} if normalized else {}
    stride = data.draw(st.sampled_from([0, item + (-item) % 4, item + (-item) % 4 + 8]))
    position = maker.accessor(stored, stride, data.draw(st.sampled_from([0, 4, 64])), **more)
    if normalized and info:
        values = np.maximum(values / info.max, -1)
    corners = random.integers(0, 40, (90, 1)).astype(data.draw(st.sampled_from(["u1", "u2", "u4"])))
    maker.primitive({"POSITION": position}, indices=maker.accessor(corners))
    folder = tmp_path_factory.mktemp("a")
    (part,) = read_gltf(maker.glb(folder / "a.glb"), Beside(folder / "a.glb"))
    np.testing.assert_array_equal(part.triangles, corners.reshape(-1, 3))
    np.testing.assert_allclose(part.vertices, values, rtol=1e-6, atol=1e-7)


@given(st.integers(0, 50))
@settings(max_examples=8)
def test_nodes_place_meshes_as_trimesh_does(tmp_path_factory: pytest.TempPathFactory, seed: int) -> None:
    random = np.random.default_rng(seed)
    maker = kit.Maker()
    maker.primitive({"POSITION": maker.accessor(np.ascontiguousarray(BALL.vertices, np.float32))},
                    indices=maker.accessor(BALL.triangles.reshape(-1, 1).astype(np.uint32)))  # fmt: skip
    nodes: list[dict[str, Any]] = []
    for _ in range(5):
        turn = random.normal(size=4)
        nodes.append({
            "mesh": 0, "translation": random.normal(size=3).tolist(), "scale": random.uniform(0.5, 2, 3).tolist(),
            "rotation": (turn / np.linalg.norm(turn)).tolist(),
        })  # fmt: skip
    nodes[0]["children"], nodes[2]["children"] = [1, 2], [3]
    maker.tree |= {"nodes": nodes, "scenes": [{"nodes": [0, 4]}]}
    path = maker.glb(tmp_path_factory.mktemp("a") / "a.glb")
    parts = read_gltf(path, Beside(path))
    corners = np.concatenate([one.vertices[one.triangles] for one in parts])
    other: Any = trimesh.load(path, process=False, force="scene")
    theirs = np.concatenate([one.triangles for one in other.dump()])
    order, back = (np.lexsort(one.reshape(-1, 9).round(6).T) for one in (corners, theirs))
    np.testing.assert_allclose(corners[order], theirs[back], atol=1e-5)


def test_buffers_and_pictures_may_stand_in_the_header(tmp_path: Path) -> None:
    Image.fromarray(np.arange(12, dtype=np.uint8).reshape(2, 2, 3)).save(tmp_path / "a b.png")
    maker = kit.Maker()
    uv = {"TEXCOORD_1": maker.accessor(np.array([(0, 0), (1, 0), (0, 1)], np.float32))}
    maker.primitive(triangle(maker) | uv, **maker.picture(b"", texCoord=1))
    maker.tree["buffers"] = [{"uri": "data:application/octet-stream;base64," + base64.b64encode(maker.data).decode()}]
    content = (tmp_path / "a b.png").read_bytes()
    for uri in ("a%20b.png", "data:image/png;base64," + base64.b64encode(content).decode()):
        maker.tree["images"] = [{"uri": uri}]
        (tmp_path / "a.gltf").write_text(json.dumps(maker.tree))
        mesh = read_mesh(tmp_path / "a.gltf")
        assert mesh.texture.reshape(-1).tolist() == list(range(12))
        assert mesh.uv[0].tolist() == [[0, 1], [1, 1], [0, 0]]


EPS = b"%!PS-Adobe-3.0 EPSF-3.0\n%%BoundingBox: 0 0 8 8\n%%EndComments\n0 0 8 8 rectfill\nshowpage\n%%EOF\n"


@pytest.mark.parametrize("kind", [".glb", ".obj", ".ply"])
def test_a_picture_runs_no_program(kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """EPS labelled PNG, for which Pillow runs Ghostscript."""
    ran = tmp_path / "ran"
    (tmp_path / "bin").mkdir()
    (tmp_path / "bin/gs").write_text(f"#!/bin/sh\ntouch {ran}\n")
    (tmp_path / "bin/gs").chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path / "bin"), prepend=":")
    (tmp_path / "skin.png").write_bytes(EPS)
    path = tmp_path / f"a{kind}"
    if kind == ".glb":
        maker = kit.Maker()
        maker.primitive(triangle(maker), **maker.picture(EPS))
        with pytest.raises(UsageError, match=r"images\[0\]: is no picture"):
            read_mesh(maker.glb(path))
    else:
        (tmp_path / "a.mtl").write_text("newmtl m\nmap_Kd skin.png\n")
        obj = b"mtllib a.mtl\nusemtl m\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"
        ply = kit.ply(BALL).replace(b"element vertex", b"comment TextureFile skin.png\nelement vertex", 1)
        path.write_bytes(obj if kind == ".obj" else ply)
        mesh = read_mesh(path)
        assert mesh.texture is None
        assert any("no pictures that can be read" in note and "skin.png" in note for note in mesh.notes)
    assert not ran.exists()


def test_a_picture_of_many_primitives_is_decoded_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    Image.new("RGB", (2000, 2000)).save(tmp_path / "a.png")
    maker = kit.Maker()
    material = maker.picture((tmp_path / "a.png").read_bytes())
    for _ in range(60):
        maker.primitive(triangle(maker), **material)
    path, decoded = maker.glb(tmp_path / "a.glb"), []

    def counted(content: bytes) -> Any:
        decoded.append(len(content))
        return picture_samples.pixels(content)

    monkeypatch.setattr(gltf, "pixels", counted)
    mesh = read_mesh(path)
    assert mesh.texture.shape == (2000, 2000, 3)
    assert len(decoded) == 1


def test_primitives_of_the_same_vertices_have_them_once(tmp_path: Path) -> None:
    maker = kit.Maker()
    places = {"POSITION": maker.accessor(np.ascontiguousarray(BALL.vertices, np.float32))}
    for part in np.array_split(BALL.triangles, 9):
        maker.primitive(places, indices=maker.accessor(part.reshape(-1, 1).astype(np.uint16)))
    (part,) = read_gltf(maker.glb(tmp_path / "a.glb"), Beside(tmp_path / "a.glb"))
    assert part.vertices.shape == BALL.vertices.shape
    np.testing.assert_array_equal(part.triangles, BALL.triangles)


@pytest.mark.parametrize("kind", ["nodes", "primitives", "zeros", "empty parts"])
def test_what_is_named_again_and_again_is_counted_before_memory_is_taken(kind: str, tmp_path: Path) -> None:
    maker = kit.Maker()
    places = maker.accessor(np.zeros((3000, 3), np.float32))
    if kind == "nodes":
        maker.primitive({"POSITION": places})
        maker.tree["nodes"] = [{"mesh": 0} for _ in range(10_000)]
        maker.tree["scenes"][0]["nodes"] = list(range(10_000))
    elif kind == "primitives":
        indices = maker.accessor(np.zeros((30_000, 1), np.uint8))
        for _ in range(5_000):
            maker.primitive({"POSITION": places}, indices=indices)
    elif kind == "empty parts":
        empty = [maker.entry(np.zeros((0, 3), np.float32)) for _ in range(1000)]
        maker.tree["meshes"][0]["primitives"] = [{"attributes": {"POSITION": one}} for one in empty]
        maker.tree["nodes"] = [{"mesh": 0} for _ in range(1000)]
        maker.tree["scenes"][0]["nodes"] = list(range(1000))
    else:
        huge = maker.entry(np.zeros((3, 3), np.float32))
        maker.tree["accessors"][huge]["count"] = 10**9
        maker.primitive({"POSITION": huge}, indices=maker.accessor(np.zeros((3, 1), np.uint8)))
    path = maker.glb(tmp_path / "a.glb")
    tracemalloc.start()
    try:
        with pytest.raises(UsageError, match=r"of the meshes that its nodes place take [\d,]+ MB, of a file of"):
            read_mesh(path)
        assert tracemalloc.get_traced_memory()[1] < 3 * path.stat().st_size + 20e6
    finally:
        tracemalloc.stop()


def test_headers_of_too_many_things_are_refused(tmp_path: Path) -> None:
    text = b'{"asset": [' + b"[]," * 1_500_000 + b"[]]}"
    (tmp_path / "a.gltf").write_bytes(text)
    (tmp_path / "a.glb").write_bytes(struct.pack("<4sIIII", b"glTF", 2, 20 + len(text), len(text), 0x4E4F534A) + text)
    for name in ("a.gltf", "a.glb"):
        with pytest.raises(UsageError, match="its header lists 3,000,003 things, more than 1,000,000"):
            read_mesh(tmp_path / name)


def test_pixels_of_16_bits_are_grey_and_of_too_many_none(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    grey = (np.arange(6).reshape(2, 3) * 13_000).astype(np.uint16)
    Image.fromarray(grey).save(tmp_path / "a.png")
    found = picture_samples.pixels((tmp_path / "a.png").read_bytes())
    np.testing.assert_array_equal(found, np.rint(grey / 257)[..., None].repeat(3, axis=2))
    monkeypatch.setattr(picture_samples, "MOST", 5)
    with pytest.raises(ValueError, match="3 x 2 pixels are more than 5"):
        picture_samples.pixels(tmp_path / "a.png")


def test_strips_fans_and_sparse_numbers_are_refused(tmp_path: Path) -> None:
    for mode, more, words in ((5, {}, "strips or fans"), (6, {}, "strips or fans"), (4, {"sparse": {}}, "is sparse")):
        maker = kit.Maker()
        maker.primitive({"POSITION": maker.accessor(np.arange(18, dtype=np.float32).reshape(6, 3), **more)}, mode=mode)
        with pytest.raises(UsageError, match=words):
            read_mesh(maker.glb(tmp_path / "a.glb"))
