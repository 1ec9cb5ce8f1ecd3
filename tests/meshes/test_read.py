"""Files of meshes: what is written comes back, and what is damaged is refused in one line."""

from __future__ import annotations

import base64
import json
import tracemalloc
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import mesh_kit as kit
from strandcli.errors import StrandError, UsageError
from strandcli.exchange import bounded
from strandcli.meshes.make import RawMesh, mesh_of
from strandcli.meshes.mesh import TriangleMesh, fans_of_lists
from strandcli.meshes.read import read_mesh

BALL = kit.mesh("ball")
SINGLE = 1e-6


def written(folder: Path, name: str, content: bytes) -> Path:
    path = folder / name
    path.write_bytes(content)
    return path


def same(found: TriangleMesh, mesh: TriangleMesh, off: float = 0.0) -> None:
    """The same triangles in the same order, whatever their vertices' numbers."""
    assert found.vertices.shape == mesh.vertices.shape
    corners = [np.sort(one.vertices[one.triangles], axis=1) for one in (found, mesh)]
    np.testing.assert_allclose(corners[0], corners[1], atol=off, rtol=0)
    assert found.closed == mesh.closed


@pytest.mark.parametrize("name", ["ball", "bowl"])
def test_every_format_reads_a_mesh(name: str, tmp_path: Path) -> None:
    mesh = kit.mesh(name)
    tree, buffer = kit.gltf_tree(mesh)
    same(read_mesh(written(tmp_path, "a.obj", kit.obj(mesh))), mesh)
    for order in ("<", ">", ""):
        same(read_mesh(written(tmp_path, "a.ply", kit.ply(mesh, order))), mesh)
    for text in (False, True):
        same(read_mesh(written(tmp_path, "a.STL", kit.stl(mesh, text))), mesh, SINGLE)
    same(read_mesh(written(tmp_path, "a.glb", kit.glb(tree, buffer))), mesh, SINGLE)
    (tmp_path / "a.bin").write_bytes(buffer)
    for uri in ("a.bin", "data:application/octet-stream;base64," + base64.b64encode(buffer).decode()):
        tree["buffers"][0]["uri"] = uri
        same(read_mesh(written(tmp_path, "a.gltf", json.dumps(tree).encode())), mesh, SINGLE)


def polygons() -> tuple[TriangleMesh, list[list[int]]]:
    """A box of a quad on each side, one of them in two triangles, and a roof of five corners."""
    faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6], [0, 6, 2], [1, 3, 7, 5]]
    return kit.mesh("box"), faces


@pytest.mark.parametrize("order", ["<", ">", ""])
def test_polygons_become_triangles(order: str, tmp_path: Path) -> None:
    mesh, faces = polygons()
    found = read_mesh(written(tmp_path, "a.ply", kit.ply(mesh, order, faces)))
    assert found.closed
    assert found.triangles.shape == (12, 3)
    assert found.areas().sum() == pytest.approx(24)
    same(read_mesh(written(tmp_path, "b.ply", kit.ply(mesh, order, faces, length="i4"))), found)
    text = "".join(f"v {x} {y} {z}\n" for x, y, z in mesh.vertices)
    text += "".join(f"f {' '.join(str(k + 1) for k in face)}\n" for face in faces)
    found = read_mesh(written(tmp_path, "a.obj", text.encode()))
    assert found.closed
    assert found.areas().sum() == pytest.approx(24)


def test_polygons_of_fewer_than_three_corners_make_no_triangle_and_take_little_memory() -> None:
    lengths = np.random.default_rng(4).integers(0, 7, 400)
    values = np.arange(lengths.sum())
    ends = np.cumsum(lengths)
    fans = [(b, b + k, b + k + 1) for b, n in zip(ends - lengths, lengths, strict=True) for k in range(1, n - 1)]
    assert fans_of_lists(lengths, values).tolist() == [list(one) for one in fans]
    none = np.broadcast_to(np.zeros(1, np.int64), (1_000_000,))
    tracemalloc.start()
    try:
        assert fans_of_lists(none, np.zeros(0, np.int32)).shape == (0, 3)
        assert tracemalloc.get_traced_memory()[1] < 10 * none.size
    finally:
        tracemalloc.stop()


