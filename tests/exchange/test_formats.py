"""Formats of strands: what other programs write is read, and what is written is read again, bit for bit."""

from __future__ import annotations

import io
import struct
import tempfile
import zipfile
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Literal

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import abc_kit
import exchange_kit as kit
import mesh_kit
from strandcli.errors import UsageError
from strandcli.exchange.files import ReadOptions, read, write
from strandcli.exchange.strands import Attribute, Strands

EQUAL = [np.arange(12, dtype=np.float32).reshape(4, 3) + 100 * i for i in range(3)]


def check(found: Strands, strands: Sequence[kit.Strand]) -> None:
    """Points and where they begin are those of ``strands``, in every bit."""
    expected = kit.of(strands)
    assert found.first.tolist() == expected.first.tolist()
    assert found.points.dtype == np.float32
    assert found.points.tobytes() == expected.points.tobytes()


def npz(**arrays: object) -> bytes:
    file = io.BytesIO()
    np.savez(file, **arrays)  # type: ignore[arg-type]
    return file.getvalue()


def saved(values: object) -> bytes:
    file = io.BytesIO()
    np.save(file, values)  # type: ignore[arg-type]
    return file.getvalue()


def npy(strands: Sequence[kit.Strand], kind: str = "<f4", order: Literal["C", "F"] = "C") -> bytes:
    return saved(np.stack(strands).astype(kind, order))


WRITERS: dict[str, tuple[str, Callable[[Sequence[kit.Strand]], bytes]]] = {
    "hair": (".hair", kit.hair),
    "data": (".data", kit.data),
    "bin": (".bin", lambda strands: kit.data(strands, 4)),
    "ply": (".ply", kit.ply),
    "ply of big-endian doubles": (".ply", lambda strands: kit.ply(strands, ">", kind="double")),
    "ply as text": (".ply", lambda strands: kit.ply(strands, "")),
    "ply of edges": (".ply", lambda strands: kit.ply(strands, told="edge")),
    "ply of edges as text": (".ply", lambda strands: kit.ply(strands, "", told="edge")),
    "npz": (".npz", lambda strands: npz(points=kit.of(strands).points, first=kit.of(strands).first)),
    "abc": (".abc", abc_kit.archive),
    "obj": (".obj", kit.obj),
    "obj of segments": (".obj", lambda strands: kit.obj(strands, segments=True)),
    "obj that counts back": (".obj", lambda strands: kit.obj(strands, back=True)),
    "glb of strips": (".glb", lambda strands: mesh_kit.glb(*kit.gltf(strands))),
    "glb of pairs": (".glb", lambda strands: mesh_kit.glb(*kit.gltf(strands, 1, "<u4"))),
}
EVEN: dict[str, tuple[str, Callable[[Sequence[kit.Strand]], bytes]]] = {
    "hair": (".hair", lambda strands: kit.hair(strands, segments=False)),
    "tfx 3": (".tfx", kit.tfx3),
    "tfx 4": (".tfx", kit.tfx4),
    "npz": (".npz", lambda strands: npz(positions=np.stack(strands))),
    "npz of big-endian doubles": (".npz", lambda strands: npz(anything=np.stack(strands).astype(">f8"))),
    "npy": (".npy", npy),
    "npy of doubles in Fortran's order": (".npy", lambda strands: npy(strands, ">f8", "F")),
    "npz in Fortran's order": (".npz", lambda strands: npz(positions=np.asfortranarray(np.stack(strands)))),
}


@pytest.mark.parametrize("kind", WRITERS)
@settings(max_examples=12, deadline=None)
@given(strands=kit.lists_of_strands)
def test_strands_of_any_lengths_are_read(kind: str, strands: list[kit.Strand]) -> None:
    suffix, written = WRITERS[kind]
    check(kit.read_bytes(written(strands), suffix), strands)


@pytest.mark.parametrize("kind", EVEN)
@settings(max_examples=12, deadline=None)
@given(count=st.integers(1, 9), points=st.integers(2, 9), seed=st.integers(0, 99))
def test_strands_of_equal_lengths_are_read(kind: str, count: int, points: int, seed: int) -> None:
    suffix, written = EVEN[kind]
    strands = list(np.random.default_rng(seed).normal(size=(count, points, 3)).astype(np.float32))
    check(kit.read_bytes(written(strands), suffix), strands)


