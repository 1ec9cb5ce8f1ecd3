"""Wavefront OBJ: corners however they are written, blocks of lines, colours and materials."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import mesh_kit as kit
from strandcli.errors import UsageError
from strandcli.exchange import obj_file
from strandcli.meshes.make import RawMesh, mesh_of
from strandcli.meshes.read import read_mesh

VERTICES, TRIANGLES = kit.sphere(2)
GENERATOR = np.random.default_rng(2)
UV, NORMALS = GENERATOR.random((40, 2)).round(3), GENERATOR.normal(size=(30, 3)).round(3)
OF_UV, OF_NORMAL = (GENERATOR.integers(1, count + 1, TRIANGLES.shape) for count in (40, 30))
WAYS = {"v": "{v}", "v/t": "{v}/{t}", "v//n": "{v}//{n}", "v/t/n": "{v}/{t}/{n}", "v/t/": "{v}/{t}/"}


def text(ways: list[str], back: bool = False, end: str = "\n") -> bytes:
    """The sphere, with corners that are written in one way after the other; ``back``: they count back."""
    rows = [("v", VERTICES), ("vt", UV), ("vn", NORMALS)]
    lines = [f"{name} {' '.join(map(repr, row))}" for name, values in rows for row in values.tolist()]
    less = [len(values) + 1 if back else 0 for _, values in rows]
    for k, (v, t, n) in enumerate(zip(TRIANGLES + 1, OF_UV, OF_NORMAL, strict=True)):
        way = WAYS[ways[k % len(ways)]]
        corners = [way.format(v=a - less[0], t=b - less[1], n=c - less[2]) for a, b, c in zip(v, t, n, strict=True)]
        lines.append("f " + " ".join(corners))
    return (end.join(["# a sphere", "o one", *lines]) + end).encode()


def expected(ways: list[str]) -> RawMesh:
    """The same from arrays; corners that name no uv have 0, and those that name no normal a smooth one."""
    has = [np.array([letter in ways[k % len(ways)] for k in range(len(TRIANGLES))]) for letter in "tn"]
    uv = np.where(has[0][:, None, None], UV[OF_UV - 1], 0.0)
    normals = np.concatenate([[[0.0, 0, 0]], NORMALS])
    rows = np.where(has[1][:, None], OF_NORMAL, 0)
    return RawMesh(
        VERTICES, TRIANGLES, normals if has[1].any() else None, uv if has[0].any() else None, normal_rows=rows
    )


@pytest.mark.parametrize(("block", "back"), [(64, True), (1000, False), (1 << 20, False)])
@pytest.mark.parametrize("ways", [["v"], ["v//n"], ["v", "v/t/n"], ["v/t", "v//n", "v/t/"]])
def test_corners_in_every_way(
    ways: list[str], back: bool, block: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(obj_file, "BLOCK", block)
    path = tmp_path / "a.obj"
    path.write_bytes(text(ways, back, "\r\n" if block == 1000 else "\n"))
    found, wanted = read_mesh(path), mesh_of(expected(ways), "a")
    np.testing.assert_array_equal(found.vertices, wanted.vertices)
    np.testing.assert_array_equal(found.triangles, wanted.triangles)
    for one, other in ((found.uv, wanted.uv), (found.corner_normals, wanted.corner_normals)):
        assert (one is None) == (other is None)
        if one is not None and other is not None:
            np.testing.assert_allclose(one, other, atol=1e-6)


def test_colours_and_the_picture_of_the_first_material(tmp_path: Path) -> None:
    for name, colour in (("red one.png", (255, 0, 0)), ("blue.png", (0, 0, 255))):
        Image.new("RGB", (4, 4), colour).save(tmp_path / name)
    (tmp_path / "a.mtl").write_text(
        "newmtl blue\nmap_Kd -s 1 1 1 blue.png\nnewmtl red\nKd 1 0 0\nmap_Kd red one.png\nnewmtl bare\n"
    )
    lines = [f"v {x} {y} {z} 1 0.5 0" for x, y, z in np.eye(3)]
    faces = ["usemtl bare", "vt 0 0", "usemtl red", "f 1/1 2/1 3/1", "usemtl blue", "f 1/1 3/1 2/1"]
    (tmp_path / "a.obj").write_text("\n".join(["mtllib a.mtl", *lines, *faces]))
    found = read_mesh(tmp_path / "a.obj")
    assert found.texture[0, 0].tolist() == [255, 0, 0]
    assert any("2 textures" in note for note in found.notes)
    np.testing.assert_allclose(found.colours, [[1, ((0.5 + 0.055) / 1.055) ** 2.4, 0]] * 3, rtol=1e-5)


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ("f 1 2 0", "line 4: '0'"), ("f 1 2 -4", "line 4: '-4'"), ("f 1 2 9", "line 4: 'f' wants 'v' 9 of 3"),
        ("f 1 2 1/x", "line 4: '1/x': is no corner"), ("f 1/1 2/1 3/1", "line 4: 'f' wants 'vt' 1 of 0"),
        ("f 1 2 x", "line 4: 'x': is no corner"), ("f 1/ 2//x 3", "line 4: '2//x': is no corner"),
        ("v 1 2 x", "line 4: 'v' with what is no number: '1 2 x'"), ("v 1 2 3\nv 1,5 2 3", "line 5: 'v' with"),
        ("v nan 1 2\nf 1 2 4", "line 4: vertex (nan, 1, 2) of a polygon is not finite"),
        ("f 1 2 99999999999999999999", "line 4: 'f' wants 'v'"), ("l " + "1 " * (3 << 20), "no end of line"),
    ],
)  # fmt: skip
def test_damaged_lines_are_told(wrong: str, words: str, tmp_path: Path) -> None:
    path = tmp_path / "a.obj"
    path.write_text(f"v 0 0 0\nv 1 0 0\nv 0 1 0\n{wrong}\n" + ("f 1 2 3\n" if wrong[0] == "v" else ""))
    with pytest.raises(UsageError) as told:
        read_mesh(path)
    assert words in str(told.value)
    assert str(told.value).isprintable()
    assert len(str(told.value)) - len(str(path)) < 300


def test_lines_that_go_on_and_on_take_no_time(tmp_path: Path) -> None:
    path = tmp_path / "a.obj"
    path.write_bytes(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 \\\r\n" + b"\\\n" * 500_000 + b"3\n")
    assert read_mesh(path).triangles.shape == (1, 3)