def test_numbers_of_vertices(tmp_path: Path) -> None:
    count = BALL.vertices.shape[0]
    density = np.linspace(0, 2, count).astype(np.float32)
    red = (np.arange(count) % 256).astype(np.uint8)
    more = {"density": density, "Length_2": density.astype(float), "red": red, "green": red, "blue": red, "alpha": red}
    for order in ("<", ">", ""):
        found = read_mesh(written(tmp_path, "a.ply", kit.ply(BALL, order, more=more)))
        assert list(found.attributes) == ["density", "length_2"]
        np.testing.assert_array_equal(found.attributes["density"], density)
        np.testing.assert_allclose(found.colours[127], ((127 / 255 + 0.055) / 1.055) ** 2.4, rtol=1e-5)
        assert found.colours[255].tolist() == [1, 1, 1]
    tree, buffer = kit.gltf_tree(BALL, _DENSITY=density, NORMAL=BALL.vertices.astype("<f4"))
    found = read_mesh(written(tmp_path, "a.glb", kit.glb(tree, buffer)))
    np.testing.assert_array_equal(found.attributes["density"], density)
    np.testing.assert_allclose(found.corner_normals, BALL.vertices[BALL.triangles], atol=SINGLE)
    assert read_mesh(written(tmp_path, "b.glb", kit.glb(*kit.gltf_tree(BALL)))).corner_normals is None


def test_a_texture_is_read_from_the_folder_and_from_nowhere_else(tmp_path: Path) -> None:
    inner = tmp_path / "inner"
    inner.mkdir()
    picture = np.arange(48, dtype=np.uint8).reshape(4, 4, 3)
    for folder in (tmp_path, inner):
        Image.fromarray(picture).save(folder / "skin colour.png")
    uv = np.zeros((BALL.triangles.shape[0], 3, 2))
    content = kit.obj(mesh_of(RawMesh(BALL.vertices, BALL.triangles, uv=uv), "ball")).replace(
        b"f 1", b"usemtl m\nf 1", 1
    )
    for name, there in (("skin colour.png", True), ("../skin colour.png", False), ("/etc/hostname", False)):
        (inner / "a.mtl").write_text(f"newmtl m\nmap_Kd {name}\n")
        found = read_mesh(written(inner, "a.obj", b"mtllib a.mtl\n" + content))
        assert (found.texture is not None) == there
        if there:
            np.testing.assert_array_equal(found.texture, picture)
        else:
            assert any("not in its folder" in note for note in found.notes)
    for name in ("http://example.org/a.bin", "../a.bin", "/etc/passwd", "none.bin", "file:///etc/passwd"):
        tree, buffer = kit.gltf_tree(BALL)
        (tmp_path / "a.bin").write_bytes(buffer)
        tree["buffers"][0]["uri"] = name
        with pytest.raises(UsageError):
            read_mesh(written(inner, "a.gltf", json.dumps(tree).encode()))


def test_a_sequence_keeps_its_triangles(tmp_path: Path) -> None:
    uv = np.random.default_rng(1).random((BALL.triangles.shape[0], 3, 2)).round(3)
    mesh = mesh_of(RawMesh(BALL.vertices, BALL.triangles, uv=uv), "ball")
    first = read_mesh(written(tmp_path, "a.obj", kit.obj(mesh)))
    flat = mesh.with_vertices(mesh.vertices * (1, 0, 1))  # vertices that come to the same place stay two
    later = read_mesh(written(tmp_path, "b.obj", kit.obj(flat)), like=first)
    assert later.triangles is first.triangles
    np.testing.assert_array_equal(later.vertices, first.vertices * (1, 0, 1))
    with pytest.raises(UsageError, match="vertices"):
        read_mesh(written(tmp_path, "c.obj", kit.obj(kit.mesh("box"))), like=first)