@pytest.mark.parametrize("suffix", [".hair", ".data", ".bin", ".ply", ".npz", ".abc", ".obj"])
@settings(max_examples=12, deadline=None)
@given(strands=kit.lists_of_strands)
def test_what_is_written_is_read_again(suffix: str, strands: list[kit.Strand]) -> None:
    with tempfile.TemporaryDirectory() as folder:
        path, again = Path(folder, f"a{suffix}"), Path(folder, f"b{suffix}")
        assert write(path, kit.of(strands)) == []
        found = read(path)
        check(found, strands)
        write(again, found)
        assert again.read_bytes() == path.read_bytes()


def test_a_hair_file_is_written_again_byte_for_byte(tmp_path: Path) -> None:
    strands = [*EQUAL, EQUAL[0][:2]]
    points = sum(map(len, strands))
    more = np.linspace(0, 1, 5 * points, dtype="<f4").tobytes()
    (tmp_path / "a.hair").write_bytes(kit.hair(strands, more=more, flags=4 | 8 | 16))
    found = read(tmp_path / "a.hair")
    assert {name: one.domain for name, one in found.attributes.items()} == dict.fromkeys(
        ("width", "transparency", "colour"), "point"
    )
    assert found.source.facts["info"] == "made up"
    defaults = kit.hair(EQUAL, segments=False)
    (tmp_path / "b.hair").write_bytes(defaults)
    write(tmp_path / "c.hair", read(tmp_path / "b.hair"))
    assert (tmp_path / "c.hair").read_bytes() == defaults


def test_bald_roots_are_skipped_and_counted() -> None:
    found = kit.read_bytes(kit.data([EQUAL[0], EQUAL[1][:1], EQUAL[1][:0], EQUAL[2]]), ".data")
    check(found, [EQUAL[0], EQUAL[2]])
    assert found.source.skipped == {"fewer than two points": 2}
    found = kit.read_bytes(kit.hair([EQUAL[0][:1], EQUAL[1]]), ".hair")
    check(found, [EQUAL[1]])
    assert found.source.skipped == {"fewer than two points": 1}


@pytest.mark.parametrize("name", ["a.data", "a.bin", "a"])
def test_data_and_bin_are_told_apart_by_size(name: str) -> None:
    suffix = name[1:] or ".data"
    assert kit.read_bytes(kit.data(EQUAL), suffix).source.format == ".data"
    found = kit.read_bytes(kit.data(EQUAL, 4), suffix)
    assert found.source.format == ".bin"


def test_strands_of_tressfx_keep_what_they_carry() -> None:
    found = kit.read_bytes(kit.tfx4(EQUAL), ".tfx")
    assert found.attributes["uv"].values.tolist() == [[0, 0.5], [1, 0.5], [2, 0.5]]
    assert found.attributes["movable"].values.reshape(3, 4).tolist() == [[0, 0, 1, 1]] * 3


def test_vertices_alone_ask_for_the_stride() -> None:
    content = kit.ply(EQUAL, told="nothing")
    with pytest.raises(UsageError, match=r"12 of them, .*--stride N \(they divide into strands of 2, 3, 4, 6, 12\)"):
        kit.read_bytes(content, ".ply")
    check(kit.read_bytes(content, ".ply", ReadOptions(stride=4)), EQUAL)
    with pytest.raises(UsageError, match="5 does not divide them"):
        kit.read_bytes(content, ".ply", ReadOptions(stride=5))


def test_arrays_beside_the_positions_are_kept(tmp_path: Path) -> None:
    arrays = {
        "positions": np.stack(EQUAL), "root_uv": np.arange(6.0).reshape(3, 2), "weight": np.arange(12).reshape(3, 4),
        "other": np.zeros((7, 2)), "words": np.array(["a"]),
    }  # fmt: skip
    (tmp_path / "a.npz").write_bytes(npz(**arrays))
    found = read(tmp_path / "a.npz")
    assert {name: one.domain for name, one in found.attributes.items()} == {"root_uv": "strand", "weight": "point"}
    assert found.source.facts["arrays_not_read"] == ["other"]
    write(tmp_path / "b.npz", found)
    with np.load(tmp_path / "b.npz") as again:
        assert again["root_uv"].tolist() == arrays["root_uv"].tolist()
        assert again["weight"].tolist() == arrays["weight"].tolist()


