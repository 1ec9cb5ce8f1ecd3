"""Strands as lines of .obj and glTF, and as one array of numpy."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import exchange_kit as kit
import mesh_kit
from cli_runs import Runner
from strandcli.errors import UsageError
from strandcli.exchange import bounded
from strandcli.exchange.files import read, write
from strandcli.exchange.strands import Attribute, Strands, even_offsets

TWO = [np.float32([[0, 0, 0], [0, 1, 0], [0, 2, 1]]), np.float32([[1, 0, 0], [1, 1, 0]])]


def file(tmp_path: Path, name: str, content: bytes) -> Path:
    path = tmp_path / name
    path.write_bytes(content)
    return path


def test_loops_end_where_they_begin_and_nodes_place_lines(tmp_path: Path) -> None:
    path = file(tmp_path, "a.glb", mesh_kit.glb(*kit.gltf(TWO[:1], 2, translation=[0, 0, 5], scale=[2, 1, 1])))
    found = read(path)
    wanted = np.concatenate([TWO[0], TWO[0][:1]]) * np.float32([2, 1, 1]) + np.float32([0, 0, 5])
    assert found.points == pytest.approx(wanted)
    assert (found.source.unit, found.source.up) == (1.0, "y")


def test_lines_of_obj_may_name_textures_and_go_on_in_the_next_line(tmp_path: Path) -> None:
    content = b"v 0 0 0 1 1 1\nv 0 1 0 1 1 1\nv 0 2 1 1 1 1\nvt 0 0\nl 1/1 2/1 \\\n 3/\nl 3\n"
    found = read(file(tmp_path, "a.obj", content))
    assert (found.points == TWO[0]).all()
    assert found.source.skipped == {"fewer than two points": 1}


def test_lines_that_name_a_vertex_often_take_no_memory_for_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bounded, "SPARE", 0)
    tree, buffer = kit.gltf(TWO)
    tree["nodes"] *= 999
    tree["scenes"][0]["nodes"] = list(range(len(tree["nodes"])))
    for name, content, words in (
        ("a.obj", b"v 0 0 0\nl" + 5000 * b" 1" + b"\n", "5,000 take 80 kB of memory, of a file of 10 kB"),
        ("a.glb", mesh_kit.glb(tree, buffer), r"[\d,]+ take [\d.]+ kB of memory, of a file of .*; write fewer"),
    ):
        with pytest.raises(UsageError, match=f"points of its lines: {words}"):
            read(file(tmp_path, name, content))


def test_the_fourth_number_of_a_npy_is_the_width(tmp_path: Path) -> None:
    points, width = np.arange(18, dtype=np.float32).reshape(6, 3), np.linspace(0.1, 0.2, 6, dtype=np.float32)
    strands = Strands(even_offsets(2, 3), points, {"width": Attribute("point", width)})
    assert write(tmp_path / "a.npy", strands) == []
    assert np.load(tmp_path / "a.npy").shape == (2, 3, 4)
    found = read(tmp_path / "a.npy")
    assert (found.points == points).all()
    assert (found.attributes["width"].values == width).all()
    with pytest.raises(UsageError, match="equally many points; make them so with --resample N"):
        write(tmp_path / "b.npy", kit.of(TWO))


def test_info_convert_and_render_take_lines(run: Runner, tmp_path: Path) -> None:
    strands = [np.float32([[k, 0, 0], [k, 1, 0], [k, 2, 1]]) for k in range(3)]
    both = kit.obj(strands) + b"f 1 2 3\n"
    file(tmp_path, "a.obj", kit.obj(strands))
    file(tmp_path, "b.obj", both)
    assert "strands    3" in run("info", "a.obj").out
    assert "3 lines, which 'render' and 'convert' read as strands" in run("info", "b.obj").out
    file(tmp_path, "one.obj", kit.obj(strands[:1]) + b"f 1 2 3\n")
    assert "1 line, which" in run("info", "one.obj").out
    assert run("convert", "b.obj", "b.npy").code == 0
    assert np.load(tmp_path / "b.npy").shape == (3, 3, 3)
    found = run.fine("render", "b.obj", "--size", "32x24", "--quality", "draft", "-o", "o")
    assert "b.obj: not read, beside its strands: polygons (1)" in found.err
    assert (tmp_path / "o" / "frame_0001.png").is_file()


def test_objects_of_obj_and_gltf_keep_their_names(tmp_path: Path) -> None:
    first = read(
        file(tmp_path, "a.obj", b"g cap\n" + kit.obj(TWO).replace(b"strand1", b"two words") + b"g none\nl 1 2\n")
    )
    assert first.objects == ("strand0", "two words")
    assert first.attributes["object"].values.tolist() == [0, 1, 1]
    assert write(tmp_path / "b.obj", first) == []
    again = read(tmp_path / "b.obj")
    assert again.objects == first.objects
    assert (again.points == first.points).all()
    assert read(file(tmp_path, "c.obj", b"v 0 0 0\nv 1 1 1\nl 1 2\n")).objects == ()
    tree, buffer = kit.gltf(TWO)
    tree["nodes"] = [{"mesh": 0, "name": "brows"}, {"mesh": 0, "translation": [1, 0, 0]}]
    tree["scenes"] = [{"nodes": [0, 1]}]
    found = read(file(tmp_path, "d.glb", mesh_kit.glb(tree, buffer)))
    assert found.objects == ("brows", "mesh0")
    assert found.attributes["object"].values.tolist() == [0, 0, 1, 1]