def test_what_is_no_mesh_is_refused_in_one_line(tmp_path: Path) -> None:
    tree, buffer = kit.gltf_tree(BALL)
    ball = kit.ply(BALL)
    begin = ball.index(b"end_header")
    cases = {
        "none.obj": None, "a.fbx": b"", "empty.obj": b"", "empty.ply": b"", "empty.stl": b"", "empty.glb": b"",
        "points.obj": b"v 0 0 0\nv 1 0 0\nv 0 1 0\n",
        "points.ply": ball[: ball.index(b"element face")] + b"end_header\n",
        "cut.ply": ball[:-3], "cut.stl": kit.stl(BALL)[:-3], "cut.glb": kit.glb(tree, buffer)[:-300],
        "many.ply": ball.replace(b"element face 512", b"element face 99999999999"),
        "lists.ply": ball[: begin + 11] + b"\xff" * (len(ball) - begin), "words.ply": kit.ply(BALL, "") + b"x",
        "nan.stl": kit.stl(BALL).replace(np.float32(1).tobytes(), np.float32(np.nan).tobytes()),
    }  # fmt: skip
    for name, content in cases.items():
        path = tmp_path / name
        if content is not None:
            path.write_bytes(content)
        with pytest.raises(UsageError) as told:
            read_mesh(path)
        text = str(told.value)
        assert text.startswith(f"{path}: "), text
        assert text.isprintable()
        assert len(text) - len(str(path)) < 300


def changed(change: str, value: object) -> dict:
    """A header with one entry, told by its path, set to another value."""
    tree, _ = kit.gltf_tree(BALL)
    place: object = tree
    *path, last = [int(part) if part.isdigit() else part for part in change.split(".")]
    for part in path:
        place = place[part]  # type: ignore[index]
    place[last] = value  # type: ignore[index]
    return tree


MANY: list[dict] = [{"children": list(range(1, 10_001))}, *({"mesh": 0} for _ in range(10_000))]


@pytest.mark.parametrize(
    ("change", "value"),
    [
        ("accessors.0.count", 10**12), ("accessors.0.count", -1), ("accessors.0.bufferView", 7),
        ("nodes", [{"mesh": 0}, {"children": [2]}, {"children": [1]}]), ("nodes", MANY),
        ("meshes.0.primitives.0.indices", 0), ("accessors", "none"), ("scenes", {}),
        ("extensionsRequired", ["KHR_draco_mesh_compression"]), ("meshes.0.primitives", [{}]),
        ("bufferViews", [{"buffer": 0, "byteOffset": 0, "byteLength": 6000}] * 100_000), ("buffers", []),
    ],
)  # fmt: skip
def test_headers_of_gltf_are_believed_in_nothing(change: str, value: object, tmp_path: Path) -> None:
    _, buffer = kit.gltf_tree(BALL)
    with pytest.raises(StrandError):
        read_mesh(written(tmp_path, "a.glb", kit.glb(changed(change, value), buffer)))


def test_small_words_that_name_much_are_refused_and_ordinary_meshes_are_not(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(bounded, "SPARE", 0)
    vertices, triangles = kit.head(128)
    head = TriangleMesh(vertices.round(6), triangles.astype(np.int32), vertices)
    faces = [*([0, 1, 2, 3] for _ in range(2)), *triangles.tolist()]
    for name, content in {
        "a.obj": kit.obj(head), "a.ply": kit.ply(head), "b.ply": kit.ply(head, faces=faces), "c.ply": kit.ply(head, ""),
    }.items():  # fmt: skip
        assert read_mesh(written(tmp_path, name, content)).triangles.shape[0] >= len(triangles)
    points = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n"
    header = (
        "ply\nformat {}\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 999\n"
    )
    text = header.format("ascii 1.0") + "property list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n"
    lists = "".join(f"property list uchar uchar {name}\n" for name in ("vertex_indices", *"abcdefghij"))
    binary = (header.format("binary_little_endian 1.0") + lists + "end_header\n").encode() + bytes(36)
    for name, content in {
        "fan.obj": points + b"f" + b" 1 2 3 4" * 9999 + b"\n", "many.obj": points + b"f 1 2 3\n" * 9999,
        "text.ply": text.encode() + b"3 0 1 2\n" * 999, "lists.ply": binary + (b"\3\0\1\2" + bytes(10)) * 998 +
        b"\3\0\1\2\1\0" + bytes(9),
    }.items():  # fmt: skip
        with pytest.raises(UsageError, match=r"[\d,]+ take [\d.]+ .?B of memory, of a file of"):
            read_mesh(written(tmp_path, name, content))