def test_of_several_arrays_of_strands_one_is_asked_for() -> None:
    content = npz(a=np.stack(EQUAL), b=np.stack(EQUAL[:2]))
    with pytest.raises(UsageError, match=r"a \(3, 4, 3\), b \(2, 4, 3\); choose one with --array"):
        kit.read_bytes(content, ".npz")
    check(kit.read_bytes(content, ".npz", ReadOptions(array="b")), EQUAL[:2])


def test_a_format_is_told_by_the_first_bytes(tmp_path: Path) -> None:
    check(kit.read_bytes(kit.hair(EQUAL), ".data"), EQUAL)
    check(kit.read_bytes(kit.ply(EQUAL), ".anything"), EQUAL)
    with pytest.raises(UsageError, match="no file of strands that is known"):
        kit.read_bytes(b"\x89PNG\r\n", ".png")
    with pytest.raises(UsageError, match="let the name end in one of"):
        write(tmp_path / "a.png", kit.of(EQUAL))


def test_what_a_format_does_not_hold_is_told(tmp_path: Path) -> None:
    strands = kit.of(EQUAL)
    uv = {"uv": Attribute("strand", np.zeros((3, 2), np.float32))}
    assert write(tmp_path / "a.hair", Strands(strands.first, strands.points, uv)) == [".hair cannot store uv: left out"]
    assert write(tmp_path / "a.npz", Strands(strands.first, strands.points, uv)) == []


def test_colours_of_strands_become_those_of_their_points_where_a_format_has_no_others(tmp_path: Path) -> None:
    strands, values = kit.of([EQUAL[0], EQUAL[1][:2]]), np.arange(6, dtype=np.float32).reshape(2, 3)
    for suffix in (".hair", ".ply"):
        path = tmp_path / f"a{suffix}"
        assert write(path, Strands(strands.first, strands.points, {"colour": Attribute("strand", values)})) == []
        found = read(path).attributes["colour"]
        assert found.domain == "point"
        np.testing.assert_array_equal(found.values, np.repeat(values, strands.counts(), axis=0))


@pytest.mark.parametrize("name", ["a.hair", "a.ply", "a.npz", "a.npy", "a.abc", "a.usda"])
def test_a_width_of_all_strands_is_kept(tmp_path: Path, name: str) -> None:
    strands = kit.of(EQUAL)
    width = {"width": Attribute("groom", np.array([0.25], np.float32))}
    assert not write(tmp_path / name, Strands(strands.first, strands.points, width))
    found = read(tmp_path / name).attributes["width"]
    assert (found.values == 0.25).all()


def test_a_thickness_that_nobody_set_is_no_width(tmp_path: Path) -> None:
    write(tmp_path / "a.hair", kit.of(EQUAL))
    assert "width" not in read(tmp_path / "a.hair").attributes


def test_longer_strands_than_a_format_can_tell_are_refused(tmp_path: Path) -> None:
    long = [np.zeros((65_537, 3), np.float32), EQUAL[0]]
    with pytest.raises(UsageError, match=r"65,536 segments, \.hair at most 65,535"):
        write(tmp_path / "a.hair", kit.of(long))
    write(tmp_path / "a.ply", kit.of(long))
    check(read(tmp_path / "a.ply"), long)


def test_several_moments_need_a_format_that_takes_them(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"has one moment only; write \.abc"):
        write(tmp_path / "a.hair", kit.of(EQUAL), [])


def nan_at(content: bytes, at: int) -> bytes:
    return content[:at] + struct.pack("<f", float("nan")) + content[at + 4 :]


@pytest.mark.parametrize(
    ("content", "suffix", "message"),
    [
        (kit.hair(EQUAL)[:-1], ".hair", "byte 8: points: 12 need 144 bytes, the file has 143 bytes"),
        (kit.hair(EQUAL) + b"x", ".hair", "1 byte after what the header declares"),
        (b"HAIR" + b"\xff" * 124, ".hair", "byte 12: flags: 0xffffffff"),
        (b"HAIR" + struct.pack("<4I", 4_000_000_000, 9, 3, 0) + bytes(108), ".hair", "byte 4: segments: 4,000,000,000"),
        (nan_at(kit.hair(EQUAL), 128 + 6 + 12 * 5 + 4), ".hair", "byte 194: points: number 5 is not finite"),
        (nan_at(kit.data(EQUAL), 4 + 4 + 48 + 4 + 24), ".data", "byte 84: points: number 6 is not finite"),
        (struct.pack("<2i", 1, 2**31 - 1) + bytes(24), ".data", "byte 4: points of strand 0: 2,147,483,647"),
        (kit.data(EQUAL)[:-4], ".data", "byte 108: points of strand 2: 4, the file has 3 more"),
        (struct.pack("<f", 2.5) + bytes(200), ".tfx", "byte 0: version: 2.5 is not known"),
        (struct.pack("<f2I", 3.0, 2**24, 0) + bytes(300), ".tfx", "byte 8: vertices a strand: 0"),
        (kit.tfx4(EQUAL)[:170], ".tfx", "byte 4: strands: 12 need 192 bytes"),
        (kit.tfx4(EQUAL)[:12] + b"\xff" * 4 + kit.tfx4(EQUAL)[16:], ".tfx", "byte 12: offset of positions"),
        (kit.ply(EQUAL)[:-1], ".ply", "element strand: 3 need 6 bytes, the file has 5 bytes"),
        (b"ply\nformat ascii 2.0\n", ".ply", "byte 4: header: 'format ascii 2.0'"),
        (npz(positions=np.full((2, 3, 3), np.inf)), ".npz", "byte 0: positions: number 0 is not finite, and 5 more"),
        (npz(positions=np.zeros((2, 3, 2))), ".npz", "no array of floating-point numbers of shape"),
        (b"PK\3\4" + bytes(60), ".npz", "no list of members"),
        (b"v 0 0 0\nv 1 1 1\nl 1 3\n", ".obj", "line 3: 'l' wants 'v' 3 of 2"),
        (b"v 0 0 0\nl -1 -2\n", ".obj", "line 2: '-2': indices count from 1"),
        (b"v 0 0 0\nl 1 x\n", ".obj", "line 2: 'x': is no corner"),
        (b"v 0 0 0\n#\nv 0 nan 0\nl 1 2\n", ".obj", "line 3: vertex of a strand is not finite"),
        (b"v 0 0 0\n", ".obj", "byte 0: has no lines"),
        (b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", ".obj", "is a mesh, neither a preset nor strands: it has no lines"),
        (saved(np.zeros((4, 3))), ".npy", "byte 0: header: an array of float64 of shape (4, 3)"),
        (saved(np.zeros((4, 3, 5))), ".npy", "or 4 with widths"),
        (saved(np.zeros((4, 3, 3)))[:-8], ".npy", "needs 288 bytes, the file has 280 bytes"),
        (saved(np.array([[[print]]])), ".npy", "declares no array of numbers"),
        (saved(np.zeros((4, 3, 3))).replace(b"(4, 3, 3)", b"(4000000000, 3, 3)")[:-11], ".npy", "needs 288 GB"),
        (saved(np.full((2, 3, 3), np.nan, "<f4")), ".npy", "byte 128: points: number 0 is not finite, and 5 more"),
    ],
)  # fmt: skip
def test_bad_files_are_refused_by_field_and_byte(content: bytes, suffix: str, message: str) -> None:
    kit.refused(content, suffix, message)


def test_packed_zeros_are_not_unpacked_on_their_word(tmp_path: Path) -> None:
    header = {"descr": "<f4", "fortran_order": False, "shape": (100_000, 100, 3)}
    packed = zipfile.ZipFile(tmp_path / "a.npz", "w", zipfile.ZIP_DEFLATED)
    with packed as archive, archive.open("positions.npy", "w", force_zip64=True) as member:
        np.lib.format.write_array_header_1_0(member, header)
        for _ in range(120):
            member.write(bytes(1_000_000))
    with pytest.raises(UsageError, match=r"120 MB unpacked, .* more than is believed"):
        read(tmp_path / "a.npz")
